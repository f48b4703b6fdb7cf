/** Photo mode: the world stands still, the camera is free, and pictures are saved larger than the screen. */
import type { Demo } from "../demo";
import { element, say } from "./words";

const HELP =
  "photo: drag turns, the wheel or two fingers zoom, I J K O U M fly, [ ] narrow and widen, Enter saves, P goes on";

/** Width and height of a saved picture of the shape of a canvas and a longer side; even, as most programs like it. */
export function pictureSize(width: number, height: number, longer: number): [number, number] {
  const scale = longer / Math.max(1, width, height);
  return [width, height].map((side) => 2 * Math.max(1, Math.round((side * scale) / 2))) as [number, number];
}

export class Photo {
  on = false;
  private before = "chase" as Demo["cameras"]["name"];
  private readonly demo: Demo;
  private readonly canvas: HTMLCanvasElement;

  constructor(demo: Demo, canvas: HTMLCanvasElement) {
    this.demo = demo;
    this.canvas = canvas;
    this.button("save-photo", () => void this.save());
    this.button("end-photo", () => this.toggle());
  }

  /** Begin or end it. */
  toggle(): void {
    this.on = !this.on;
    const { cameras } = this.demo;
    if (this.on) this.before = cameras.name;
    cameras.choose(this.on ? "free" : this.before);
    document.body.classList.toggle("photo", this.on);
    element("message").hidden = true;
    if (this.on) say(HELP, 6);
  }

  /** Save what the camera sees; the page's canvas is as before afterwards. */
  async save(): Promise<void> {
    const { canvas, demo } = this;
    const [width, height] = pictureSize(canvas.clientWidth, canvas.clientHeight, Number(demo.settings.photo));
    const file = await demo.picture(width, height);
    if (!file) return say("The browser could not make a picture of this size.", 5);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(file);
    link.download = `neve-drive-${new Date().toISOString().slice(0, 19).replace(/:/g, "-")}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    say(`saved ${link.download}, ${width} × ${height}`, 3);
  }

  private button(id: string, action: () => void): void {
    const place = element(id);
    place.addEventListener("click", () => {
      place.blur(); // or Enter would press it once more
      action();
    });
  }
}

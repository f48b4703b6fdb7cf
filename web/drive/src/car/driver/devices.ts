/** Keyboard, gamepads, thumbs and mouse of a page. */
import "./touch.css";
import type { CameraInput } from "./cameras";
import type { Controls } from "./controls";
import { Edges, fromKeys, fromPad, fromThumbs, merge, Smoothing, type Pad, type Presses } from "./input";

/** Keys that scroll the page or press a button if they are let through. */
const OURS = new Set(["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Space"]);
/** How far the camera turns for a drag over the whole height of the canvas [rad]. */
const DRAG = Math.PI;

export class Devices {
  private readonly keys = new Set<string>();
  /** Keys that went down since the last reading: a tap shorter than a frame counts too. */
  private readonly tapped = new Set<string>();
  private readonly smoothing = new Smoothing();
  private readonly edges = new Edges();
  private readonly leave = new AbortController();
  private readonly left: Thumb;
  private readonly right: Thumb;
  private drag = { x: 0, y: 0, zoom: 0 };

  /** Listen to the page; mouse and wheel on `canvas`. The thumbs' zones are laid over `page`. */
  constructor(canvas: HTMLElement, page: HTMLElement = document.body) {
    const { signal } = this.leave;
    addEventListener("keydown", (event) => this.press(event), { signal });
    addEventListener("keyup", ({ code }) => this.keys.delete(code), { signal });
    // Without the focus, no key would ever be let go.
    addEventListener("blur", () => this.keys.clear(), { signal });
    this.left = new Thumb(page, "left", signal);
    this.right = new Thumb(page, "right", signal);
    this.watchMouse(canvas, signal);
  }

  /** What is asked for now, smoothed over dt [s], and what was pressed since the last call. */
  read(dt: number): { controls: Controls; presses: Presses } {
    const pads = (navigator.getGamepads?.() ?? []).filter(
      (pad) => pad !== null && pad.mapping === "standard",
    );
    const thumbs = fromThumbs({ left: this.left.x, right: this.right.y });
    const tapped = new Set(this.tapped);
    const keys = new Set([...this.keys, ...tapped]);
    this.tapped.clear();
    const asked = merge(fromKeys(keys), thumbs, ...pads.map((pad) => fromPad(pad as Pad)));
    const button = (index: number) => pads.some((pad) => pad?.buttons[index]?.pressed);
    const pressed = this.edges.update({
      reset: asked.reset,
      camera: button(2),
      lights: button(1),
      figures: false,
    });
    // A key that goes down is a press by itself.
    const presses = {
      ...pressed,
      camera: pressed.camera || tapped.has("KeyC"),
      lights: pressed.lights || tapped.has("KeyL"),
      figures: tapped.has("KeyF"),
    };
    return { controls: this.smoothing.follow(asked, dt), presses };
  }

  /** How the camera was dragged and zoomed since the last call, and how the keys I J K O U M move it. */
  readCamera(): CameraInput {
    const { x, y, zoom } = this.drag;
    this.drag = { x: 0, y: 0, zoom: 0 };
    const axis = (more: string, less: string) =>
      (this.keys.has(more) ? 1 : 0) - (this.keys.has(less) ? 1 : 0);
    return {
      turn: x,
      tilt: y,
      zoom,
      ahead: axis("KeyI", "KeyK"),
      right: axis("KeyO", "KeyU"),
      up: axis("KeyJ", "KeyM"),
    };
  }

  /** Stop listening. */
  dispose(): void {
    this.leave.abort();
    this.left.zone.remove();
    this.right.zone.remove();
  }

  private press(event: KeyboardEvent): void {
    const writing = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
    if (writing || event.ctrlKey || event.metaKey || event.altKey) return;
    if (OURS.has(event.code)) event.preventDefault();
    this.keys.add(event.code);
    if (!event.repeat) this.tapped.add(event.code);
  }

  private watchMouse(canvas: HTMLElement, signal: AbortSignal): void {
    canvas.addEventListener("pointerdown", ({ pointerId }) => canvas.setPointerCapture(pointerId), {
      signal,
    });
    canvas.addEventListener(
      "pointermove",
      ({ buttons, movementX, movementY }) => {
        if (buttons === 0) return;
        const scale = DRAG / Math.max(1, canvas.clientHeight);
        this.drag.x += movementX * scale;
        this.drag.y += movementY * scale;
      },
      { signal },
    );
    const zoom = (event: WheelEvent) => {
      event.preventDefault();
      this.drag.zoom += event.deltaY / 500;
    };
    canvas.addEventListener("wheel", zoom, { signal, passive: false });
  }
}

/** A zone of the screen for one thumb. */
class Thumb {
  readonly zone: HTMLElement;
  /** Way of the thumb from where it was put down, in the size of the zone; null while it is up. */
  x: number | null = null;
  y: number | null = null;

  constructor(page: HTMLElement, side: "left" | "right", signal: AbortSignal) {
    this.zone = document.createElement("div");
    this.zone.className = `thumb ${side}`;
    page.append(this.zone);
    let start = { x: 0, y: 0 };
    const lift = () => {
      this.x = this.y = null;
      this.zone.classList.remove("held");
    };
    this.zone.addEventListener(
      "pointerdown",
      (event) => {
        this.zone.setPointerCapture(event.pointerId);
        this.zone.classList.add("held");
        start = { x: event.clientX, y: event.clientY };
        this.x = this.y = 0;
      },
      { signal },
    );
    this.zone.addEventListener(
      "pointermove",
      (event) => {
        if (this.x === null) return;
        this.x = (event.clientX - start.x) / Math.max(1, this.zone.clientWidth);
        this.y = (start.y - event.clientY) / Math.max(1, this.zone.clientHeight);
      },
      { signal },
    );
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      this.zone.addEventListener(end, lift, { signal });
    }
  }
}

/** Frame after frame: devices, world, picture, sound and the words about them. */
import type { Devices, KeyPresses } from "../car/driver/devices";
import type { Presses } from "../car/driver/input";
import { clock, tellCourse, type Event } from "../course/course";
import { SEED, type Demo } from "../demo";
import { tellBridge } from "./bridge_words";
import { Dash } from "./dash";
import { Smooth, lines } from "./figures";
import { Photo } from "./photo";
import { keepBest } from "./records";
import { Sharpness } from "./sharpness";
import { mixOf, Sound } from "./sound";
import { element, say } from "./words";

/** How often the words of the page change [ms]. */
const WORDS = 100;
/** How much one press narrows or widens the lens. */
const LENS = 1.12;

export class Loop {
  readonly photo: Photo;
  private readonly sound = new Sound();
  private readonly dash = new Dash();
  private readonly mean = new Smooth();
  private readonly sharpness = new Sharpness(window.devicePixelRatio);
  private last = 0;
  private told = 0;
  private readonly demo: Demo;
  private readonly devices: Devices;
  private readonly canvas: HTMLCanvasElement;

  constructor(demo: Demo, devices: Devices, canvas: HTMLCanvasElement) {
    this.demo = demo;
    this.devices = devices;
    this.canvas = canvas;
    this.photo = new Photo(demo, canvas);
  }

  /** Begin. A hidden tab gets no frames; what the snow missed comes in its next update. */
  start(): void {
    addEventListener("resize", () => this.fit());
    this.fit();
    this.last = performance.now();
    requestAnimationFrame((now) => this.frame(now));
  }

  async switchSound(): Promise<void> {
    const on = await this.sound.toggle();
    say(on ? "sound on" : "sound off", 1.5);
  }

  private fit(): void {
    const { canvas } = this;
    this.demo.resize(canvas.clientWidth, canvas.clientHeight, this.sharpness.ratio);
  }

  private frame(now: number): void {
    requestAnimationFrame((next) => this.frame(next));
    const dt = Math.max(0, (now - this.last) / 1e3);
    this.last = now;
    const { demo, devices, photo } = this;
    if (demo.held) return;
    if (this.sharpness.take(dt)) this.fit();
    const { controls, presses } = devices.read(dt);
    this.answer(presses);
    const aimed = devices.readCamera();
    if (photo.on) demo.look(dt, aimed);
    else demo.advance(dt, controls, aimed);
    demo.draw();
    if (presses.save && photo.on) void photo.save();
    const { state } = demo.car;
    const heard = { ...state, enginePower: photo.on ? 0 : state.enginePower };
    this.sound.update(mixOf(heard, demo.cameras.name === "cockpit"));
    if (!photo.on) this.hear(demo.company.event);
    const smooth = this.mean.take(dt, dt);
    if (now - this.told < WORDS) return;
    this.told = now;
    this.write(smooth);
  }

  private answer(presses: Presses & KeyPresses): void {
    const { demo, photo } = this;
    if (presses.camera && !photo.on) say(`${demo.cameras.next()} camera`, 1.5);
    if (presses.lights) demo.switchLights();
    if (presses.figures) element("figures").hidden = !element("figures").hidden;
    if (presses.sound) void this.switchSound();
    if (presses.course && !photo.on) demo.toCourse();
    if (presses.photo) photo.toggle();
    if (photo.on && presses.lens !== 0) demo.cameras.widen(LENS ** presses.lens);
  }

  private hear(event: Event | null): void {
    const { best } = this.demo.company.course;
    if (event === "started") say("go!", 1.2);
    if (event === "finished") say("finished", 2);
    if (event !== "record" || !best) return;
    const kept = keepBest(SEED, best);
    say(`best time: ${clock(best.time)}${kept ? "" : "\nThe browser keeps nothing for this page."}`, 4);
  }

  private write(frame: number): void {
    const { demo } = this;
    this.dash.show(demo.reading());
    put("course", tellCourse(demo.company.course));
    const both = demo.company.both();
    put("bridge", both ? tellBridge(demo.company.played!, both) : "");
    if (!element("figures").hidden) element("figures").textContent = lines(demo.cost(frame)).join("\n");
  }
}

/** Put words into a corner of the page; without words it is not there. */
function put(id: string, text: string): void {
  const place = element(id);
  place.hidden = text === "";
  if (place.textContent !== text) place.textContent = text;
}

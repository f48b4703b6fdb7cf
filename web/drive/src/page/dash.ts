import { element } from "./words";

/** What the driver reads while driving. */
export interface Reading {
  readonly speed: number; // m/s
  readonly gear: string;
  readonly type: string; // of the snow under the car, in words
  readonly depth: number; // m, of the snow under the car
  readonly sinkage: readonly number[]; // m, of each wheel
}

/** The corner of the page that tells speed and snow; made once, then only its words change. */
export class Dash {
  private readonly speed = document.createElement("div");
  private readonly under = document.createElement("div");

  constructor() {
    this.speed.className = "speed";
    this.under.className = "under";
    element("dash").replaceChildren(this.speed, this.under);
  }

  /** Show a reading. */
  show(reading: Reading): void {
    this.write(this.speed, Math.abs(reading.speed * 3.6).toFixed(0));
    const deepest = Math.max(0, ...reading.sinkage);
    this.write(
      this.under,
      `gear ${reading.gear}\n${reading.type}, ${(100 * reading.depth).toFixed(0)} cm deep\n` +
        `wheels ${(100 * deepest).toFixed(0)} cm in`,
    );
  }

  private write(place: HTMLElement, text: string): void {
    if (place.textContent !== text) place.textContent = text; // else each frame would lay out the page anew
  }
}

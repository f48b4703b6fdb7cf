// How many particles a picture takes: fewer and larger ones when they are smaller than a pixel, and while something moves
// if the picture would take too long; all of them when everything is still.

import { PARTICLE_BYTES } from "../protocol.js";

const SHORT = 22; // ms between two pictures, below which there is time for more particles
const LONG = 40; // ms, above which there are too many
const LEAST = 20_000; // particles that are always drawn
const FULL = 16_000_000;
const STILL = 350; // ms without a change until all are drawn
const FINE = 1.2; // px between particles that are drawn, at least
export const MOST_SKIPPED = Math.floor(255 / PARTICLE_BYTES); // as far apart as WebGL reads numbers

export class Detail {
  /** @param {boolean} software whether the processor draws */
  constructor(software) {
    this.most = software ? 60_000 : 400_000; // particles of a picture while something moves
    this.slow = software ? 5 : 1; // a processor gets that much more time
    this.moved = 0; // clock of the last change [ms]
    this.drawn = 0; // clock of the last picture
    this.wait = STILL; // ms without a change until all are drawn; longer where pictures take long
    this.coarse = false; // whether the last picture left particles out that a still one has
  }

  /**
   * Say that something has moved, and so the next picture is one of many.
   * @param {number} now [ms]
   */
  move(now) {
    this.moved = now;
  }

  /**
   * Return of how many particles one is drawn.
   * @param {number} count of all
   * @param {number} pixels between two neighbours at the target
   * @param {number} now [ms]
   */
  skip(count, pixels, now) {
    const far = Math.floor((FINE / Math.max(pixels, 1e-6)) ** 3); // no finer than what can be seen
    const still = Math.max(1, Math.min(far, Math.floor(count / LEAST), MOST_SKIPPED));
    const moving = now - this.moved < this.wait ? Math.ceil(count / this.most) : 1;
    const skip = Math.min(MOST_SKIPPED, Math.max(still, moving));
    this.coarse = skip > still;
    return skip;
  }

  /**
   * Learn from the time since the last picture, if both are of one movement.
   * @param {number} now [ms]
   */
  learn(now) {
    const took = now - this.drawn;
    this.drawn = now;
    if (took > 1000 * this.slow || now - this.moved >= this.wait) return;
    this.wait = Math.max(STILL, 2.5 * took);
    if (took > LONG * this.slow) this.most = Math.max(LEAST, 0.8 * this.most);
    else if (took < SHORT * this.slow) this.most = Math.min(FULL, 1.1 * this.most);
  }

  /**
   * Whether a finer picture is due.
   * @param {number} now [ms]
   */
  due(now) {
    return this.coarse && now - this.moved >= this.wait;
  }
}

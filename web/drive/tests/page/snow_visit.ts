import type { Stamp } from "../../src/snow/stamps";
import { visit, type Visit } from "./browser";
import type { Start } from "./snow";

/** Texels along the window of the tests, and their size [m]. */
export const N = 256;
export const TEXEL = 0.05;
/** Rounding of float32. */
export const EPS = 2 ** -24;

/** A wheel of 0.38 m x 0.26 m whose lowest point is at a height [m]. */
export const wheelAt = (x: number, z: number, bottom: number, more: object = {}): Stamp => ({
  shape: "wheel",
  x,
  y: bottom + 0.38,
  z,
  heading: 0.3,
  radius: 0.38,
  width: 0.26,
  slip: 0,
  ...more,
});

/** Sums over (h, W) pairs. */
export function sums(snow: Float32Array): { h: number; W: number } {
  let [h, W] = [0, 0];
  for (let i = 0; i < snow.length; i += 2) {
    h += snow[i]!;
    W += snow[i + 1]!;
  }
  return { h, W };
}

/** How many numbers of two readings differ, in however few bits. */
export function differing(a: Float32Array, b: Float32Array): number {
  if (a.length !== b.length) throw new Error(`${a.length} numbers and ${b.length}`);
  return a.reduce((count, value, k) => count + Number(!Object.is(value, b[k])), 0);
}

/** What tests do to the snow field of a page. */
export class SnowVisit {
  readonly visit: Visit;

  private constructor(visitor: Visit) {
    this.visit = visitor;
  }

  static async open(): Promise<SnowVisit> {
    const visitor = await visit("tests/page/snow.html");
    await visitor.page.waitForFunction(() => "snow" in window);
    return new SnowVisit(visitor);
  }

  /** Make a new field in place of the last one. */
  start(options: Start = {}): Promise<void> {
    return this.visit.page.evaluate((given) => {
      window.snow.start(given);
      window.snow.field!.update(0, []);
    }, options);
  }

  update(dt: number, stamps: Stamp[] = [], times = 1): Promise<void> {
    return this.visit.page.evaluate(
      ([step, list, count]) => {
        for (let i = 0; i < count; i++) window.snow.field!.update(step, list);
      },
      [dt, stamps, times] as const,
    );
  }

  /** Follow a place [m] for one update of no time. */
  follow(x: number, z: number): Promise<void> {
    return this.visit.page.evaluate(
      ([a, b]) => {
        window.snow.field!.follow(a, b);
        window.snow.field!.update(0, []);
      },
      [x, z] as const,
    );
  }

  /** (h, W) of texels from a corner [m]. */
  async read(x: number, z: number, nx = 1, nz = nx): Promise<Float32Array> {
    const text = await this.visit.page.evaluate(([a, b, na, nb]) => window.snow.text(a, b, na, nb), [
      x,
      z,
      nx,
      nz,
    ] as const);
    return new Float32Array(Uint8Array.from(Buffer.from(text, "base64")).buffer);
  }

  /** (h, W) of the whole window. */
  async all(): Promise<Float32Array> {
    const { x, z } = await this.visit.page.evaluate(() => window.snow.field!.corner);
    return this.read(x, z, N);
  }

  /** Slide in the middle of the window, where the stamps are: in software the whole of it takes long. */
  relax(steps: number): Promise<void> {
    return this.visit.page.evaluate((n) => window.snow.field!.relax(n, { x: 0, z: 0, reach: 2 }), steps);
  }

  /** Slide until a hundred steps more change nothing, bit for bit. */
  async atRest(): Promise<Float32Array> {
    let snow = await this.all();
    for (let i = 0; i < 20; i++) {
      await this.relax(100);
      const next = await this.all();
      if (differing(next, snow) === 0) return snow;
      snow = next;
    }
    throw new Error("snow slid for 2000 steps and did not come to rest");
  }
}

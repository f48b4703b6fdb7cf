import type { Column } from "../law";
import { area, type Rect } from "../window/rects";

/** A copy of a rectangle of the snow on the processor, as old as it took to read it. */
export class Patch {
  readonly rect: Rect;
  private readonly data: Float32Array;
  private readonly texel: number;

  /** Texels of the world; (h, W) pairs in rows of z; size of a texel [m]. */
  constructor(rect: Rect, data: Float32Array, texel: number) {
    if (data.length !== 2 * area(rect)) throw new Error("a patch needs (h, W) for each of its texels");
    this.rect = rect;
    this.data = data;
    this.texel = texel;
  }

  /** The snow at a place [m], linear between texels; null outside. */
  at(x: number, z: number): Column | null {
    const { x0, z0, x1, z1 } = this.rect;
    const [px, pz] = [x / this.texel - 0.5 - x0, z / this.texel - 0.5 - z0];
    const [i, j] = [Math.floor(px), Math.floor(pz)];
    if (i < 0 || j < 0 || i + 1 >= x1 - x0 || j + 1 >= z1 - z0) return null;
    const [u, v] = [px - i, pz - j];
    const mix = (channel: number) => {
      const value = (di: number, dj: number) => this.data[2 * (i + di + (j + dj) * (x1 - x0)) + channel]!;
      const near = value(0, 0) * (1 - u) + value(1, 0) * u;
      return near * (1 - v) + (value(0, 1) * (1 - u) + value(1, 1) * u) * v;
    };
    return { h: mix(0), W: mix(1) };
  }
}

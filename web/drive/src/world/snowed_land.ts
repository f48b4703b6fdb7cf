/** A piece of ground on which Neve has let it snow, in the middle of the endless world, with a seam around it. */
import type { Snowed } from "../bridge/ground";
import { mix, smoothstep } from "./noise";
import type { Land, Surface } from "./terrain_type";

/** Over which the piece goes over into the world around it [m]. */
const SEAM = 24;
/** More than so many times the depth of the settings is not drawn. */
const MOST_COVER = 2;
/** Range of the depth in the settings [m]. */
const [LEAST_DEPTH, GREATEST_DEPTH] = [0.05, 1.2];

/** The depth [m] that the settings get for a piece: the mean of its snow, or more where some is much deeper. */
export function usualDepth({ depth }: Snowed): number {
  let [sum, deepest] = [0, 0];
  for (const one of depth) [sum, deepest] = [sum + one, Math.max(deepest, one)];
  const wanted = Math.max(sum / depth.length, deepest / MOST_COVER);
  return Math.min(GREATEST_DEPTH, Math.max(LEAST_DEPTH, Math.ceil(100 * wanted - 1e-3) / 100));
}

/** How far a place is from a piece [m]: 0 on it. */
export function outside({ nx, ny, cell }: Snowed, x: number, z: number): number {
  const beyond = (a: number, n: number) => Math.max(0, Math.abs(a) - 0.5 * n * cell);
  return Math.hypot(beyond(x, nx), beyond(z, ny));
}

/** The middle of the piece is the start; its x is east, its y north. */
export class SnowedLand implements Land {
  private readonly around: Land;
  private readonly piece: Snowed;
  private readonly usual: number;
  private readonly lift: number;

  constructor(around: Land, piece: Snowed) {
    this.around = around;
    this.piece = piece;
    this.usual = usualDepth(piece);
    this.lift = around.height(0, 0) - this.at(piece.ground, 0, 0);
  }

  height(x: number, z: number): number {
    const wild = this.wild(x, z);
    const own = this.at(this.piece.ground, x, z) + this.lift;
    return wild === 0 ? own : mix(own, this.around.height(x, z), wild);
  }

  surface(x: number, z: number): Surface {
    const wild = this.wild(x, z);
    const own = Math.min(MOST_COVER, this.at(this.piece.depth, x, z) / this.usual);
    if (wild === 0) return [own, 0, 0];
    const [cover, packed, ice] = this.around.surface(x, z);
    return [mix(own, cover, wild), wild * packed, wild * ice];
  }

  /** Share of the world around, 0 on the piece and 1 beyond the seam. */
  private wild(x: number, z: number): number {
    return smoothstep(0, SEAM, outside(this.piece, x, z));
  }

  /** Values of cells at a place: straight between their middles, beyond the outermost those of them. */
  private at(values: Float32Array, x: number, z: number): number {
    const { nx, ny, cell } = this.piece;
    const along = (a: number, n: number) => Math.min(n - 1, Math.max(0, a / cell + 0.5 * (n - 1)));
    const [u, v] = [along(x, nx), along(-z, ny)];
    const [i, j] = [
      Math.min(Math.floor(u), Math.max(0, nx - 2)),
      Math.min(Math.floor(v), Math.max(0, ny - 2)),
    ];
    const value = (di: number, dj: number) =>
      values[Math.min(nx - 1, i + di) * ny + Math.min(ny - 1, j + dj)]!;
    const near = mix(value(0, 0), value(0, 1), v - j);
    return mix(near, mix(value(1, 0), value(1, 1), v - j), u - i);
  }
}

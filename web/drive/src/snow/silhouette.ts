import type { BoxStamp } from "./stamps";

/** Triangles whose underside presses the snow. */
export interface Silhouette {
  /** Corners x, y, z in the world [m], three numbers each. */
  readonly positions: ArrayLike<number>;
  /** Three corners of each triangle; without them the corners follow each other. */
  readonly index?: ArrayLike<number>;
  /** Size of the cells into which the underside is cut [m]; about a texel of the field. */
  readonly cell: number;
  /** Heights above this one press nothing and are left out [m]: the top of the snow. */
  readonly below: number;
  /** Undersides that differ by no more than this become one stamp [m]; half a cell if left out. */
  readonly tolerance?: number;
}

/** Most cells of an underside: a mesh of 20 m at 5 cm. */
const MOST_CELLS = 400 * 400;

/**
 * Return stamps that press what the underside of a mesh presses: its lowest height over each cell, rectangles of
 * nearly equal heights as one box each. Eight boxes take one set of passes. Errors: Error with a sentence, for cells
 * that are too many or too small.
 */
export function silhouetteStamps(shape: Silhouette): BoxStamp[] {
  const { cell, below, tolerance = 0.5 * cell } = shape;
  if (!(cell > 0)) throw new Error(`The cell of a silhouette must be greater than 0 m, not ${cell}.`);
  const { x0, z0, nx, nz, height } = underside(shape);
  const boxes: BoxStamp[] = [];
  const used = new Uint8Array(nx * nz);
  for (let j = 0; j < nz; j++)
    for (let i = 0; i < nx; i++) {
      const least = height[i + j * nx]!;
      if (used[i + j * nx] || least >= below) continue;
      const fits = (k: number, l: number) =>
        !used[k + l * nx] &&
        Math.abs(height[k + l * nx]! - least) <= tolerance &&
        height[k + l * nx]! < below;
      let right = i + 1;
      while (right < nx && fits(right, j)) right++;
      let down = j + 1;
      while (down < nz && everyCell(i, right, (k) => fits(k, down))) down++;
      let lowest = Infinity;
      for (let l = j; l < down; l++)
        for (let k = i; k < right; k++) {
          used[k + l * nx] = 1;
          lowest = Math.min(lowest, height[k + l * nx]!);
        }
      boxes.push({
        shape: "box",
        x: x0 + 0.5 * (i + right) * cell,
        y: lowest,
        z: z0 + 0.5 * (j + down) * cell,
        heading: 0,
        length: (right - i) * cell,
        width: (down - j) * cell,
        slopeAlong: 0,
        slopeAcross: 0,
      });
    }
  return boxes;
}

function everyCell(from: number, to: number, holds: (k: number) => boolean): boolean {
  for (let k = from; k < to; k++) if (!holds(k)) return false;
  return true;
}

/** The lowest height of the triangles over the middle of each cell; Infinity where there are none. */
function underside({ positions, index, cell }: Silhouette) {
  let [x0, z0, x1, z1] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let p = 0; p + 2 < positions.length; p += 3) {
    [x0, x1] = [Math.min(x0, positions[p]!), Math.max(x1, positions[p]!)];
    [z0, z1] = [Math.min(z0, positions[p + 2]!), Math.max(z1, positions[p + 2]!)];
  }
  [x0, z0] = [Math.floor(x0 / cell) * cell, Math.floor(z0 / cell) * cell];
  const [nx, nz] = [Math.ceil((x1 - x0) / cell), Math.ceil((z1 - z0) / cell)].map(
    (n) => Math.max(0, n) || 0,
  ) as [number, number];
  if (nx * nz > MOST_CELLS)
    throw new Error(`A silhouette of ${nx} x ${nz} cells is too large: use larger cells or a part of it.`);
  const height = new Float64Array(nx * nz).fill(Infinity);
  const count = index ? index.length : positions.length / 3;
  for (let t = 0; t + 2 < count; t += 3) {
    const corner = (k: number) => 3 * (index ? index[t + k]! : t + k);
    lower(height, nx, nz, (k) => {
      const p = corner(k);
      return [(positions[p]! - x0) / cell, (positions[p + 2]! - z0) / cell, positions[p + 1]!];
    });
  }
  return { x0, z0, nx, nz, height };
}

/** Lower the heights under one triangle, whose corners are given in cells and metres. */
function lower(
  height: Float64Array,
  nx: number,
  nz: number,
  at: (k: number) => [number, number, number],
): void {
  const [[ax, az, ay], [bx, bz, by], [cx, cz, cy]] = [at(0), at(1), at(2)];
  const area = (bx - ax) * (cz - az) - (bz - az) * (cx - ax);
  if (Math.abs(area) < 1e-12) return;
  const first = (a: number, b: number, c: number) => Math.max(0, Math.ceil(Math.min(a, b, c) - 0.5));
  const last = (a: number, b: number, c: number, n: number) =>
    Math.min(n - 1, Math.floor(Math.max(a, b, c) - 0.5));
  for (let j = first(az, bz, cz); j <= last(az, bz, cz, nz); j++)
    for (let i = first(ax, bx, cx); i <= last(ax, bx, cx, nx); i++) {
      const [x, z] = [i + 0.5, j + 0.5];
      const v = ((x - ax) * (cz - az) - (z - az) * (cx - ax)) / area;
      const w = ((bx - ax) * (z - az) - (bz - az) * (x - ax)) / area;
      if (v < -1e-9 || w < -1e-9 || v + w > 1 + 1e-9) continue;
      height[i + j * nx] = Math.min(height[i + j * nx]!, ay + v * (by - ay) + w * (cy - ay));
    }
}

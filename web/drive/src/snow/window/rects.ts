/** Rectangles of texels, half open: x0 <= x < x1, z0 <= z < z1. Whether of the world or of the window, says the user. */
export interface Rect {
  readonly x0: number;
  readonly z0: number;
  readonly x1: number;
  readonly z1: number;
}

/** A number modulo a positive one, never negative. */
export function modulo(a: number, n: number): number {
  return ((a % n) + n) % n;
}

/** Number of texels. */
export function area({ x0, z0, x1, z1 }: Rect): number {
  return Math.max(0, x1 - x0) * Math.max(0, z1 - z0);
}

/** What two rectangles share; its area may be 0. */
export function common(a: Rect, b: Rect): Rect {
  return {
    x0: Math.max(a.x0, b.x0),
    z0: Math.max(a.z0, b.z0),
    x1: Math.min(a.x1, b.x1),
    z1: Math.min(a.z1, b.z1),
  };
}

/** The least rectangle that holds both. */
export function hull(a: Rect, b: Rect): Rect {
  return {
    x0: Math.min(a.x0, b.x0),
    z0: Math.min(a.z0, b.z0),
    x1: Math.max(a.x1, b.x1),
    z1: Math.max(a.z1, b.z1),
  };
}

/** Join rectangles that overlap until none do: then a pass over each of them sees no texel twice. */
export function joined(rects: readonly Rect[]): Rect[] {
  const apart: Rect[] = [];
  for (const rect of rects) {
    let grown = rect;
    for (let i = apart.length - 1; i >= 0; i--) {
      if (area(common(apart[i]!, grown)) > 0) {
        grown = hull(grown, apart[i]!);
        apart.splice(i, 1);
        i = apart.length;
      }
    }
    apart.push(grown);
  }
  return apart;
}

/** The up to four pieces of a rectangle on a torus of n x n texels; its sides are at most n. */
export function wrapped(rect: Rect, n: number): Rect[] {
  const spans = (a: number, b: number): [number, number][] => {
    const start = modulo(a, n);
    const end = start + (b - a);
    return end <= n
      ? [[start, end]]
      : [
          [start, n],
          [0, end - n],
        ];
  };
  const across = spans(rect.x0, rect.x1);
  return spans(rect.z0, rect.z1).flatMap(([z0, z1]) => across.map(([x0, x1]) => ({ x0, z0, x1, z1 })));
}

/**
 * Put together what was read of the pieces of a rectangle: their RGBA texels, one piece after the other, become
 * (h, W) pairs in rows of z.
 */
export function assembled(rect: Rect, n: number, data: Float32Array): Float32Array {
  const nx = rect.x1 - rect.x0;
  const result = new Float32Array(2 * area(rect));
  let from = 0;
  for (const piece of wrapped(rect, n))
    for (let z = piece.z0; z < piece.z1; z++)
      for (let x = piece.x0; x < piece.x1; x++, from += 4) {
        const to = 2 * (modulo(x - rect.x0, n) + nx * modulo(z - rect.z0, n));
        result[to] = data[from]!;
        result[to + 1] = data[from + 1]!;
      }
  return result;
}

/**
 * The grid that carries the snow: a square of small cells in the middle and rings of cells twice as large about it,
 * each twice as wide (geometry clipmap; Losasso and Hoppe 2004, "Geometry clipmaps", ACM Trans. Graph. 23(3)).
 * Every ring is placed on a lattice of its own doubled cell, so that vertices never slide over the snow.
 */

/** Vertices as (i, level, j) in cells of their level, and triangles. */
export interface RingGrid {
  readonly positions: Float32Array;
  readonly indices: Uint32Array;
}

/** The rings of `levels` levels with `cells` cells along a side (a multiple of 4). */
export function ringGrid(cells: number, levels: number): RingGrid {
  const half = cells / 2;
  const side = cells + 1;
  const positions: number[] = [];
  const indices: number[] = [];
  for (let level = 0; level < levels; level++) {
    const numbers = new Map<number, number>();
    const vertex = (i: number, j: number): number => {
      const key = (j + half) * side + i + half;
      let number = numbers.get(key);
      if (number === undefined) {
        number = positions.length / 3;
        numbers.set(key, number);
        positions.push(i, level, j);
      }
      return number;
    };
    // The ring within covers [-half / 2, half / 2] or is one cell further along (its lattice is finer): the hole is
    // what it covers in both cases, and the overlap of one cell has the same surface twice.
    const inHole = (k: number) => level > 0 && k >= -half / 2 + 1 && k < half / 2;
    for (let j = -half; j < half; j++) {
      for (let i = -half; i < half; i++) {
        if (inHole(i) && inHole(j)) continue;
        const [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i, j + 1), vertex(i + 1, j + 1)];
        indices.push(a, c, b, b, c, d);
      }
    }
  }
  return { positions: new Float32Array(positions), indices: new Uint32Array(indices) };
}

/** Triangles by their direction from the middle: sector after sector of a turn, all of them twice. */
export interface Turned {
  readonly indices: Uint32Array;
  /** Where each sector begins in `indices`; one more at the end of the first turn. */
  readonly starts: readonly number[];
}

/** The triangles of all levels below `level`, and those of the others by their direction. */
export function byDirection(
  { positions, indices }: RingGrid,
  level: number,
  sectors: number,
): { near: Uint32Array; far: Turned } {
  const near: number[] = [];
  const turns: number[][] = Array.from({ length: sectors }, () => []);
  for (let t = 0; t < indices.length; t += 3) {
    const corners = indices.subarray(t, t + 3);
    let [x, z, own] = [0, 0, 0];
    for (const corner of corners) {
      x += positions[3 * corner]!;
      z += positions[3 * corner + 2]!;
      own = positions[3 * corner + 1]!;
    }
    const turn = Math.atan2(z, x) / (2 * Math.PI);
    (own < level ? near : turns[Math.floor((turn - Math.floor(turn)) * sectors) % sectors]!).push(...corners);
  }
  const starts = [0];
  for (const sector of turns) starts.push(starts[starts.length - 1]! + sector.length);
  const once = turns.flat();
  return { near: Uint32Array.from(near), far: { indices: Uint32Array.from([...once, ...once]), starts } };
}

/** The piece of `indices` that holds all directions within `half` of `heading` [rad]: its start and its length. */
export function arc({ starts }: Turned, heading: number, half: number): [number, number] {
  const sectors = starts.length - 1;
  const one = (2 * Math.PI) / sectors;
  const [from, to] = [heading - half, heading + half].map((angle) => Math.floor(angle / one)) as [
    number,
    number,
  ];
  if (!(to - from < sectors)) return [0, starts[sectors]!];
  const first = ((from % sectors) + sectors) % sectors;
  const last = first + to - from + 1;
  const end = last <= sectors ? starts[last]! : starts[sectors]! + starts[last - sectors]!;
  return [starts[first]!, end - starts[first]!];
}

/** Where level `level` puts its middle for the rings' centre [m]: on the lattice of its doubled cell. */
export function ringOrigin(centre: number, cell: number, level: number): number {
  const step = 2 * cell * 2 ** level;
  return Math.floor(centre / step) * step;
}

/**
 * The same in a shader, with the vertices of odd number gliding to their even neighbours toward a ring's edge, where
 * the ring is as coarse as the next: no crack, no jump. 'ringPlace' is the place [m] of a vertex of the grid, and 'width'
 * how far it is from the next [m].
 */
export function ringGlsl(cells: number): string {
  const half = cells / 2;
  // The next ring's hole ends no nearer than half - 4 cells from the centre: all is morphed before.
  return /* glsl */ `
uniform vec2 ringCentre;
uniform float ringCell;
vec2 ringPlace(vec3 vertex, out float width) {
  float cell = ringCell * exp2(vertex.y);
  vec2 origin = floor(ringCentre / (2.0 * cell)) * (2.0 * cell);
  vec2 place = origin + vertex.xz * cell;
  vec2 away = abs(place - ringCentre) / cell;
  float morph = clamp((max(away.x, away.y) - ${(0.62 * half).toFixed(1)}) / ${(0.38 * half - 6).toFixed(1)}, 0.0, 1.0);
  width = cell * (1.0 + morph);
  return place - mod(vertex.xz, 2.0) * cell * morph;
}
`;
}

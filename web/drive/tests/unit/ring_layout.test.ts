import { describe, expect, it } from "vitest";
import { ringGrid, ringOrigin } from "../../src/render/ground/ring_layout";

/** Cells (corner, in cells of `level`) that the triangles of a level cover. */
function cellsOf(level: number, cells: number, levels: number): Set<string> {
  const { positions, indices } = ringGrid(cells, levels);
  const found = new Set<string>();
  for (let k = 0; k < indices.length; k += 3) {
    const corners = [0, 1, 2].map((n) => 3 * indices[k + n]!);
    if (positions[corners[0]! + 1] !== level) continue;
    const least = (axis: number) => Math.min(...corners.map((c) => positions[c + axis]!));
    found.add(`${least(0)},${least(2)}`);
  }
  return found;
}

describe("ringGrid", () => {
  it("faces up: every triangle turns from z to x", () => {
    const { positions, indices } = ringGrid(8, 3);
    for (let k = 0; k < indices.length; k += 3) {
      const [a, b, c] = [0, 1, 2].map((n) => 3 * indices[k + n]!) as [number, number, number];
      const side = (p: number, axis: number) => positions[p + axis]! - positions[a + axis]!;
      expect(side(b, 2) * side(c, 0) - side(b, 0) * side(c, 2)).toBe(1);
    }
  });

  it("covers the plane without a gap wherever its centre is, overlapping by one coarse cell at most", () => {
    const [cells, levels, cell] = [16, 4, 0.1];
    const held = [0, 1, 2, 3].map((level) => cellsOf(level, cells, levels));
    for (const centre of [0, 0.05, 0.13, 0.21, 0.39, 0.4, 0.77, 1.61, -0.33, -12.345]) {
      const origins = [0, 1, 2, 3].map((level) => ringOrigin(centre, cell, level));
      // Middles of the finest cells along a line and across it: exact multiples, so no middle lies on an edge.
      const reach = (cells / 2 - 2) * cell * 2 ** (levels - 1);
      for (let x = origins[3]! - reach + cell / 2; x < origins[3]! + reach; x += cell) {
        for (const z of [centre, centre + 0.52, centre - 1.31, centre + 3.07]) {
          const covering = held.filter((set, level) => {
            const size = cell * 2 ** level;
            const place = (v: number) => Math.floor((v - origins[level]!) / size);
            return set.has(`${place(x)},${place(z)}`);
          }).length;
          expect(covering).toBeGreaterThanOrEqual(1);
          expect(covering).toBeLessThanOrEqual(2);
        }
      }
    }
  });
});

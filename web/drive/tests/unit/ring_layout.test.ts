import { PerspectiveCamera, Texture, Vector3, type Mesh } from "three";
import { describe, expect, it } from "vitest";
import { arc, byDirection, ringGrid, ringOrigin } from "../../src/render/ground/ring_layout";
import { VERTEX_WEIGHTS } from "../../src/render/ground/snow_glsl";
import { COARSE_RINGS, RINGS, SnowSurface } from "../../src/render/ground/snow_surface";
import { Atmosphere } from "../../src/render/sky/atmosphere";
import { QUANTITIES } from "../../src/settings";
import { random } from "../../src/world/noise";

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

describe("byDirection", () => {
  const grid = ringGrid(8, 3);
  const { near, far } = byDirection(grid, 1, 6);

  it("keeps every triangle once in a turn", () => {
    const name = (all: Uint32Array, t: number) => all.subarray(t, t + 3).join();
    const names = (all: Uint32Array) => Array.from({ length: all.length / 3 }, (_, t) => name(all, 3 * t));
    const once = far.indices.subarray(0, far.starts[6]);
    expect([...names(near), ...names(once)].sort()).toEqual(names(grid.indices).sort());
    expect(far.indices.subarray(far.starts[6])).toEqual(once);
  });

  it("has any arc in one piece, the sectors at its ends whole, and never more than a turn", () => {
    const one = Math.PI / 3;
    const lengths = far.starts.slice(1).map((end, k) => end - far.starts[k]!);
    expect(arc(far, 0.5 * one, 0.1)).toEqual([0, lengths[0]]);
    expect(arc(far, 5.5 * one, one)).toEqual([far.starts[4], lengths[4]! + lengths[5]! + lengths[0]!]);
    expect(arc(far, -0.5 * one, 0.1)).toEqual([far.starts[5], lengths[5]]);
    for (const half of [2.9 * one, 3, 7, Infinity])
      expect(arc(far, 1, half)[1]).toBeLessThanOrEqual(far.starts[6]!);
    expect(arc(far, 1, Math.PI)).toEqual([0, far.starts[6]]);
  });
});

describe("the rings of the snow", () => {
  it.each([
    ["fine", RINGS, 0.8],
    // All of them: their innermost is no wider than the camera is away from their middle.
    ["coarse", COARSE_RINGS, 1.01],
  ])("are drawn where a camera looks, %s ones: no vertex that it sees is left out", (_, rings, most) => {
    const surface = new SnowSurface(new Atmosphere({ glsl: "", uniforms: {} }), new Texture(), rings);
    const far = surface.mesh.children[0] as Mesh;
    const { array: places } = far.geometry.getAttribute("position");
    const { array: indices } = far.geometry.index!;
    let [seen, drawn, all] = [0, 0, 0];
    for (let k = 0; k < 5; k++) {
      const r = (n: number) => random(k, n, 4) - 0.5;
      const camera = new PerspectiveCamera(40 + 40 * (r(0) + 0.5), 16 / 9, 0.1, 8000);
      camera.position.set(900 * r(1), 3 + 4 * r(2), 900 * r(3));
      const ahead = new Vector3(Math.cos(9 * r(4)), 0.8 * r(5), Math.sin(9 * r(4))).normalize();
      camera.lookAt(camera.position.clone().add(ahead));
      camera.updateMatrixWorld();
      const middle = camera.position.clone().addScaledVector(ahead, 5);
      surface.update(0.4, middle.x, middle.z);
      surface.look(camera);
      const { start, count } = far.geometry.drawRange;
      const held = new Set(indices.slice(start, start + count));
      const at = new Vector3();
      for (const vertex of new Set(indices)) {
        const [i, level, j] = [0, 1, 2].map((axis) => places[3 * vertex + axis]!) as [number, number, number];
        const size = rings.cell * 2 ** level;
        const origin = (centre: number) => ringOrigin(centre, rings.cell, level);
        at.set(origin(middle.x) + i * size, 0, origin(middle.z) + j * size);
        if (at.clone().sub(camera.position).dot(ahead) <= 0) continue;
        at.project(camera);
        if (Math.max(Math.abs(at.x), Math.abs(at.y)) > 1) continue;
        seen++;
        if (!held.has(vertex)) throw new Error(`camera ${k} does not draw ${i}, ${level}, ${j}`);
      }
      drawn += count;
      all += indices.length / 2;
    }
    expect(seen).toBeGreaterThan(1000);
    expect(drawn / all).toBeLessThan(most);
  });

  it("tell a rut of the usual tyre: two cells in its width, coarse or fine", () => {
    for (const { cell } of [RINGS, COARSE_RINGS]) expect(2 * cell).toBeLessThan(QUANTITIES.tyreWidth.value);
  });

  it("have a quarter of the triangles where they are coarse", () => {
    const [fine, coarse] = [RINGS, COARSE_RINGS].map((r) => ringGrid(r.cells, r.levels).indices.length);
    expect(coarse! / fine!).toBeGreaterThan(0.24);
    expect(coarse! / fine!).toBeLessThan(0.28);
  });

  it("take no wave of one cell from the tracks, half of one of two cells, and all of level snow", () => {
    // A wave of n cells is seen half a cell apart, at phases of pi / n: its share is the sum of weight times cosine.
    const share = (n: number) =>
      VERTEX_WEIGHTS.reduce((sum: number, w, k) => sum + w * Math.cos((Math.PI / n) * (k - 1)), 0);
    expect(share(1)).toBeCloseTo(0, 12);
    expect(share(2)).toBeCloseTo(0.5, 12);
    expect(share(Infinity)).toBeCloseTo(1, 12);
  });
});

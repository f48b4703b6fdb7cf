import { describe, expect, test } from "vitest";
import { coverAt, coverLattice, onlyFresh } from "../../src/snow/window/cover";
import { origin, RIM_REACH, slideRect, stampRect } from "../../src/snow/footprint";
import { Patch } from "../../src/snow/gpu/patch";
import { area, assembled, common, joined, modulo, wrapped } from "../../src/snow/window/rects";
import { dueTiles } from "../../src/snow/gpu/recovery";
import type { WheelStamp } from "../../src/snow/stamps";
import { TileStore } from "../../src/snow/window/store";
import { TILE, tileKey, TileWindow } from "../../src/snow/window/tiles";

const rect = (x0: number, z0: number, x1: number, z1: number) => ({ x0, z0, x1, z1 });

describe("rectangles", () => {
  test("pieces on a torus cover each texel of a rectangle once", () => {
    for (const [x, z, nx, nz] of [
      [0, 0, 8, 8],
      [-3, 5, 4, 6],
      [13, -9, 7, 1],
      [6, 6, 3, 8],
    ] as const) {
      const seen = new Map<string, number>();
      for (const p of wrapped(rect(x, z, x + nx, z + nz), 8))
        for (let j = p.z0; j < p.z1; j++)
          for (let i = p.x0; i < p.x1; i++) seen.set(`${i},${j}`, (seen.get(`${i},${j}`) ?? 0) + 1);
      const wanted = new Set<string>();
      for (let j = z; j < z + nz; j++)
        for (let i = x; i < x + nx; i++) wanted.add(`${modulo(i, 8)},${modulo(j, 8)}`);
      expect(new Set(seen.keys())).toEqual(wanted);
      expect(Math.max(...seen.values())).toBe(1);
    }
  });

  test("what is read piece by piece comes together in rows", () => {
    const whole = rect(-3, 5, 2, 9);
    const data: number[] = [];
    for (const p of wrapped(whole, 8))
      for (let j = p.z0; j < p.z1; j++) for (let i = p.x0; i < p.x1; i++) data.push(i, j, -1, -1);
    const rows = assembled(whole, 8, new Float32Array(data));
    for (let j = 0; j < 4; j++)
      for (let i = 0; i < 5; i++)
        expect([rows[2 * (i + 5 * j)], rows[2 * (i + 5 * j) + 1]]).toEqual([
          modulo(i - 3, 8),
          modulo(j + 5, 8),
        ]);
  });

  test("joining leaves none that overlap, and nothing out", () => {
    const some = [
      rect(0, 0, 4, 4),
      rect(10, 10, 12, 12),
      rect(3, 3, 6, 6),
      rect(20, 0, 22, 2),
      rect(5, 5, 11, 11),
    ];
    const apart = joined(some);
    expect(apart).toHaveLength(2);
    for (const a of some) expect(apart.some((b) => area(common(a, b)) === area(a))).toBe(true);
  });
});

describe("the window", () => {
  test("keeps the tiles that stay, when it slides by one, by more than its size, and aslant", () => {
    const window = new TileWindow(4);
    window.move(-2, -2, 0);
    for (const [tx, tz] of [
      [-1, -2],
      [-1, -3],
      [7, 9],
      [-20, 30],
      [-19, 31],
    ] as const) {
      const before = new Map(window.tiles.map((tile) => [tileKey(tile), tile]));
      const { left, entered } = window.move(tx, tz, 1);
      expect(left).toHaveLength(entered.length);
      const places = new Set<string>();
      for (let j = tz; j < tz + 4; j++)
        for (let i = tx; i < tx + 4; i++) {
          const tile = window.at(i, j)!;
          places.add(tileKey(tile));
          if (before.has(tileKey(tile))) expect(tile).toBe(before.get(tileKey(tile)));
          else expect(entered).toContain(tile);
        }
      expect(places.size).toBe(16);
      for (const tile of left) expect(window.at(tile.tx, tile.tz)).toBeUndefined();
    }
  });

  test("stays put while its middle is off by less than a tile", () => {
    const window = new TileWindow(4);
    window.move(-2, -2, 0);
    expect(window.wanted(0.9 * TILE, -0.9 * TILE)).toEqual({ tx: -2, tz: -2 });
    expect(window.wanted(1.1 * TILE, -5.2 * TILE)).toEqual({ tx: -1, tz: -7 });
  });

  test("finds the tiles under a rectangle", () => {
    const window = new TileWindow(4);
    expect(window.over(rect(-10, 10, 65, 64)).map(tileKey)).toEqual(["0,0", "1,0"]);
    expect(window.over(window.rect)).toHaveLength(16);
  });

  test("recovers what waits longest first, and nothing untouched", () => {
    const window = new TileWindow(2);
    const settings = { depth: 0.5, compaction: 1, rimShare: 1, repose: 40, recovery: 100, snowfall: 0 };
    window.tiles.forEach((tile, i) => {
      tile.touched = i !== 1;
      tile.settledAt = [3, 0, 2, 9.99][i]!;
    });
    // Due is what is older than 0.2 mm / (1.5 * 0.5 m / 100 s) = 0.027 s.
    expect(dueTiles(window.tiles, settings, 10).map(({ settledAt }) => settledAt)).toEqual([2, 3]);
  });
});

describe("the store", () => {
  const tile = (time: number) => ({ data: new Float32Array([time]), time, depth: 1 });

  test("keeps the youngest of a name and lets go of the first kept", () => {
    const store = new TileStore(2);
    store.put("a", tile(2));
    store.put("a", tile(1));
    expect(store.get("a")!.time).toBe(2);
    store.put("b", tile(1));
    store.put("a", tile(3));
    store.put("c", tile(1));
    expect([store.get("a")?.time, store.get("b")?.time, store.get("c")?.time]).toEqual([3, undefined, 1]);
    store.drop("a");
    expect(store.size).toBe(1);
  });

  test("waits for each read of a tile", () => {
    const store = new TileStore();
    store.expect("a");
    store.expect("a");
    store.arrived("a");
    expect(store.expects("a")).toBe(true);
    store.arrived("a");
    expect(store.expects("a")).toBe(false);
  });
});

describe("the cover", () => {
  const terrain = {
    height: () => 0,
    slope: () => [0, 0] as [number, number],
    cover: (x: number, z: number) => 0.3 * x - 0.2 * z + 1,
    kinds: () => [1, 0, 0] as [number, number, number],
  };

  test("is exact between lattice points where it is linear, up to float32", () => {
    const lattice = coverLattice(terrain, 3, -2, 0.05);
    for (const [x, z] of [
      [0, 0],
      [17, 40],
      [63, 63],
    ] as const) {
      const exact = terrain.cover((3 * TILE + x + 0.5) * 0.05, (-2 * TILE + z + 0.5) * 0.05);
      expect(Math.abs(coverAt(lattice, x, z) - exact)).toBeLessThan(8 * 2 ** -24 * 8);
    }
  });

  test("tells fresh snow from tracks of a tenth of a millimetre", () => {
    const lattice = coverLattice(terrain, 0, 0, 0.05);
    const data = new Float32Array(2 * TILE * TILE);
    for (let i = 0; i < TILE * TILE; i++)
      data[2 * i] = data[2 * i + 1] = 0.5 * coverAt(lattice, i % TILE, Math.floor(i / TILE));
    expect(onlyFresh(data, lattice, 0.5)).toBe(true);
    data[2 * 1234 + 1]! -= 1e-4;
    expect(onlyFresh(data, lattice, 0.5)).toBe(false);
  });
});

describe("stamps", () => {
  const wheel: WheelStamp = {
    shape: "wheel",
    x: 10,
    y: 0.4,
    z: -5,
    heading: 0.5,
    radius: 0.4,
    width: 0.3,
    slip: 0,
  };

  test("change no texel further away than their rims reach", () => {
    const { x0, z0, x1, z1 } = stampRect(wheel, 0.05);
    const reach = 0.4 * Math.cos(0.5) + 0.15 * Math.sin(0.5) + RIM_REACH;
    expect(x0).toBe(Math.floor((10 - reach) / 0.05));
    expect(x1).toBe(Math.ceil((10 + reach) / 0.05));
    expect([z0, z1].map((z) => z < -5 / 0.05)).toEqual([true, false]);
  });

  test("hold where a wheel came from, unless it was put there", () => {
    const rolled = { ...wheel, from: { x: 9, y: 0.4, z: -5 } };
    expect(stampRect(rolled, 0.05).x0).toBe(stampRect(wheel, 0.05).x0 - 20);
    const put = { ...wheel, from: { x: -90, y: 0.4, z: -5 } };
    expect(origin(put)).toBe(put);
    expect(stampRect(put, 0.05)).toEqual(stampRect(wheel, 0.05));
    expect(area(slideRect(rolled, 0.05, 0.1))).toBeGreaterThan(area(stampRect(rolled, 0.05)));
  });
});

test("a patch is linear between its texels and knows where it ends", () => {
  const data = new Float32Array(2 * 12);
  for (let j = 0; j < 3; j++) for (let i = 0; i < 4; i++) data.set([i + 10 * j, 1], 2 * (i + 4 * j));
  const patch = new Patch(rect(-2, 8, 2, 11), data, 0.5);
  expect(patch.at((-2 + 1.75) * 0.5, (8 + 1.25) * 0.5)).toEqual({ h: 1.25 + 7.5, W: 1 });
  expect(patch.at(-1.01, 4.5)).toBeNull();
  expect(patch.at(0, 5.3)).toBeNull();
  expect(() => new Patch(rect(0, 0, 2, 2), data, 0.5)).toThrow("each of its texels");
});

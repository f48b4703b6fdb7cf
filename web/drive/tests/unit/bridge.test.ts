import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { APART, fittedType, PAUSE, Playback, type Canvas } from "../../src/bridge/playback";
import { fetchRecording, readRecording, type Recording } from "../../src/bridge/recording";
import { tellBridge } from "../../src/page/bridge_words";
import { wheelSinkage } from "../../src/snow/law";
import { mixSnow, SNOW_TYPES } from "../../src/snow/types";
import { LEVEL } from "../../src/world/terrain_type";

const FILE = new URL("../../public/recordings/wheel_load.json", import.meta.url);
const text = readFileSync(FILE, "utf-8");
const recording = await readRecording(text);
const FRESH = 0.3;

/** A snow field that remembers what was written. */
class Sheet implements Canvas {
  readonly texel = 0.05;
  readonly columns = new Map<string, [number, number]>();
  write(x0: number, z0: number, nx: number, data: Float32Array): boolean {
    const [i, j] = [x0, z0].map((a) => Math.round(a / this.texel)) as [number, number];
    for (let k = 0; 2 * k < data.length; k++)
      this.columns.set(`${i + (k % nx)} ${j + Math.floor(k / nx)}`, [data[2 * k]!, data[2 * k + 1]!]);
    return true;
  }
  at(x: number, z: number): [number, number] {
    return this.columns.get([x, z].map((a) => Math.floor(a / this.texel)).join(" "))!;
  }
}

const play = (of: Recording = recording) => new Playback(of, { x: 2, z: 3 }, LEVEL, () => FRESH);

describe("the recording that comes with the page", () => {
  it("is whole: level snow at first, a rut behind the wheel at last, its mass less than it was", () => {
    const { times, moments, path, patch, snow } = recording;
    expect(moments).toHaveLength(times.length);
    const middle = Math.floor(patch.ny / 2);
    const cell = Math.floor((1.4 - patch.along) / patch.cell) * patch.ny + middle;
    expect(moments[0]!.depth[cell]).toBeCloseTo(snow.depth, 1);
    const last = moments[moments.length - 1]!;
    expect(last.depth[cell]).toBeLessThan(0.8 * snow.depth);
    // Columns of a cell hold a few dozen particles: the mean of some along the rut.
    const near = [-2, -1, 0, 1, 2].map((k) => cell + k * patch.ny);
    const sum = (of: Float32Array) => near.reduce((total, k) => total + of[k]!, 0);
    expect(sum(last.mass) / sum(last.depth)).toBeGreaterThan(1.1);
    expect(sum(last.mass)).toBeLessThan(0.97 * sum(moments[0]!.mass));
    expect(path[path.length - 1]![0]).toBeGreaterThan(1.8);
  });

  it.each([
    ["no JSON", "{"],
    ["another format", text.replace('"format":1', '"format":2')],
    ["too few moments", text.replace(/"times":\[[^,]+,/, '"times":[')],
    ["broken columns", text.replace(/"depth":"[^"]+"/, '"depth":"eJw="')],
  ])("is refused in a sentence where it is damaged: %s", async (_, damaged) => {
    await expect(readRecording(damaged)).rejects.toThrow(/^The recording is damaged or of another version/);
  });
});

it("a recording that is not there is told in a sentence", async () => {
  const before = globalThis.fetch;
  globalThis.fetch = (async (address: string) => {
    expect(address).toBe("recordings/a%20%26%20b.json");
    return { ok: false };
  }) as unknown as typeof fetch;
  await expect(fetchRecording("a & b")).rejects.toThrow(
    "There is no recording a & b; neve drive --fit RUN makes",
  );
  globalThis.fetch = before;
});

describe("the playback", () => {
  it("writes the recorded columns: fresh at the border, the recorded depth inside", () => {
    const [playback, sheet] = [play(), new Sheet()];
    const last = recording.times[recording.times.length - 1]!;
    playback.step(last - playback.time, sheet);
    const { patch, moments } = recording;
    const at = (x: number, z: number) => {
      const [i, j] = [(x - patch.along) / patch.cell, (z - patch.across) / patch.cell].map(Math.floor);
      return moments[moments.length - 1]!.depth[i! * patch.ny + j!]!;
    };
    // In the middle of the rut depths differ little between neighbours: a cell and a texel are 4 and 5 cm.
    for (const x of [0.4, 0.8, 1.2]) expect(Math.abs(sheet.at(2 + x, 3)[0] - at(x, 0))).toBeLessThan(0.02);
    const edge = 3 + patch.across + patch.ny * patch.cell - 0.08;
    expect(sheet.at(2.8, edge)[0]).toBeCloseTo(FRESH, 2);
    // The rut of the game is beside it, and begins fresh.
    expect(sheet.at(2.8, 3 + APART)).toEqual([Math.fround(FRESH), Math.fround(FRESH)]);
  });

  it("rolls the game's wheel under the recorded load, as deep as the law has it", () => {
    const [playback, sheet] = [play(), new Sheet()];
    const [stamp] = playback.step(1.2, sheet);
    const { load, game, recorded } = playback.both();
    expect(load).toBeGreaterThan(2000);
    const { radius, width } = recording.wheel;
    const fresh = { h: FRESH, W: FRESH };
    const sunk = wheelSinkage(
      { radius, width, load },
      fresh,
      fittedType(recording),
      recording.snow.compaction,
    );
    expect(stamp!.y).toBeCloseTo(FRESH - sunk + radius, 9);
    expect(stamp!.z).toBeCloseTo(3 + APART, 2);
    expect(Math.abs(game - recorded)).toBeLessThan(0.06);
    const [left, right] = playback.wheels();
    expect(left.centre[2]).toBeCloseTo(3, 2);
    expect([right.centre[0], right.spin]).toEqual([left.centre[0], left.spin]);
    expect(tellBridge("wheel_load", playback.both())).toMatch(/kN[^]*left, .* cm in[^]*right, .* cm in/);
  });

  it("begins again after a pause, with fresh snow for the game's wheel", () => {
    const [playback, sheet] = [play(), new Sheet()];
    const last = recording.times[recording.times.length - 1]!;
    playback.step(last + 0.5 * PAUSE, sheet);
    expect(playback.step(0.01, sheet)).toEqual([]);
    sheet.columns.clear();
    playback.step(PAUSE, sheet);
    expect(playback.time).toBe(recording.times[0]);
    expect(sheet.at(2.8, 3 + APART)).toBeDefined();
  });
});

it("the car drives on the fitted snow", () => {
  const fitted = fittedType(recording);
  expect(mixSnow([1, 0, 0], fitted)).toMatchObject({
    name: "fitted",
    pressure: expect.closeTo(fitted.pressure),
  });
  expect(mixSnow([0, 1, 0], fitted).strain).toBe(SNOW_TYPES.packed.strain);
});

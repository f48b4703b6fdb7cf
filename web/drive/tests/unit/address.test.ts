import { describe, expect, it } from "vitest";
import { readAddress, writeAddress } from "../../src/page/address";
import { CHOICES, QUANTITIES, defaults } from "../../src/settings";
import type { QuantityName } from "../../src/settings";

describe("address", () => {
  it("is empty for the defaults, and nothing reads as the defaults", () => {
    expect(writeAddress(defaults())).toBe("");
    expect(readAddress("")).toEqual({ settings: defaults(), recording: null, ground: null, errors: [] });
    expect(readAddress("#").settings).toEqual(defaults());
  });

  it("holds the names of a recording and a ground, whatever they are, beside the settings", () => {
    const named = { recording: "wheel & load #2=ü", ground: "slope & #3=" };
    const settings = { ...defaults(), depth: 0.6 };
    expect(readAddress(`#${writeAddress(settings, named)}`)).toEqual({ settings, ...named, errors: [] });
    const one = { recording: null, ground: "slope" };
    expect(writeAddress(defaults(), one)).toBe("ground=slope");
    expect(readAddress("#recording=&ground=")).toEqual({
      settings: defaults(),
      recording: null,
      ground: null,
      errors: [],
    });
  });

  it("gives back what was written, for every setting at both ends of its range", () => {
    for (const end of ["min", "max"] as const) {
      const settings = defaults();
      for (const name of Object.keys(QUANTITIES) as QuantityName[]) settings[name] = QUANTITIES[name][end];
      settings.type = "ice";
      settings.drive = "rear";
      settings.detail = "low";
      settings.resolution = "256";
      const nothing = { recording: null, ground: null, errors: [] };
      expect(readAddress(`#${writeAddress(settings)}`)).toEqual({ settings, ...nothing });
    }
  });

  it.each([
    ["depth=9", "depth: 9 is not a number from 0.05 to 1.2 m."],
    ["depth=", "depth: nothing is not a number from 0.05 to 1.2 m."],
    ["depth=NaN", "depth: NaN is not a number from 0.05 to 1.2 m."],
    ["repose=steep", "repose: steep is not a number from 20 to 70 °."],
    ["compaction=1e999", "compaction: 1e999 is not a number from 0.2 to 1."],
    ["type=slush", "type: slush is not one of map, powder, packed, ice."],
    ["constructor=1", "There is no setting constructor."],
    ["__proto__=1", "There is no setting __proto__."],
  ])("refuses %s in one sentence and keeps the rest", (hash, sentence) => {
    const { settings, errors } = readAddress(`${hash}&hour=8`);
    expect(errors).toEqual([sentence]);
    expect(settings).toEqual({ ...defaults(), hour: 8 });
  });
});

describe("settings", () => {
  it("begin inside their own ranges, on their own steps' side", () => {
    for (const { value, min, max, step } of Object.values(QUANTITIES)) {
      expect(value).toBeGreaterThanOrEqual(min);
      expect(value).toBeLessThanOrEqual(max);
      expect(step).toBeGreaterThan(0);
      expect(step).toBeLessThan(max - min);
    }
    for (const { value, among } of Object.values(CHOICES)) expect(among).toContain(value);
  });
});

import table from "./sinkage.json";
import { describe, expect, test } from "vitest";
import {
  bearingDepth,
  bearingRatio,
  contactArea,
  densityRatio,
  DENSEST,
  passing,
  press,
  recover,
  sideShare,
  standingSlope,
  wheelSinkage,
  type Column,
} from "../../src/snow/law";
import { mixSnow, SNOW_TYPES, type SnowType } from "../../src/snow/types";

const fresh: Column = { h: 0.45, W: 0.45 };
const wheel = { radius: 0.38, width: 0.26, load: 3700 };
const types = Object.values(SNOW_TYPES);
// Doubles: some ten operations with a relative rounding of 1.1e-16 each, amplified by a power of at most 5.
const ROUNDING = 1e-13;

describe("pressing", () => {
  test("does not depend on the number of presses", () => {
    const once = press(fresh, 0.2, 0.7);
    let often = fresh;
    for (let i = 1; i <= 50; i++) often = press(often, 0.45 - (0.25 * i) / 50, 0.7);
    expect(Math.abs(often.W - once.W)).toBeLessThan(50 * ROUNDING);
  });

  test("a second press to the same depth changes nothing, bit for bit", () => {
    const once = press(fresh, 0.2, 0.7);
    expect(press(once, 0.2, 0.7)).toBe(once);
  });

  test("keeps all mass at compaction 1 and all density as compaction goes to 0", () => {
    expect(press(fresh, 0.2, 1).W).toBe(fresh.W);
    // r' = r (h'/h)^(-c): to first order in c, r' - 1 = c ln(h/h').
    expect(densityRatio(press(fresh, 0.2, 1e-6)) - 1).toBeCloseTo(1e-6 * Math.log(0.45 / 0.2), 11);
  });

  test("ends at the densest snow", () => {
    const flat = press(fresh, 0, 0.7);
    expect(densityRatio(flat)).toBeCloseTo(DENSEST, 10);
    expect(press(flat, 0, 0.7).h).toBeCloseTo(flat.h, 12);
  });
});

describe("bearing", () => {
  test.each(types)("$name pressed to its bearing depth has the bearing ratio and yields no more", (type) => {
    const pressed = press(fresh, bearingDepth(fresh, type, 40e3, 0.7), 0.7);
    expect(Math.abs(densityRatio(pressed) - bearingRatio(type, 40e3))).toBeLessThan(10 * ROUNDING);
    expect(bearingDepth(pressed, type, 40e3, 0.7)).toBeCloseTo(pressed.h, 12);
    expect(bearingDepth(pressed, type, 20e3, 0.7)).toBe(pressed.h);
  });

  test("the contact is a chord of the wheel, bounded at both ends", () => {
    // Sunk to the axle a wheel rests on its whole diameter, and no deeper wheel on more.
    expect(contactArea(wheel, 0.38)).toBeCloseTo(2 * 0.38 * 0.26, 12);
    expect(contactArea(wheel, 1)).toBe(contactArea(wheel, 0.38));
    expect(contactArea(wheel, 0)).toBe(contactArea(wheel, 1e-4));
    // R = 0.5, z = 0.2: the half chord is sqrt(0.5^2 - 0.3^2) = 0.4.
    expect(contactArea({ radius: 0.5, width: 1, load: 1 }, 0.2)).toBeCloseTo(0.8, 12);
  });
});

describe("sinkage", () => {
  const sinkage = (changed: object, column = fresh, type: SnowType = SNOW_TYPES.powder) =>
    wheelSinkage({ ...wheel, ...changed }, column, type, 0.7);

  test.each(types)("in $name the snow below bears the load", (type) => {
    const z = sinkage({}, fresh, type);
    const left = bearingDepth(fresh, type, wheel.load / contactArea(wheel, z), 0.7);
    // 32 halvings of 0.45 m, and the slope of what the snow yields with z is below 100.
    expect(Math.abs(fresh.h - z - left)).toBeLessThan(0.45 * 2 ** -32 * 100);
  });

  test("a heavier wheel sinks deeper, a wider one less, a larger one less", () => {
    expect(sinkage({ load: 7400 })).toBeGreaterThan(sinkage({}) + 0.02);
    expect(sinkage({ width: 0.4 })).toBeLessThan(sinkage({}) - 0.02);
    expect(sinkage({ radius: 0.5 })).toBeLessThan(sinkage({}));
    expect(sinkage({ load: 0 })).toBe(0);
  });

  test("powder gives way to a car's wheel by a hand or two, packed snow by centimetres, ice hardly", () => {
    const [powder, packed, ice] = types.map((type) => sinkage({}, fresh, type));
    expect(powder).toBeGreaterThan(0.12);
    expect(powder).toBeLessThan(0.32);
    expect(packed).toBeGreaterThan(0.005);
    expect(packed).toBeLessThan(0.05);
    expect(ice).toBeLessThan(0.002);
  });

  test("packed snow bears the second wheel", () => {
    const z = sinkage({});
    const rut = press(fresh, fresh.h - z, 0.7);
    // The second wheel starts on a flat floor, so its contact is shorter at first: it sinks a little, not again.
    expect(sinkage({}, rut)).toBeLessThan(0.35 * z);
  });

  test("types mix between their neighbours", () => {
    const half = sinkage({}, fresh, mixSnow([0.5, 0.5, 0]));
    expect(half).toBeLessThan(sinkage({}));
    expect(half).toBeGreaterThan(sinkage({}, fresh, SNOW_TYPES.packed));
    expect(mixSnow([0, 1, 0]).name).toBe("packed");
    expect(mixSnow([0, 0, 1]).pressure).toBeCloseTo(SNOW_TYPES.ice.pressure, 3);
  });
});

describe("time", () => {
  const rut: Column = { h: 0.2, W: 0.35 };

  test.each([1, 20, 60, 144])("%i steps a second give D exp(-t / tau)", (rate) => {
    let column = rut;
    for (let i = 0; i < 3 * rate; i++) column = recover(column, 0.45, passing(1 / rate, 5, 0));
    expect(Math.abs(0.45 - column.h - 0.25 * Math.exp(-3 / 5))).toBeLessThan(3 * rate * ROUNDING);
    expect(Math.abs(0.45 - column.W - 0.1 * Math.exp(-3 / 5))).toBeLessThan(3 * rate * ROUNDING);
  });

  test("snowfall alone fills a track in a straight line and not above the fresh depth", () => {
    expect(recover(rut, 0.45, passing(10, Infinity, 0.01))).toEqual({ h: 0.2 + 0.1, W: 0.35 + 0.1 });
    expect(recover(rut, 0.45, passing(100, Infinity, 0.01)).h).toBe(0.45);
    expect(recover({ h: 0.5, W: 0.6 }, 0.45, passing(10, Infinity, 0.01))).toEqual({ h: 0.5, W: 0.6 });
  });

  test("recovery and snowfall together do not depend on the steps", () => {
    const once = recover(rut, 0.45, passing(10, 30, 0.005));
    let often = rut;
    for (let i = 0; i < 1000; i++) often = recover(often, 0.45, passing(0.01, 30, 0.005));
    expect(Math.abs(often.h - once.h)).toBeLessThan(1000 * ROUNDING);
    expect(Math.abs(often.W - once.W)).toBeLessThan(1000 * ROUNDING);
  });

  test("no time and no end of time change nothing, bit for bit", () => {
    expect(recover(rut, 0.45, passing(0, 5, 0.1))).toEqual(rut);
    expect(recover(rut, 0.45, passing(1e6, Infinity, 0))).toEqual(rut);
  });

  test("rims recover too", () => {
    const { h } = recover({ h: 0.55, W: 0.6 }, 0.45, passing(5, 5, 0));
    expect(h - 0.45).toBeCloseTo(0.1 * Math.exp(-1), 12);
  });
});

test("packed snow stands steeper, by a bounded factor", () => {
  const loose = Math.tan((42 * Math.PI) / 180);
  expect(standingSlope(42, 1)).toBeCloseTo(loose, 12);
  expect(standingSlope(42, 1.2)).toBeCloseTo(1.5 * loose, 12);
  expect(standingSlope(42, 5)).toBeCloseTo(2 * loose, 12);
});

test("a spinning wheel leaves less beside it", () => {
  expect(sideShare(0.8, 0)).toBe(0.8);
  expect(sideShare(0.8, -3)).toBeCloseTo(0.4, 12);
});

test("neve drive --fit has the same law: a table that both hold", () => {
  for (const { strain, pressure, compaction, radius, width, load, depth, sinkage } of table) {
    const type = { ...SNOW_TYPES.powder, strain, pressure };
    const z = wheelSinkage({ radius, width, load }, { h: depth, W: depth }, type, compaction);
    // 32 halvings leave 2^-33 of the depth, the table has 12 decimals.
    expect(Math.abs(z - sinkage)).toBeLessThan(depth * 2 ** -33 + 1e-12);
  }
});

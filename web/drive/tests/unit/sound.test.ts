import { describe, expect, it } from "vitest";
import { needleAngle } from "../../src/render/car/cockpit";
import { pictureSize } from "../../src/page/photo";
import { mixOf } from "../../src/page/sound";

const wheel = (slip: number, sinkage: number, grounded = true) => ({
  ...{ centre: [0, 0, 0] as [number, number, number], steer: 0, spin: 0, radius: 0.38, width: 0.26 },
  ...{ load: 3700, slip, sinkage, sideForce: 0, grounded },
});
const state = (speed: number, revs: number, enginePower: number, wheels = [wheel(0, 0.1)]) => ({
  ...{ speed, revs, enginePower, wheels },
});

describe("the sound", () => {
  it("of the engine rises with the revs, and is louder the more it pulls", () => {
    expect(mixOf(state(5, 0.8, 0), false).pitch).toBeCloseTo(4 * mixOf(state(5, 0.2, 0), false).pitch, 9);
    expect(mixOf(state(5, 0.8, 8e4), false).engine).toBeGreaterThan(
      2 * mixOf(state(5, 0.8, 0), false).engine,
    );
    expect(mixOf(state(0, 0, 0), false).pitch).toBeGreaterThan(20); // it idles
  });

  it("of the tyres needs a way or a slip, and ground below; deep snow is duller", () => {
    expect(mixOf(state(0, 0.2, 0), false).tyres).toBe(0);
    expect(mixOf(state(15, 0.2, 0, [wheel(0, 0.1, false)]), false).tyres).toBe(0);
    expect(mixOf(state(0, 0.2, 0, [wheel(6, 0.1)]), false).tyres).toBeGreaterThan(0.2);
    const [packed, deep] = [0, 0.3].map((sinkage) => mixOf(state(10, 0.2, 0, [wheel(0, sinkage)]), false));
    expect(deep!.crunch).toBeLessThan(0.5 * packed!.crunch);
  });

  it("of the wind grows with the square of the speed, and is half as loud inside", () => {
    const wind = (speed: number, inside = false) => mixOf(state(speed, 0.2, 0), inside).wind;
    expect(wind(20)).toBeCloseTo(4 * wind(10), 12);
    expect(wind(20, true)).toBeCloseTo(0.5 * wind(20), 12);
    expect(wind(1e3)).toBe(1);
  });
});

it("needles sweep three quarters of a turn and stay on the dial", () => {
  expect(needleAngle(0)).toBeCloseTo(-0.75 * Math.PI, 12);
  expect(needleAngle(0.5)).toBe(0);
  expect(needleAngle(7)).toBeCloseTo(0.75 * Math.PI, 12);
});

it("a saved picture has the canvas's shape, a longer side as asked for, and even sides", () => {
  expect(pictureSize(1920, 1080, 3840)).toEqual([3840, 2160]);
  expect(pictureSize(390, 844, 3840)).toEqual([1774, 3840]);
  expect(pictureSize(0, 0, 1920).every((side) => side >= 2)).toBe(true);
});

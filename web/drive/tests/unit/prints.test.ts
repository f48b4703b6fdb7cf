import { describe, expect, it } from "vitest";
import { press } from "../../src/snow/law";
import { Prints, underside } from "../../src/snow/prints";
import type { BoxStamp, WheelStamp } from "../../src/snow/stamps";

const WHEEL: WheelStamp = {
  shape: "wheel",
  x: 2,
  y: 0.5,
  z: -1,
  heading: 0.7,
  radius: 0.4,
  width: 0.3,
  slip: 0,
};
const BOX: BoxStamp = {
  shape: "box",
  x: 0,
  y: 0.2,
  z: 0,
  heading: 0,
  length: 4,
  width: 2,
  slopeAlong: 0.1,
  slopeAcross: -0.2,
};

/** A place so far along and across the heading of a stamp [m]. */
function place(stamp: WheelStamp | BoxStamp, along: number, across: number): [number, number] {
  const [c, s] = [Math.cos(stamp.heading), Math.sin(stamp.heading)];
  return [stamp.x + c * along - s * across, stamp.z + s * along + c * across];
}

describe("underside", () => {
  it("is the circle of a wheel, and nothing beside it", () => {
    for (const along of [-0.39, -0.1, 0, 0.25])
      expect(underside(WHEEL, ...place(WHEEL, along, 0.05))).toBeCloseTo(
        0.5 - Math.sqrt(0.16 - along ** 2),
        12,
      );
    expect(underside(WHEEL, ...place(WHEEL, 0.41, 0))).toBe(Infinity);
    expect(underside(WHEEL, ...place(WHEEL, 0, 0.151))).toBe(Infinity);
    // At the very edge the tread has risen by the radius of the shoulder.
    expect(underside(WHEEL, ...place(WHEEL, 0, 0.15))).toBeCloseTo(0.5 - 0.4 + 0.04, 6);
  });

  it("is the least of all places between two updates", () => {
    const [x, z] = place(WHEEL, -1.5, 0);
    const rolled: WheelStamp = { ...WHEEL, from: { x, y: 0.6, z } };
    for (const back of [0.3, 0.75, 1.2]) {
      const there = place(WHEEL, -back, 0);
      // The wheel was over this place after the share back / 1.5 of its way, and its axle was so much higher.
      expect(underside(rolled, ...there)).toBeCloseTo(0.1 + (0.1 * back) / 1.5, 12);
    }
  });

  it("does not sweep when the stamp was put elsewhere", () => {
    expect(underside({ ...WHEEL, from: { x: 50, y: 0.5, z: -1 } }, 20, -1)).toBe(Infinity);
  });

  it("is the tilted plane of a box", () => {
    expect(underside(BOX, 1, 0.5)).toBeCloseTo(0.2 + 0.1 - 0.1, 12);
    expect(underside(BOX, 2.1, 0)).toBe(Infinity);
  });
});

describe("prints", () => {
  const fresh = { h: 0.45, W: 0.45 };
  const at = (prints: Prints) => prints.press(fresh, 2, -1, 0, 0.7);

  it("press a column by the law, however many of them", () => {
    const prints = new Prints();
    expect(at(prints)).toBe(fresh);
    prints.add([WHEEL]);
    prints.add([WHEEL, { ...WHEEL, y: 0.55 }]);
    expect(at(prints).h).toBeCloseTo(0.1, 12);
    expect(at(prints)).toEqual(press(fresh, at(prints).h, 0.7));
  });

  it("are forgotten up to the update whose snow was read, and no further", () => {
    const prints = new Prints();
    const first = prints.add([WHEEL]);
    const second = prints.add([{ ...WHEEL, y: 0.6 }]);
    prints.forget(first);
    expect(at(prints).h).toBeCloseTo(0.2, 12);
    prints.forget(second);
    expect(at(prints)).toBe(fresh);
  });
});

import { describe, expect, it } from "vitest";
import { PEAK_SLIP, roll, slidingGrip, slipCurve, type Footing, type Tyre } from "../../src/car/wheels/tyre";

const DT = 1 / 120;
const footing: Footing = {
  load: 4000,
  forward: 10,
  right: 0,
  friction: 0.5,
  sideFriction: 0.4,
  holdLeft: 0,
  holdRight: 0,
  radius: 0.38,
  inertia: 1.6,
  drive: 0,
  brake: 0,
};
const rolling = (speed: number): Tyre => ({ omega: speed / 0.38, along: 0, across: 0 });

/** Forces after a time long enough for everything to settle. */
function settle(tyre: Tyre, on: Footing, seconds = 2) {
  let out = roll(tyre, on, DT);
  for (let t = DT; t < seconds; t += DT) out = roll(tyre, on, DT);
  return out;
}

describe("slip curve", () => {
  it("rises from 0 to the full grip without a kink", () => {
    expect(slipCurve(0)).toBe(0);
    expect(slipCurve(1)).toBe(1);
    expect(slipCurve(7)).toBe(1);
    for (let x = 0; x < 1; x += 0.05) expect(slipCurve(x + 0.05)).toBeGreaterThan(slipCurve(x));
    expect((slipCurve(1) - slipCurve(1 - 1e-4)) / 1e-4).toBeLessThan(1e-3); // slope 1.5 - 1.5 x^2 at 1
  });

  it("loses a quarter of the grip in a fast slide", () => {
    expect(slidingGrip(0)).toBe(1);
    expect(slidingGrip(1e9)).toBeCloseTo(0.75, 12);
    expect(slidingGrip(-4)).toBeCloseTo(1 - 0.25 * (1 - Math.exp(-1)), 12);
  });
});

describe("tyre", () => {
  it("rolls freely without force", () => {
    const tyre = rolling(10);
    const out = settle(tyre, footing);
    expect(Math.abs(out.forward)).toBeLessThan(1e-6);
    expect(Math.abs(out.slip)).toBeLessThan(1e-9);
  });

  it("gives the torque of the engine to the ground as long as the grip lasts", () => {
    const drive = 0.5 * 0.5 * 4000 * 0.38; // half the grip
    const out = settle(rolling(10), { ...footing, drive });
    // In balance R F = torque; the bisection's 36 halvings leave nothing that counts.
    expect(out.forward).toBeCloseTo(drive / 0.38, 2);
    expect(out.slip / 10).toBeGreaterThan(0);
    expect(out.slip / 10).toBeLessThan(PEAK_SLIP);
  });

  it("spins under more torque than the grip holds, and never pushes with more than the grip", () => {
    const tyre = rolling(10);
    let before = 0;
    for (let i = 0; i < 120; i++) {
      const out = roll(tyre, { ...footing, drive: 1500 }, DT);
      expect(out.forward).toBeLessThanOrEqual(0.5 * 4000 + 1e-9);
      if (i > 20) expect(out.slip).toBeGreaterThan(before);
      before = out.slip;
    }
  });

  it("locks under a brake that is stronger than the grip and slides with the sliding grip", () => {
    const tyre = rolling(10);
    const out = settle(tyre, { ...footing, brake: 5000 });
    expect(tyre.omega).toBe(0);
    expect(out.forward).toBeCloseTo(-0.5 * 4000 * slidingGrip(10), 6);
  });

  it("brakes below the grip without locking", () => {
    const tyre = rolling(10);
    const out = settle(tyre, { ...footing, brake: 300 });
    expect(tyre.omega).toBeGreaterThan(20);
    expect(out.forward).toBeCloseTo(-300 / 0.38, 2);
  });

  it("resists moving sideways, both ways alike, never with more than its grip", () => {
    const left = settle(rolling(10), { ...footing, right: -3 });
    const right = settle(rolling(10), { ...footing, right: 3 });
    expect(left.right).toBeGreaterThan(0);
    expect(right.right).toBe(-left.right);
    expect(left.right).toBeLessThanOrEqual(0.4 * 4000);
  });

  it("holds more where a wall stands, and only against that wall", () => {
    const wall = { ...footing, holdLeft: 800 };
    const toLeft = settle(rolling(10), { ...wall, right: -3 }).right;
    const toRight = settle(rolling(10), { ...wall, right: 3 }).right;
    expect(toLeft / -toRight).toBeCloseTo((0.4 * 4000 + 800) / (0.4 * 4000), 12);
  });

  it("trades grip along for grip across: a locked wheel barely steers", () => {
    const free = settle(rolling(10), { ...footing, right: 0.8 });
    const locked = settle(rolling(10), { ...footing, right: 0.8, brake: 5000 });
    expect(Math.abs(locked.right)).toBeLessThan(0.3 * Math.abs(free.right));
  });
});

import { describe, expect, it } from "vitest";
import { clean, HANDS_OFF } from "../../src/car/driver/controls";
import {
  alive,
  DEAD_ZONE,
  Edges,
  fromKeys,
  fromPad,
  fromThumbs,
  merge,
  Smoothing,
} from "../../src/car/driver/input";

const keys = (...names: string[]) => fromKeys(new Set(names));

describe("keys", () => {
  it("steer, drive and brake by letters and by arrows", () => {
    expect(keys("KeyA").steer).toBe(-1);
    expect(keys("ArrowRight").steer).toBe(1);
    expect(keys("KeyA", "ArrowRight").steer).toBe(0);
    expect(keys("KeyW")).toEqual({ ...HANDS_OFF, throttle: 1 });
    expect(keys("ArrowDown", "Space", "KeyR")).toEqual({ ...HANDS_OFF, brake: 1, handbrake: 1, reset: true });
  });
});

describe("gamepad", () => {
  const pad = (axis: number, pressed: Record<number, number> = {}) => ({
    axes: [axis, 0, 0, 0],
    buttons: Array.from({ length: 17 }, (_, i) => ({
      value: pressed[i] ?? 0,
      pressed: (pressed[i] ?? 0) > 0.5,
    })),
  });

  it("has a dead zone without a step at its rim, and full lock at the end", () => {
    expect(alive(0.9 * DEAD_ZONE)).toBe(0);
    expect(alive(DEAD_ZONE + 1e-9)).toBeLessThan(1e-8);
    expect(alive(-1)).toBe(-1);
    expect(alive(1.3)).toBeLessThanOrEqual(1.34);
    expect(alive(NaN)).toBe(0);
    expect(merge(fromPad(pad(1.3))).steer).toBe(1);
  });

  it("reads triggers and buttons of the standard mapping", () => {
    expect(fromPad(pad(0, { 7: 0.6, 6: 0.2, 0: 1, 3: 1 }))).toEqual({
      steer: 0,
      throttle: 0.6,
      brake: 0.2,
      handbrake: 1,
      reset: true,
    });
    expect(fromPad({ axes: [], buttons: [] })).toEqual(HANDS_OFF);
  });
});

describe("thumbs", () => {
  it("steer on the left, drive upwards and brake downwards on the right", () => {
    expect(fromThumbs({ left: -0.1, right: 0.2 })).toEqual({ ...HANDS_OFF, steer: -0.25, throttle: 0.5 });
    expect(fromThumbs({ left: null, right: -0.2 })).toEqual({ ...HANDS_OFF, brake: 0.5 });
  });
});

describe("merging", () => {
  it("takes the strongest input of each kind, within its range", () => {
    const merged = merge(
      { ...HANDS_OFF, steer: 0.3, throttle: 5 },
      { ...HANDS_OFF, steer: -0.8, brake: NaN },
    );
    expect(merged).toEqual({ ...HANDS_OFF, steer: -0.8, throttle: 1 });
    expect(merge()).toEqual(HANDS_OFF);
  });

  it("cleans numbers that are none", () => {
    const dirty = { steer: NaN, throttle: -3, brake: Infinity, handbrake: 0.5, reset: false };
    expect(clean(dirty)).toEqual({ steer: 0, throttle: 0, brake: 1, handbrake: 0.5, reset: false });
  });
});

describe("smoothing", () => {
  it("moves at its rate, faster back than out, and arrives exactly", () => {
    const smooth = new Smoothing();
    const right = { ...HANDS_OFF, steer: 1 };
    expect(smooth.follow(right, 0.1).steer).toBeCloseTo(0.22, 12);
    for (let i = 0; i < 10; i++) smooth.follow(right, 0.1);
    expect(smooth.follow(right, 0.1).steer).toBe(1);
    expect(smooth.follow(HANDS_OFF, 0.1).steer).toBeCloseTo(0.55, 12);
    for (let i = 0; i < 10; i++) smooth.follow(HANDS_OFF, 0.1);
    expect(smooth.follow(HANDS_OFF, 0.1)).toEqual(HANDS_OFF);
  });

  it("gets as far in a second at any frame rate", () => {
    const ends = [20, 60, 144].map((rate) => {
      const smooth = new Smoothing();
      let steer = 0;
      for (let i = 0; i < 0.25 * rate; i++)
        steer = smooth.follow({ ...HANDS_OFF, steer: -1 }, 1 / rate).steer;
      return steer;
    });
    for (const end of ends) expect(end).toBeCloseTo(-0.55, 9); // 0.25 s times 2.2 per second
  });
});

describe("presses", () => {
  it("count once until they are let go", () => {
    const edges = new Edges();
    const held = { reset: false, camera: true, lights: false, figures: false };
    const free = { ...held, camera: false };
    expect([held, held, free, held].map((now) => edges.update(now).camera)).toEqual([
      true,
      false,
      false,
      true,
    ]);
  });
});

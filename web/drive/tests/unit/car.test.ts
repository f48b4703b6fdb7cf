import { describe, expect, it } from "vitest";
import type { Chassis } from "../../src/car/chassis/chassis";
import { HANDS_OFF, type Controls } from "../../src/car/driver/controls";
import { turn } from "../../src/car/geometry";
import { random } from "../../src/world/noise";
import { makeTerrain } from "../../src/world/terrain";
import { Car } from "../../src/car/vehicle";
import { ICE, options, PACKED, plain, POWDER } from "./car_world";

const FRAME = 1 / 60;

/** Let a car be driven for some seconds. */
function drive(car: Car, seconds: number, input: Partial<Controls>): Car {
  for (let i = 0; i < Math.round(seconds / FRAME); i++) car.step(FRAME, { ...HANDS_OFF, ...input });
  return car;
}

const onPlain = (kinds: [number, number, number], depth: number, changes = {}) =>
  Car.create(options(plain(kinds), depth, changes));

/** Brake a car to a stand; the way it takes [m]. */
function stop(car: Car): number {
  const from = car.state.position[0];
  for (let i = 0; i < 3000 && car.state.speed > 0.1; i++) car.step(FRAME, { ...HANDS_OFF, brake: 1 });
  return car.state.position[0] - from;
}

/** Speed up to at least `speed` [m/s] with full throttle. */
function reach(car: Car, speed: number): Car {
  for (let i = 0; i < 6000 && car.state.speed < speed; i++) car.step(FRAME, { ...HANDS_OFF, throttle: 1 });
  return car;
}

describe("a standing car", () => {
  it("puts its weight on its wheels and stands still", async () => {
    for (const mass of [900, 1500, 3000]) {
      const car = drive(await onPlain(PACKED, 0.2, { mass }), 3, {});
      const load = car.state.wheels.reduce((sum, wheel) => sum + wheel.load, 0);
      expect(Math.abs(load / (mass * 9.81) - 1)).toBeLessThan(0.02);
      const height = car.state.position[1];
      drive(car, 3, {});
      // The ride height of float32 positions near 1 m is known to 1e-7 m; springs have long come to rest.
      expect(Math.abs(car.state.position[1] - height)).toBeLessThan(1e-3);
    }
  });

  it("rides at the height it was built for, whatever its springs", async () => {
    for (const stiffness of [1, 1.6, 3]) {
      const car = drive(await onPlain(ICE, 0, { stiffness }), 6, {});
      // Tyre 0.38 m and 0.24 m up to the centre of mass; the spring force is per m, so the sag is exact.
      expect(Math.abs(car.state.position[1] - 0.62)).toBeLessThan(0.005);
    }
  });

  it("sinks deeper into softer snow and under more load", async () => {
    const sinkage = async (kinds: [number, number, number], mass: number) =>
      drive(await onPlain(kinds, 0.45, { mass }), 2, {}).state.wheels[0]!.sinkage;
    const [ice, packed, powder] = [
      await sinkage(ICE, 1500),
      await sinkage(PACKED, 1500),
      await sinkage(POWDER, 1500),
    ];
    expect(ice).toBeLessThan(packed);
    expect(packed).toBeLessThan(powder);
    expect(await sinkage(POWDER, 2500)).toBeGreaterThan(powder);
  });

  it("does not creep on a slope with the handbrake on, in ten seconds", async () => {
    // A slope of 12 degrees; packed snow holds 26 with all wheels, the two braked ones hold their share of it.
    const car = drive(await Car.create(options(plain(PACKED, 0.21), 0.1)), 3, { handbrake: 1 });
    const [x, y, z] = car.state.position;
    drive(car, 10, { handbrake: 1 });
    const [a, b, c] = car.state.position;
    expect(Math.hypot(a - x, b - y, c - z)).toBeLessThan(0.01); // anchors are springs; they do not slip
  });
});

describe("driving", () => {
  it("goes straight ahead and never gains more energy than the engine gives", async () => {
    const car = drive(await onPlain(PACKED, 0.2), 1, {});
    const watts = 160e3;
    let energy = 0;
    for (let i = 0; i < 20 * 60; i++) {
      car.step(FRAME, { ...HANDS_OFF, throttle: 1 });
      expect(car.state.enginePower).toBeLessThanOrEqual(watts * (1 + 1e-9));
      const now = 0.5 * 1500 * car.state.speed ** 2;
      // The frame's two steps at full power; what the springs hold moves to and fro, below 1 % of the weight times 0.1 m.
      expect(now - energy).toBeLessThan(watts * FRAME + 150);
      energy = now;
    }
    expect(car.state.speed).toBeGreaterThan(25);
    // Air drag alone bounds the speed: P = rho c A v^3 / 2 gives 66 m/s.
    expect(car.state.speed).toBeLessThan(Math.cbrt((2 * watts) / (1.3 * 0.85)));
    expect(Math.abs(car.state.position[2])).toBeLessThan(0.005 * car.state.position[0]);
  });

  it("turns left when steered left and right when steered right, mirrored", async () => {
    const turned = async (steer: number) => {
      const car = drive(reach(await onPlain(PACKED, 0.2), 8), 1.5, { steer, throttle: 0.2 });
      return turn(car.state.rotation, [1, 0, 0])[2];
    };
    const [left, right] = [await turned(-0.6), await turned(0.6)];
    expect(left).toBeLessThan(-0.3); // north of east
    // The two halves of the car are reckoned in an order, float32 differs by it: a hundredth is left over.
    expect(Math.abs(left + right)).toBeLessThan(0.02);
  });

  it("backs when the brake is held at rest, and comes forward again", async () => {
    const car = drive(await onPlain(PACKED, 0.2), 3, { brake: 1 });
    expect(car.state.speed).toBeLessThan(-2);
    expect(car.state.gear).toBe("R");
    drive(car, 4, { throttle: 1 });
    expect(car.state.speed).toBeGreaterThan(2);
  });

  it("stops on packed snow before powder-free ice, near v^2 / (2 mu g)", async () => {
    const way = async (kinds: [number, number, number], depth: number) => {
      const car = reach(await onPlain(kinds, depth), 14);
      const ideal = car.state.speed ** 2 / (2 * 9.81);
      return { way: stop(car), ideal };
    };
    const [packed, powder, ice] = [await way(PACKED, 0.2), await way(POWDER, 0.3), await way(ICE, 0.02)];
    expect(ice.way).toBeGreaterThan(3 * packed.way);
    expect(ice.way).toBeGreaterThan(3 * powder.way);
    // Never better than the whole grip of all four, and the anti-lock brake gives most of it: at least 80 %.
    expect(ice.way).toBeGreaterThan(ice.ideal / 0.14 / 1.1);
    expect(ice.way).toBeLessThan(ice.ideal / 0.14 / 0.8);
  });

  it("is slower the deeper the snow", async () => {
    const speeds: number[] = [];
    for (const depth of [0.1, 0.25, 0.4, 0.55]) {
      speeds.push(drive(await onPlain(POWDER, depth), 8, { throttle: 1 }).state.speed);
    }
    for (let i = 1; i < speeds.length; i++) expect(speeds[i]!).toBeLessThan(speeds[i - 1]! - 0.3);
    expect(speeds[3]!).toBeGreaterThan(1); // yet it gets along
  });

  it("slips more on ice for the same pedal", async () => {
    const slip = async (kinds: [number, number, number]) => {
      const car = await onPlain(kinds, 0.05);
      let sum = 0;
      for (let i = 0; i < 180; i++) {
        car.step(FRAME, { ...HANDS_OFF, throttle: 0.4 });
        sum += car.state.wheels[0]!.slip / 180;
      }
      return sum;
    };
    const [ice, packed] = [await slip(ICE), await slip(PACKED)];
    expect(ice).toBeGreaterThan(2);
    expect(ice).toBeGreaterThan(3 * packed);
  });

  it("slides with the handbrake: the rear wheels lock and the car turns further", async () => {
    const turned = async (handbrake: number) => {
      const car = drive(reach(await onPlain(PACKED, 0.2), 12), 1.2, { steer: -0.5, handbrake });
      return Math.atan2(-turn(car.state.rotation, [1, 0, 0])[2], turn(car.state.rotation, [1, 0, 0])[0]);
    };
    expect(await turned(1)).toBeGreaterThan(1.2 * (await turned(0)));
  });
});

describe("ruts", () => {
  it("hold the wheels: it takes more force to leave them than to leave level snow", async () => {
    // Packed floor 0.5 m wide below walls of packed snow, along the track of both wheels; or the same floor everywhere.
    const floor = { h: 0.12, W: 0.4 };
    const inRut = (z: number) => Math.abs(Math.abs(z) - 0.78) < 0.22;
    const world = (walls: boolean) => ({
      ...options(plain(POWDER), 0.3),
      snow: (_: number, z: number) => (inRut(z) || !walls ? floor : { h: 0.4, W: 0.5 }),
    });
    const strayed = async (walls: boolean) => {
      const car = drive(await Car.create(world(walls)), 1.5, { throttle: 0.5 });
      drive(car, 1, { throttle: 0.2, steer: 0.12 });
      return Math.abs(car.state.position[2]);
    };
    const [free, held] = [await strayed(false), await strayed(true)];
    expect(free).toBeGreaterThan(0.1);
    expect(held).toBeLessThan(0.7 * free);
  });
});

describe("recovery", () => {
  it("stands on its wheels again after it lay on its roof", async () => {
    const car = await onPlain(PACKED, 0.2);
    const inside = car as unknown as { chassis: Chassis };
    inside.chassis.put([3, 1.2, 4], [0, -0.995, Math.sqrt(1 - 0.995 ** 2)], 0.4);
    drive(car, 1.5, { throttle: 1 });
    expect(turn(car.state.rotation, [0, 1, 0])[1]).toBeLessThan(-0.9);
    drive(car, 1.5, { reset: true });
    expect(turn(car.state.rotation, [0, 1, 0])[1]).toBeGreaterThan(0.999);
    expect(car.state.wheels.every((wheel) => wheel.grounded)).toBe(true);
  });

  it("stands still after a reset in full swing", async () => {
    const car = reach(await onPlain(PACKED, 0.2), 10);
    for (let i = 0; i < 90; i++) car.step(FRAME, { ...HANDS_OFF, steer: i % 2 ? 1 : -1, throttle: 1 });
    const [x, , z] = car.state.position;
    car.step(FRAME, { ...HANDS_OFF, reset: true });
    drive(car, 2, {});
    expect(turn(car.state.rotation, [0, 1, 0])[1]).toBeGreaterThan(0.999);
    expect(Math.abs(car.state.speed)).toBeLessThan(0.05);
    expect(car.state.wheels.every((wheel) => wheel.grounded)).toBe(true);
    expect(Math.hypot(car.state.position[0] - x, car.state.position[2] - z)).toBeLessThan(0.5);
  });

  it("resets once for each press", async () => {
    const car = drive(await onPlain(PACKED, 0.2), 2, { throttle: 1, reset: true });
    expect(car.state.speed).toBeGreaterThan(2);
  });
});

describe("frames", () => {
  it("drives the same at 20, 60 and 144 frames per second", async () => {
    const places: number[][] = [];
    for (const rate of [20, 60, 144]) {
      const car = await onPlain(PACKED, 0.2);
      for (let i = 1; i <= 4 * rate; i++) {
        const t = i / rate;
        car.step(1 / rate, { ...HANDS_OFF, throttle: 1, steer: t > 2 ? -0.4 : 0 });
      }
      places.push([...car.state.position]);
    }
    // The steps are the same; the input to steer comes up to 1/20 s earlier or later, and what is drawn lies up to one
    // step behind: 8 m/s x (1/20 + 1/120) s x 0.4 of the bend.
    for (const place of places) {
      for (let k = 0; k < 3; k++) expect(Math.abs(place[k]! - places[1]![k]!)).toBeLessThan(0.2);
    }
  });

  it("takes exactly the same steps for constant inputs", async () => {
    const ends: number[] = [];
    for (const rate of [20, 60, 120]) {
      const car = await onPlain(PACKED, 0.2);
      for (let i = 0; i < 3 * rate; i++) car.step(1 / rate, { ...HANDS_OFF, throttle: 0.7, steer: -0.2 });
      ends.push(car.state.velocity[0], car.state.velocity[2]);
    }
    // At these rates the drawn state lies on a step up to the rounding of the clock, about 1e-13 s; times 12 m/s2.
    for (let i = 2; i < 6; i++) expect(Math.abs(ends[i]! - ends[i % 2]!)).toBeLessThan(1e-9);
  });

  it("survives no time, negative time, a very long frame and inputs that are no numbers", async () => {
    const car = await onPlain(PACKED, 0.2);
    for (const dt of [0, -1, NaN, 100]) car.step(dt, { ...HANDS_OFF, throttle: NaN, steer: Infinity });
    expect(car.state.position.every(Number.isFinite)).toBe(true);
    expect(Math.hypot(...car.state.velocity)).toBeLessThan(1);
  });
});

describe("the endless world", () => {
  const terrain = makeTerrain(1);
  const world = () => ({
    ...options(terrain, 0.35),
    snow: (x: number, z: number) => {
      const depth = 0.35 * terrain.cover(x, z);
      return { h: depth, W: depth };
    },
  });

  it("carries the car for a kilometre", async () => {
    const car = await Car.create(world());
    let [way, x, z] = [0, 0, 0];
    for (let i = 0; i < 300 * 20 && way < 1000; i++) {
      car.step(1 / 20, { ...HANDS_OFF, throttle: 1, steer: Math.sin(i / 90) * 0.6 });
      const [a, y, b] = car.state.position;
      way += Math.hypot(a - x, b - z);
      [x, z] = [a, b];
      // The middle of the car is never below the ground, even where it lies on its side.
      expect(y).toBeGreaterThan(terrain.height(a, b));
    }
    expect(way).toBeGreaterThan(1000);
  }, 200_000);

  it("keeps its numbers under a minute of random inputs", async () => {
    const car = await Car.create(world());
    for (let i = 0; i < 60 * 20; i++) {
      const input = (k: number) => random(Math.floor(i / 8), k, 77);
      car.step(1 / 20, {
        steer: 2 * input(1) - 1,
        throttle: input(2),
        brake: input(3) > 0.8 ? input(4) : 0,
        handbrake: input(5) > 0.85 ? 1 : 0,
        reset: input(6) > 0.97,
      });
      const { position, rotation, velocity, wheels } = car.state;
      const numbers = [
        ...position,
        ...rotation,
        ...velocity,
        ...wheels.flatMap((w) => [...w.centre, w.slip, w.load, w.spin]),
      ];
      expect(numbers.every(Number.isFinite)).toBe(true);
      expect(Math.hypot(...velocity)).toBeLessThan(60);
    }
  }, 200_000);

  it("is as steady four kilometres away as at the start", async () => {
    const far = { terrain: plain(PACKED), start: { x: 4000, z: -4000, heading: 0.7 } };
    const car = drive(await Car.create({ ...options(far.terrain, 0.2), start: far.start }), 2, {});
    const height = car.state.position[1];
    drive(car, 2, {});
    // float32 near 4000 is known to 2.4e-4 m; the height itself is small and exact.
    expect(Math.abs(car.state.position[1] - height)).toBeLessThan(1e-3);
    expect(Math.hypot(car.state.position[0] - 4000, car.state.position[2] + 4000)).toBeLessThan(0.05);
  });
});

describe("stamps", () => {
  it("are the wheels where they stand, and name the place before", async () => {
    const car = drive(await onPlain(PACKED, 0.2), 1, {});
    const first = car.stamps();
    expect(first.map(({ shape }) => shape)).toEqual(["wheel", "wheel", "wheel", "wheel"]);
    drive(car, 1, { throttle: 1 });
    const second = car.stamps();
    for (const [i, print] of second.entries()) {
      expect(print.from).toEqual({ x: first[i]!.x, y: first[i]!.y, z: first[i]!.z });
      expect(print.x).toBeGreaterThan(first[i]!.x);
      expect(Math.abs(print.heading)).toBeLessThan(0.01);
    }
    car.reset();
    for (const print of car.stamps()) expect(print.from).toBeUndefined();
  });

  it("press no deeper than the wheel sinks", async () => {
    const car = drive(await onPlain(POWDER, 0.45), 2, {});
    const wheel = car.state.wheels[0]!;
    // Pads and springs come to rest within a millimetre.
    expect(Math.abs(wheel.centre[1] - wheel.radius - (0.45 - wheel.sinkage))).toBeLessThan(0.002);
  });

  it("have the underside where the car lies on deep snow", async () => {
    const car = drive(await onPlain(POWDER, 1.1), 2, {});
    const box = car.stamps().find(({ shape }) => shape === "box");
    expect(box).toBeDefined();
    expect(box!.y).toBeLessThan(1.1);
    expect(car.state.ploughing).toBeGreaterThan(0);
  });
});

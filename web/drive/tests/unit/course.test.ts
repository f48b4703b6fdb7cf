import { describe, expect, it } from "vitest";
import { Car } from "../../src/car/vehicle";
import { yaw, type Vec } from "../../src/car/geometry";
import type { CarState } from "../../src/car/state";
import {
  clock,
  Course,
  crossing,
  GATES,
  HALF,
  layCourse,
  tellCourse,
  type Gate,
} from "../../src/course/course";
import { carAt, driveOf, LONGEST, Recorder, ROW } from "../../src/course/run";
import { trackDriver } from "../../src/others/driver";
import { OtherCar } from "../../src/others/other_car";
import track from "../../src/others/track.json";
import { makeTerrain } from "../../src/world/terrain";
import { options, plain, POWDER } from "./car_world";

/** A car at a place with a heading [rad] and a speed [m/s]. */
function car(x: number, z: number, heading = 0, speed = 0): CarState {
  const velocity: Vec = [speed * Math.cos(heading), 0, speed * Math.sin(heading)];
  const rest = { angular: [0, 0, 0] as Vec, wheels: [], gear: "1", revs: 0, enginePower: 0, ploughing: 0 };
  return { position: [x, 0.7, z], rotation: yaw(-heading), velocity, speed, ...rest };
}

const GATE: Gate = { x: 10, z: 0, heading: 0 };
/** Three gates along x, so that a drive along x passes all of them. */
const ROW_OF_GATES: Gate[] = [0, 20, 40].map((x) => ({ x, z: 0, heading: 0 }));

describe("a gate", () => {
  it("is passed between its poles and forward alone, at the share of the way where it stands", () => {
    expect(crossing(GATE, [9, 0], [11, 0])).toBe(0.5);
    expect(crossing(GATE, [8, 2], [12, 2])).toBe(0.5);
    expect(crossing(GATE, [11, 0], [9, 0])).toBeNull();
    expect(crossing(GATE, [9, HALF + 0.01], [11, HALF + 0.01])).toBeNull();
    expect(crossing(GATE, [8, 0], [9.9, 0])).toBeNull();
    // Slanting: where it crosses counts, not where it ends.
    expect(crossing(GATE, [9, HALF - 0.5], [11, HALF + 0.4])).toBe(0.5);
  });
});

describe("the course", () => {
  /** Drive along x at 10 m/s in frames of dt; the events and when they came. */
  function drive(course: Course, from: number, to: number, dt: number) {
    const events: [string, number][] = [];
    let time = 0;
    for (let x = from; x < to; x += 10 * dt, time += dt) {
      const event = course.step(dt, car(x, 0, 0, 10));
      if (event) events.push([event, time]);
    }
    return events;
  }

  it("measures from gate to gate, whatever the frames are", () => {
    for (const dt of [1 / 20, 1 / 60, 0.037]) {
      const course = new Course(ROW_OF_GATES);
      expect(drive(course, -5, 45, dt).map(([event]) => event)).toEqual(["started", "passed", "passed"]);
      // From gate 0 to where it stopped, at most a frame before 45 m.
      expect(course.time! - 4.5).toBeLessThan(1e-9);
      expect(4.5 - course.time!).toBeLessThan(dt + 1e-9);
      // Put back before the start, it finishes: 4.5 s, and the way from -5 m.
      drive(course, -5, 1, dt);
      expect(course.best!.time).toBeGreaterThan(4.9);
      expect(course.best!.time).toBeLessThan(5 + 2 * dt);
    }
  });

  it("counts gates in their order, and begins the next run where one ends", () => {
    const course = new Course(ROW_OF_GATES);
    drive(course, -5, 5, 0.05);
    expect(drive(course, 35, 45, 0.05)).toEqual([]);
    expect(course.next).toBe(1);
    drive(course, 15, 45, 0.05);
    expect(drive(course, -5, 5, 0.05).map(([event]) => event)).toEqual(["record"]);
    expect(course.next).toBe(1);
    expect(course.time).toBeLessThan(0.51);
    course.abandon();
    expect([course.time, course.next]).toEqual([null, 0]);
  });

  it("keeps the fastest run alone, and tells how far another is behind it", () => {
    const course = new Course(ROW_OF_GATES);
    for (const [a, b] of [[-5, 45], [-5, 5]] as const) drive(course, a, b, 0.05); // prettier-ignore
    const best = course.best!.time;
    for (let wait = 0; wait < 40; wait++) course.step(0.05, car(5, 0));
    drive(course, 5, 25, 0.05);
    expect(course.behind).toBeGreaterThan(1.9);
    expect(tellCourse(course)).toContain(`best ${clock(best)}`);
    drive(course, 25, 45, 0.05);
    expect(drive(course, -5, 5, 0.05).map(([event]) => event)).toEqual(["finished"]);
    expect(course.best!.time).toBe(best);
  });

  it("says minutes, seconds and tenths", () => {
    expect([0, 9.96, 61.25, 600].map(clock)).toEqual(["0:00.0", "0:09.9", "1:01.2", "10:00.0"]);
  });

  it("lies in a ring on land that a car can drive, with gates that look along it", () => {
    const terrain = makeTerrain(7);
    const gates = layCourse(terrain, 7);
    expect(gates).toHaveLength(GATES);
    gates.forEach(({ x, z, heading }, k) => {
      const next = gates[(k + 1) % GATES]!;
      const [dx, dz] = [next.x - x, next.z - z];
      expect(Math.cos(heading) * dx + Math.sin(heading) * dz).toBeGreaterThan(0.5 * Math.hypot(dx, dz));
      expect(Math.hypot(...terrain.slope(x, z))).toBeLessThan(0.5);
    });
  });

  it("is driven by a simple driver on the car's own physics", async () => {
    const course = new Course([0, 1, 2, 3].map((k) => {
      const angle = (Math.PI / 2) * k;
      return { x: 25 * Math.cos(angle), z: 25 * Math.sin(angle), heading: angle + Math.PI / 2 };
    })); // prettier-ignore
    const start = { x: 25, z: -8, heading: Math.PI / 2 };
    const one = await Car.create({ ...options(plain(POWDER), 0.3), start });
    for (let n = 0; n < 60 * 60 && !course.best; n++) {
      one.step(1 / 60, trackDriver(one.state, course.gates[course.next]!, 8));
      course.step(1 / 60, one.state);
    }
    one.dispose();
    // A ring of 157 m at no more than 8 m/s and some.
    expect(course.best!.time).toBeGreaterThan(157 / 10);
    expect(course.best!.time).toBeLessThan(50);
  });
});

describe("a drive", () => {
  it("shows the car where it was, between two samples as well", () => {
    const recorder = new Recorder();
    for (let n = 0; n <= 120; n++) recorder.take(n / 60, car((8 * n) / 60, 0, 0, 8));
    const drive = recorder.done(2)!;
    for (const time of [0, 0.55, 1.23, 1.9]) {
      const state = carAt(drive, time, 0.38, 0.26);
      // A sample is taken in the first frame after it is due.
      expect(Math.abs(state.position[0] - 8 * time)).toBeLessThan(8 / 60 + 1e-3);
      expect(state.velocity[0]).toBeCloseTo(8, 0);
      expect(state.wheels).toHaveLength(4);
    }
    expect(carAt(drive, 99, 0.38, 0.26).position[0]).toBeCloseTo(16, 1);
  });

  it("that is damaged or endless is none", () => {
    expect(driveOf({ time: 1, rows: Array(2 * ROW).fill(0) })).not.toBeNull();
    for (const wrong of [
      null,
      3,
      {},
      { time: 1, rows: [1] },
      { time: -1, rows: Array(18).fill(0) },
      { time: 1, rows: Array(18).fill("x") },
      { time: 1, rows: Array(17).fill(0) },
      { time: 1e9, rows: Array(18).fill(0) },
    ])
      // prettier-ignore
      expect(driveOf(wrong)).toBeNull();
    const recorder = new Recorder();
    recorder.take(LONGEST + 1, car(0, 0));
    expect(recorder.done(LONGEST + 1)).toBeNull();
  });
});

describe("the other car", () => {
  const drive = driveOf(track)!;
  const tyres = { tyreRadius: 0.38, tyreWidth: 0.26 };
  const away: Vec = [1e4, 0, 0];

  it("goes round its track, presses the snow without gaps, and leaves none where it begins anew", () => {
    const other = new OtherCar(drive, tyres);
    let longest = 0;
    for (let time = 0; time < drive.time + 2; time += 1 / 30)
      for (const { x, z, from } of other.step(1 / 30, away)) {
        if (!from) continue;
        longest = Math.max(longest, Math.hypot(x - from.x, z - from.z));
      }
    // At 12 m/s at most, in a frame.
    expect(longest).toBeLessThan(12 / 30 + 0.1);
    expect(longest).toBeGreaterThan(0.1);
  });

  it("stops for who stands before it, and goes on", () => {
    const other = new OtherCar(drive, tyres);
    const ahead = carAt(drive, 0.3 * drive.time + 1.2, 0.38, 0.26).position;
    for (let n = 0; n < 150; n++) other.step(1 / 30, ahead);
    const [x, , z] = other.state.position;
    expect(Math.hypot(x - ahead[0], z - ahead[2])).toBeGreaterThan(2);
    other.step(1 / 30, ahead);
    expect(Math.hypot(other.state.position[0] - x, other.state.position[2] - z)).toBeLessThan(0.02);
    for (let n = 0; n < 60; n++) other.step(1 / 30, away);
    expect(Math.hypot(other.state.position[0] - x, other.state.position[2] - z)).toBeGreaterThan(3);
  });

  it("stands as much higher as it is told to", () => {
    const low = new OtherCar(drive, tyres).state;
    const high = new OtherCar(drive, tyres, () => 0.2).state;
    expect(high.position[1] - low.position[1]).toBeCloseTo(0.2, 12);
    expect(high.wheels[3]!.centre[1] - low.wheels[3]!.centre[1]).toBeCloseTo(0.2, 12);
  });
});

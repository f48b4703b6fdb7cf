import { PerspectiveCamera } from "three";
import { describe, expect, it } from "vitest";
import { ABOVE, aim, Cameras, CAMERAS, STILL, type View } from "../../src/car/driver/cameras";
import { yaw, type Vec } from "../../src/car/geometry";
import type { CarState } from "../../src/car/state";

function car(position: Vec, heading: number, speed = 0): CarState {
  const velocity: Vec = [speed * Math.cos(heading), 0, speed * Math.sin(heading)];
  const rest = { angular: [0, 0, 0] as Vec, wheels: [], gear: "1", revs: 0, enginePower: 0, ploughing: 0 };
  return { position, rotation: yaw(-heading), velocity, speed, ...rest };
}

const flat = () => 0;
const distance = (view: View, to: Vec) => Math.hypot(...view.position.map((value, k) => value - to[k]!));

describe("cameras", () => {
  it("come one after the other and around again", () => {
    const cameras = new Cameras(flat);
    expect([1, 2, 3, 4].map(() => cameras.next())).toEqual([...CAMERAS.slice(1), CAMERAS[0]]);
  });

  it("chase from behind and above, whatever the heading", () => {
    for (const heading of [0, 1, 3, -2]) {
      const { position, target } = new Cameras(flat).update(car([10, 1, 20], heading), 0.1);
      const [dx, dz] = [position[0] - 10, position[2] - 20];
      expect(dx * Math.cos(heading) + dz * Math.sin(heading)).toBeLessThan(-4);
      expect(Math.abs(-dx * Math.sin(heading) + dz * Math.cos(heading))).toBeLessThan(1e-9);
      expect(position[1]).toBeGreaterThan(target[1]);
    }
  });

  it("turn after the car by the same angle at any frame rate", () => {
    const ends = [20, 60, 144].map((rate) => {
      const cameras = new Cameras(flat);
      cameras.update(car([0, 1, 0], 0), 1 / rate);
      let view = cameras.update(car([0, 1, 0], 1), 0);
      for (let i = 0; i < rate / 4; i++) view = cameras.update(car([0, 1, 0], 1), 1 / rate);
      return view.position;
    });
    // Exponential following is exact in the time step: only rounding is left.
    for (const end of ends) for (let k = 0; k < 3; k++) expect(end[k]).toBeCloseTo(ends[0]![k]!, 9);
    const turned = Math.atan2(-ends[0]![2], -ends[0]![0]);
    expect(turned).toBeCloseTo(1 - Math.exp(-3.2 / 4), 9);
  });

  it("never go below the snow", () => {
    const hills = (x: number, z: number) => 6 * Math.sin(x / 9) * Math.cos(z / 7);
    for (const name of ["chase", "free", "top"] as const) {
      const cameras = new Cameras(hills);
      cameras.choose(name);
      for (let i = 0; i < 300; i++) {
        const state = car([i / 3, hills(i / 3, 5) + 0.8, 5], i / 40, 10);
        const { position } = cameras.update(state, 1 / 30, { ...STILL, tilt: -0.05, turn: 0.03 });
        expect(position[1]).toBeGreaterThanOrEqual(hills(position[0], position[2]) + ABOVE - 1e-9);
      }
    }
  });

  it("sit in the cockpit and look ahead", () => {
    const cameras = new Cameras(flat);
    cameras.choose("cockpit");
    const { position, target } = cameras.update(car([0, 1, 0], 0.5), 0.1);
    expect(distance({ position, target, fov: 0 }, [0, 1, 0])).toBeLessThan(1);
    expect(Math.atan2(target[2] - position[2], target[0] - position[0])).toBeCloseTo(0.5, 9);
  });

  it("look down from the top", () => {
    const cameras = new Cameras(flat);
    cameras.choose("top");
    const { position, target } = cameras.update(car([3, 1, 4], 0), 0.1);
    expect(position[1] - target[1]).toBeGreaterThan(15);
    expect(Math.hypot(position[0] - 3, position[2] - 4)).toBeLessThan(5);
  });

  it("orbit, zoom and fly freely", () => {
    const cameras = new Cameras(flat);
    cameras.choose("free");
    const state = car([0, 1, 0], 0);
    const far = distance(cameras.update(state, 0.1), [0, 1.4, 0]);
    expect(distance(cameras.update(state, 0.1, { ...STILL, zoom: -0.5 }), [0, 1.4, 0])).toBeCloseTo(
      far * Math.exp(-0.5),
      9,
    );
    const before = cameras.update(state, 0);
    const after = cameras.update(state, 1, { ...STILL, ahead: 1, up: 1 });
    expect(after.target[0] - before.target[0]).toBeCloseTo(14, 9);
    expect(after.target[1] - before.target[1]).toBeCloseTo(14, 9);
    const turned = cameras.update(state, 0, { ...STILL, turn: 0.4 });
    expect(
      Math.atan2(turned.target[2] - turned.position[2], turned.target[0] - turned.position[0]),
    ).toBeCloseTo(0.4, 9);
  });

  it("hand the view to three's camera", () => {
    const camera = new PerspectiveCamera(30, 1, 0.1, 100);
    aim(camera, { position: [1, 2, 0], target: [5, 2, 0], fov: 50 });
    expect(camera.position.toArray()).toEqual([1, 2, 0]);
    expect(camera.fov).toBe(50);
    const looks = camera.getWorldDirection(camera.position.clone());
    expect(looks.x).toBeCloseTo(1, 9);
  });
});

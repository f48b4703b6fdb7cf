/** The car on snow that keeps its prints, and tells of none but by them: as if the GPU never sent a copy. */
import { describe, expect, it } from "vitest";
import { HANDS_OFF } from "../../src/car/driver/controls";
import { Car } from "../../src/car/vehicle";
import { Prints } from "../../src/snow/prints";
import { options, plain, POWDER } from "./car_world";

async function onKeptSnow(depth: number) {
  const prints = new Prints();
  const fresh = { h: depth, W: depth };
  const base = options(plain(POWDER), depth);
  const snow = (x: number, z: number) => prints.press(fresh, x, z, 0, base.settings.compaction);
  const car = await Car.create({ ...base, snow });
  const drive = (seconds: number, throttle = 0) => {
    for (let i = 0; i < 60 * seconds; i++) {
      car.step(1 / 60, { ...HANDS_OFF, throttle });
      prints.add(car.stamps());
    }
  };
  return { car, snow, drive };
}

describe("a car in its own prints", () => {
  it("stands on them from the first step: it digs no hole where it is put, and does not sink with time", async () => {
    const { car, snow, drive } = await onKeptSnow(0.41);
    const height = car.state.position[1];
    drive(4);
    car.reset();
    drive(4);
    // The springs begin with the load of the car; float32 near 1 m in a thousand steps is within 1e-4 m.
    expect(Math.abs(car.state.position[1] - height)).toBeLessThan(1e-4);
    for (const { centre, radius } of car.state.wheels)
      expect(Math.abs(centre[1] - radius - snow(centre[0], centre[2]).h)).toBeLessThan(1e-4);
  });

  it("sinks with its rear wheels into the ruts of the front ones less than half as deep again", async () => {
    const { car, drive } = await onKeptSnow(0.41);
    drive(3, 0.8);
    const [front, , rear] = car.state.wheels.map(({ sinkage }) => sinkage) as [number, number, number];
    expect(front).toBeGreaterThan(0.15);
    expect(rear).toBeLessThan(0.5 * front);
  });
});

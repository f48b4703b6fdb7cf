import { describe, expect, it } from "vitest";
import { Car } from "../../src/car/vehicle";
import type { Place } from "../../src/world/places";
import { options, PACKED, plain } from "./car_world";

const THROTTLE = { steer: 0, throttle: 1, brake: 0, handbrake: 0, reset: false };
const DEPTH = 0.05;

/** One thing 30 m ahead of the start, on a tile of 96 m, and nothing anywhere else. */
function ahead(kind: "trees" | "rocks", size: number, z = 0) {
  const place: Place = { x: 30, y: 0, z, size, turn: 0, rank: 0.5 };
  const none = { trees: [], rocks: [] };
  return {
    tile: 96,
    on: (i: number, j: number) => (i === 0 && j === Math.floor(z / 96) ? { ...none, [kind]: [place] } : none),
  };
}

async function drive(standing: ReturnType<typeof ahead>, seconds: number): Promise<Car> {
  const car = await Car.create({ ...options(plain(PACKED), DEPTH), standing });
  for (let i = 0; i < 60 * seconds; i++) car.step(1 / 60, THROTTLE);
  return car;
}

describe("obstacles", () => {
  it.each([
    ["trees", 10],
    ["rocks", 2],
  ] as const)("%s in the way stop the car before them", async (kind, size) => {
    const car = await drive(ahead(kind, size, 0.1), 8);
    // Half its length before the thing, or thrown back or aside by it; never beyond on the straight way.
    const [x, , z] = car.state.position;
    expect(x < 30 || Math.abs(z) > 1).toBe(true);
    expect(x).toBeGreaterThan(15);
    car.dispose();
  });

  it("beside the way they do not", async () => {
    const car = await drive(ahead("trees", 10, 3), 8);
    expect(car.state.position[0]).toBeGreaterThan(60);
    car.dispose();
  });
});

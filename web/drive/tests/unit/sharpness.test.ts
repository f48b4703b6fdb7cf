import { expect, it } from "vitest";
import { Sharpness } from "../../src/page/sharpness";

function run(sharpness: Sharpness, dt: number, seconds: number): number {
  let changes = 0;
  for (let t = 0; t < seconds; t += dt) if (sharpness.take(dt)) changes++;
  return changes;
}

it("stays at the screen's own while frames come in time", () => {
  const sharpness = new Sharpness(1.5);
  expect(run(sharpness, 1 / 60, 60)).toBe(0);
  expect(sharpness.ratio).toBe(1.5);
});

it("falls step by step to a half when they do not, and comes back", () => {
  const sharpness = new Sharpness(2);
  run(sharpness, 1 / 20, 2.2);
  expect(sharpness.ratio).toBeCloseTo(1.5, 12);
  run(sharpness, 1 / 20, 60);
  expect(sharpness.ratio).toBe(0.5);
  run(sharpness, 1 / 60, 120);
  expect(sharpness.ratio).toBe(2);
});

it("takes no long pause for slowness", () => {
  const sharpness = new Sharpness(1);
  expect(run(sharpness, 5, 100)).toBe(0);
});

it("never asks for more than two", () => {
  expect(new Sharpness(4).ratio).toBe(2);
});

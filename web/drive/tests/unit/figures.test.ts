import { expect, it } from "vitest";
import { BUDGET, Smooth, lines } from "../../src/page/figures";

const COST = {
  frame: 1 / 50,
  drawCalls: 90,
  triangles: 240_000,
  textureBytes: 64e6,
  snowBytes: 5.2e6,
  storedTiles: 7,
  window: 51.2,
};

it("tells what a frame costs", () => {
  expect(lines(COST)).toEqual([
    "20.0 ms a frame, 50 frames/s",
    "90 draw calls",
    "240,000 triangles",
    "64 MB of textures",
    "5.20 MB moved by the snow",
    "window of 51 m, 7 tiles kept outside",
  ]);
});

it("marks what exceeds the budget, and only that", () => {
  const marked = lines({ ...COST, triangles: BUDGET.triangles + 1 }).filter((line) =>
    line.endsWith("over budget"),
  );
  expect(marked).toEqual(["500,001 triangles  over budget"]);
});

it("means are weighed by time and forget in half a second", () => {
  const smooth = new Smooth();
  expect(smooth.take(4, 0.1)).toBeCloseTo(4, 12); // the first value is the mean of itself
  for (let i = 0; i < 10; i++) smooth.take(8, 0.5);
  // Ten time constants: what is left of the 4 weighs e^-10 of at most 4.
  expect(Math.abs(smooth.take(8, 0.5) - 8)).toBeLessThan(4 * Math.exp(-10));
});

/**
 * Drive the marked course by a simple driver, on the car's own physics, and write what the other car follows:
 * `node tools/track.mjs` writes src/others/track.json.
 */
import { writeFileSync } from "node:fs";
import process from "node:process";
import { createServer } from "vite";

/** Speed at which it drives [m/s], time after which it gives up [s], and depth of the snow [m]. */
const PACE = 8.5;
const MOST = 240;
const DEPTH = 0.45;

const server = await createServer({
  root: process.cwd(),
  logLevel: "error",
  server: { middlewareMode: true },
});
const load = (path) => server.ssrLoadModule(path);
const { Car } = await load("/src/car/vehicle.ts");
const { Course, layCourse } = await load("/src/course/course.ts");
const { defaults } = await load("/src/settings.ts");
const { makeTerrain } = await load("/src/world/terrain.ts");
const { placesOf, TILE } = await load("/src/world/places.ts");
const { trackDriver } = await load("/src/others/driver.ts");

const SEED = 7;
const terrain = makeTerrain(SEED);
const settings = { ...defaults(), depth: DEPTH };
const fresh = (x, z) => DEPTH * terrain.cover(x, z);
const gates = layCourse(terrain, SEED);
const course = new Course(gates);
const standing = { tile: TILE, on: (i, j) => placesOf(terrain, i, j, SEED) };
const snow = (x, z) => ({ h: fresh(x, z), W: fresh(x, z) });
const { x, z, heading } = gates[0];
const start = { x: x - 14 * Math.cos(heading), z: z - 14 * Math.sin(heading), heading };
const car = await Car.create({ terrain, snow, settings, standing, start });
for (let time = 0; time < MOST && course.best === null; time += 1 / 60) {
  car.step(1 / 60, trackDriver(car.state, gates[course.next], PACE));
  course.step(1 / 60, car.state);
}
if (course.best === null) throw new Error(`the driver is lost before gate ${course.next}`);
const rows = course.best.rows.map((value) => Math.round(1e3 * value) / 1e3);
writeFileSync("src/others/track.json", `${JSON.stringify({ time: course.best.time, rows })}\n`);
process.stdout.write(`${course.best.time.toFixed(1)} s, ${rows.length / 9} samples\n`);
await server.close();

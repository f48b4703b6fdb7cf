/** What stands about the camera: all that it sees is drawn, much of the rest is not, and the budget of triangles holds. */
import { BoxGeometry, Matrix4, MeshStandardMaterial, PerspectiveCamera, Texture, Vector3 } from "three";
import { InstancedMesh, Mesh, type Object3D } from "three";
import { describe, expect, it } from "vitest";
import { layCourse } from "../../src/course/course";
import { carAt } from "../../src/course/run";
import { BUDGET } from "../../src/page/figures";
import { CarView } from "../../src/render/car/car_view";
import { MOST_LUMPS } from "../../src/render/car/lump_motion";
import { Lumps } from "../../src/render/car/lumps";
import { Scenery } from "../../src/render/ground/scenery";
import { SnowSurface } from "../../src/render/ground/snow_surface";
import { Sight, Stand } from "../../src/render/ground/stand";
import { CompanyView } from "../../src/render/others/company_view";
import { Atmosphere } from "../../src/render/sky/atmosphere";
import { Sky } from "../../src/render/sky/sky";
import { random } from "../../src/world/noise";
import { placesOf } from "../../src/world/places";
import { makeTerrain } from "../../src/world/terrain";

/** A sample of a drive: a car that stands at the start. */
const AT_REST = [0, 0, 0, 0, 0, 0, 1, 0, 0];

/** A camera at a place that looks by two angles [rad]. */
function camera(x: number, y: number, z: number, heading: number, tilt = 0, fov = 52): PerspectiveCamera {
  const made = new PerspectiveCamera(fov, 16 / 9, 0.1, 8000);
  made.position.set(x, y, z);
  const flat = Math.cos(tilt);
  made.lookAt(x + flat * Math.cos(heading), y + Math.sin(tilt), z + flat * Math.sin(heading));
  made.updateMatrixWorld();
  return made;
}

describe("what is in sight", () => {
  it("holds every ball that the camera sees a point of, until it says that the camera has left it", () => {
    let [inside, kept, out] = [0, 0, 0];
    for (let k = 0; k < 20_000; k++) {
      const r = (n: number) => random(k, n, 9) - 0.5;
      const sight = new Sight(2, 0.12);
      sight.take(camera(0, 0, 0, 6 * r(0), 2.6 * r(1), 45 + 30 * r(2)));
      const later = camera(3 * r(3), 3 * r(4), 3 * r(5), 6 * r(0) + 0.4 * r(6), 2.6 * r(1), 45 + 30 * r(2));
      if (sight.isLeftBy(later)) continue;
      kept++;
      const ball = [200 * r(7), 60 * r(8), 200 * r(9)] as const;
      const radius = 5 * (r(10) + 0.5);
      const point = new Vector3(r(11), r(12), r(13)).setLength(radius).add(new Vector3(...ball));
      const [seen, held] = [point.clone().project(later), sight.holds(...ball, radius)];
      const ahead = point.clone().sub(later.position).dot(later.getWorldDirection(new Vector3())) > 0;
      if (ahead && Math.max(Math.abs(seen.x), Math.abs(seen.y)) < 1) {
        inside++;
        expect(held).toBe(true);
      }
      if (!held) out++;
    }
    expect(kept).toBeGreaterThan(2000);
    expect(inside).toBeGreaterThan(100);
    expect(out).toBeGreaterThan(0.5 * kept); // a cone of 57 degrees about the axis is a quarter of all directions
  });

  it("comes first, and nothing is lost; shadows are thrown by all", () => {
    const stand = new Stand(new BoxGeometry(1, 1, 1), new MeshStandardMaterial(), 100);
    for (let k = 0; k < 120; k++) stand.add(new Matrix4().makeTranslation(k - 50.5, 0, 30), 0.5);
    expect(stand.count).toBe(100);
    const sight = new Sight(2, 0.12);
    sight.take(camera(0, 0, 0, 0));
    stand.sort(sight);
    const x = Array.from({ length: 100 }, (_, k) => stand.mesh.instanceMatrix.array[16 * k + 12]!);
    expect([...x].sort((a, b) => a - b)).toEqual(Array.from({ length: 100 }, (_, k) => k - 50.5));
    expect(stand.seen).toBeGreaterThan(10);
    expect(stand.seen).toBeLessThan(60);
    expect(Math.min(...x.slice(0, stand.seen))).toBeGreaterThan(Math.max(...x.slice(stand.seen)));
    const drawn = (hook: () => void) => (hook(), stand.mesh.count);
    expect(drawn(stand.mesh.onBeforeRender as () => void)).toBe(stand.seen);
    expect(drawn(stand.mesh.onBeforeShadow as () => void)).toBe(100);
  });
});

/** Triangles of all meshes of a part, drawn once. */
function triangles(part: Object3D): number {
  let sum = 0;
  part.traverse((mesh) => {
    if (!(mesh instanceof Mesh)) return;
    const { index, attributes, drawRange } = mesh.geometry;
    const corners = Math.min((index ?? attributes.position).count, drawRange.count);
    sum += (corners / 3) * (mesh instanceof InstancedMesh ? mesh.count : 1);
  });
  return sum;
}

describe("a ghost", () => {
  it("that comes too near to the camera is not seen, the other car is", () => {
    const [noise, air] = [new Texture(), new Atmosphere({ glsl: "", uniforms: {} })];
    const company = new CompanyView(air, noise, [], () => 0);
    const [, other, ghost] = company.group.children as [Object3D, Object3D, Object3D];
    const pose = carAt({ time: 1, rows: [...AT_REST, ...AT_REST] }, 0.5, 0.38, 0.26);
    const sight = { other: pose, ghost: pose, next: 0, running: true, rolling: [], wheel: null };
    const seen = (z: number) => {
      company.update(sight, new Vector3(0, 1, z));
      return [other.visible, ghost.visible];
    };
    expect(seen(3)).toEqual([true, false]);
    expect(seen(7)).toEqual([true, true]);
    company.update({ ...sight, ghost: null }, new Vector3(0, 1, 7));
    expect(ghost.visible).toBe(false);
  });
});

describe("the triangles of a picture with high detail", () => {
  const SEED = 7;
  const terrain = makeTerrain(SEED);
  const air = new Atmosphere({ glsl: "", uniforms: {} });
  const noise = new Texture();
  const gates = layCourse(terrain, SEED);
  const scenery = new Scenery(air, noise, (i, j) => placesOf(terrain, i, j, SEED));
  const [car, company] = [new CarView(air, noise), new CompanyView(air, noise, gates, () => 0)];
  const lumps = new Lumps(air).mesh;
  lumps.count = MOST_LUMPS;
  // The ghost and the other car are there, too; the cars and the gates throw their shadows in every picture.
  const shown = [car.group, company.group, lumps, new Sky(air, noise).mesh];
  const once = shown.reduce((sum, part) => sum + triangles(part), 0);
  const snow = new SnowSurface(air, noise);
  const shadows = [...car.casters, ...company.casters].reduce((sum, part) => sum + triangles(part), 0);

  it("are within the budget all over the course, also when the shadows of the woods are drawn anew", () => {
    const most = { all: 0, snow: 0, seen: 0, cast: 0 };
    for (const { x, z } of [...gates, { x: 0, z: 0 }, { x: 90, z: 150 }]) {
      scenery.follow(x, z, 1000);
      for (let k = 0; k < 12; k++) {
        // As fast as it drives: the lens is widest.
        const view = camera(x, terrain.height(x, z) + 2, z, (k * Math.PI) / 6, -0.1, 64);
        const ahead = view.getWorldDirection(new Vector3());
        snow.update(0.45, x + 5 * ahead.x, z + 5 * ahead.z);
        for (const part of [scenery, snow]) part.look(view);
        const { seen, cast } = scenery.triangles;
        const ground = triangles(snow.mesh);
        const all = once + shadows + ground + seen + cast;
        if (all > most.all) Object.assign(most, { all, snow: ground, seen, cast });
      }
    }
    console.log("triangles", { once, shadows, ...most });
    expect(most.all).toBeLessThan(BUDGET.triangles);
    expect(most.seen).toBeGreaterThan(10_000);
  });
});

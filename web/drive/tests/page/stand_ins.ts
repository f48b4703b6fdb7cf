/** Stand-ins to look at the stage alone: hills, painted ruts, a parked car. */
import { DataTexture, FloatType, LinearFilter, RepeatWrapping, RGFormat } from "three";
import type { CarPose, WheelPose } from "../../src/render/car/car_pose";
import { tiled } from "../../src/render/ground/noise_texture";
import type { Tracks } from "../../src/render/ground/snow_surface";
import type { Terrain } from "../../src/world/terrain_type";

const SIZE = 51.2;
const TEXELS = 1024;

/** How far (x, z) is from the middle of the painted way [m]: a slow S through the start. */
function aside(x: number, z: number): number {
  return z - 3 * Math.sin(x / 9);
}

/** A window of snow with two ruts and their rims, lumpy as in life. */
export function paintedTracks(fresh: number, terrain: Terrain): Tracks {
  const data = new Float32Array(2 * TEXELS * TEXELS);
  for (let j = 0; j < TEXELS; j++) {
    for (let i = 0; i < TEXELS; i++) {
      const x = ((i + 0.5) / TEXELS) * SIZE - (i >= TEXELS / 2 ? SIZE : 0);
      const z = ((j + 0.5) / TEXELS) * SIZE - (j >= TEXELS / 2 ? SIZE : 0);
      const here = fresh * terrain.cover(x, z);
      let [h, mass] = [here, here];
      const off = Math.abs(Math.abs(aside(x, z)) - 0.76);
      const lumps = 0.25 + 1.5 * tiled(3.1 * x, 3.7 * z, 1024, 2) * tiled(9.3 * x, 9.1 * z, 1024, 3) ** 0.5;
      if (x < 1.6 && off < 0.13) [h, mass] = [0.34 * here, 0.8 * here];
      else if (x < 1.6 && off < 0.45) {
        const wall = Math.max(0, 1 - (off - 0.13) / 0.06) * -0.3 * here;
        const rim = 0.13 * lumps * Math.exp(-(((off - 0.24) / 0.08) ** 2));
        h = here + wall + rim;
        mass = h * (1 + 0.1 * rim);
      }
      data.set([h, mass], 2 * (j * TEXELS + i));
    }
  }
  const texture = new DataTexture(data, TEXELS, TEXELS, RGFormat, FloatType);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = texture.minFilter = LinearFilter;
  texture.needsUpdate = true;
  return {
    texel: SIZE / TEXELS,
    uniforms: { painted: { value: texture } },
    glsl: `
      uniform sampler2D painted;
      vec2 snowAt(vec2 xz) { return textureLod(painted, fract(xz / ${SIZE}), 0.0).rg; }
      float snowInside(vec2 xz) { vec2 a = abs(xz); return 1.0 - smoothstep(23.5, 25.5, max(a.x, a.y)); }`,
  };
}

/** A car at rest at the start, its front to the east, standing in its ruts. */
export function parkedCar(terrain: Terrain, fresh: number, spin: number): CarPose {
  const [radius, width] = [0.38, 0.26];
  const ground = (x: number, z: number) => terrain.height(x, z) + 0.34 * fresh * terrain.cover(x, z);
  const heading = Math.atan2(Math.cos(0), 3);
  const wheel = (along: number, across: number, front: boolean): WheelPose => {
    const x = along * Math.cos(heading) - across * Math.sin(heading);
    const z = along * Math.sin(heading) + across * Math.cos(heading);
    return {
      centre: [x, ground(x, z) + radius, z],
      steer: front ? 0.25 : 0,
      spin,
      radius,
      width,
      slip: 3,
      sinkage: 0.2,
      grounded: true,
    };
  };
  const wheels = [
    wheel(1.3, -0.76, true),
    wheel(1.3, 0.76, true),
    wheel(-1.3, -0.76, false),
    wheel(-1.3, 0.76, false),
  ];
  const y = wheels.reduce((sum, w) => sum + w.centre[1] / 4, 0) + 0.3;
  const half = -heading / 2;
  return {
    position: [0, y, 0],
    rotation: [0, Math.sin(half), 0, Math.cos(half)],
    velocity: [8, 0, 3],
    wheels,
  };
}

const bell = (x: number, z: number, cx: number, cz: number, r: number) =>
  Math.exp(-((x - cx) ** 2 + (z - cz) ** 2) / r ** 2);

/** Hills about a gentle start, mountains far off, a road and a pond. */
export const HILLS: Terrain = {
  height(x, z) {
    const near = Math.sin(x / 31) * Math.cos(z / 27) + 0.4 * Math.sin((x + z) / 11);
    const open = 1 - bell(x, z, 0, 0, 40);
    const far = Math.hypot(x, z);
    const ridge =
      Math.abs(Math.sin(x / 410 + 1.3 * Math.sin(z / 530))) *
      Math.abs(Math.cos(z / 370 + 0.6 * Math.sin(x / 290)));
    return (
      2.2 * open * near +
      8 * Math.sin(x / 140) * Math.sin(z / 120) +
      Math.min(1, far / 1500) ** 2 * 420 * ridge
    );
  },
  slope(x, z) {
    const e = 0.25;
    return [
      (this.height(x + e, z) - this.height(x - e, z)) / (2 * e),
      (this.height(x, z + e) - this.height(x, z - e)) / (2 * e),
    ];
  },
  cover(x, z) {
    const [a, b] = this.slope(x, z);
    const [, road, ice] = this.kinds(x, z);
    return Math.max(0, Math.min(1, (1.1 - Math.hypot(a, b)) / 0.5)) * (1 - 0.55 * road - 0.9 * ice);
  },
  kinds(x, z) {
    const edge = (v: number, w: number) => Math.max(0, Math.min(1, (w - Math.abs(v)) / 1.5));
    const road = edge(z - 22 - 9 * Math.sin(x / 40), 3.6);
    const ice = edge(Math.hypot(x - 30, z + 40), 25) * (1 - road);
    return [1 - road - ice, road, ice];
  },
};

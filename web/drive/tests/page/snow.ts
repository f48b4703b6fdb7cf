/** A page with nothing but a snow field: tests make it with `start` and find it on the window as `field`. */
import { WebGLRenderer } from "three";
import { SnowField, type SnowSettings } from "../../src/snow/field";
import type { Terrain } from "../../src/world/terrain_type";

export interface Start {
  resolution?: number;
  /** Rise of the ground per metre to the east and to the south. */
  slope?: [number, number];
  /** Whether the cover varies from place to place. */
  patchy?: boolean;
  settings?: Partial<SnowSettings>;
}

const renderer = new WebGLRenderer();
renderer.setSize(64, 64);
document.body.append(renderer.domElement);

/** Settings under which nothing happens by itself. */
const STILL: SnowSettings = {
  depth: 0.5,
  compaction: 0.6,
  rimShare: 0.75,
  repose: 42,
  recovery: Infinity,
  snowfall: 0,
};

function terrainOf({ slope = [0, 0], patchy = false }: Start): Terrain {
  return {
    height: (x, z) => slope[0] * x + slope[1] * z,
    slope: () => slope,
    cover: (x, z) => (patchy ? 1 + 0.3 * Math.sin(0.7 * x) * Math.cos(0.5 * z) : 1),
    kinds: () => [1, 0, 0],
  };
}

const page = {
  field: null as SnowField | null,
  renderer,
  /** Make a new field in place of the last one. */
  start(options: Start = {}): SnowField {
    page.field?.dispose();
    const [a, b] = options.slope ?? [0, 0];
    page.field = new SnowField(renderer, {
      resolution: options.resolution ?? 256,
      terrain: terrainOf(options),
      ground: {
        glsl: `uniform vec2 rise; float groundHeight(vec2 xz) { return dot(rise, xz); }`,
        uniforms: { rise: { value: { x: a, y: b } } },
      },
      settings: { ...STILL, ...options.settings },
    });
    return page.field;
  },
  /** (h, W) of texels from a corner [m] as text: it leaves the page a hundred times sooner than numbers do. */
  async text(x: number, z: number, nx: number, nz: number): Promise<string> {
    const { buffer } = await page.field!.read(x, z, nx, nz);
    let bytes = "";
    for (let at = 0; at < buffer.byteLength; at += 8192)
      bytes += String.fromCharCode(...new Uint8Array(buffer, at, Math.min(8192, buffer.byteLength - at)));
    return btoa(bytes);
  },
};

export type SnowPage = typeof page;
declare global {
  interface Window {
    snow: SnowPage;
  }
}
window.snow = page;

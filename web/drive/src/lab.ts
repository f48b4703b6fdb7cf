import { WebGLRenderer } from "three";
import { SnowField } from "./snow/field";
import { wheelSinkage } from "./snow/law";
import type { Wheel } from "./snow/law";
import type { SnowType } from "./snow/types";
import { SNOW_TYPES } from "./snow/types";
import { LEVEL_GROUND } from "./world/ground_source";
import { LEVEL } from "./world/terrain_type";

/** One wheel that rolls straight over level snow: for experiments from the console and for docs/contrast.md. */
export interface Roll {
  readonly radius: number; // m
  readonly width: number; // m
  readonly load: number; // N
  readonly depth: number; // m, of the snow
  readonly compaction: number; // 0..1
  readonly strain: number; // of the snow's type, see SnowType
  readonly pressure: number; // Pa, of the snow's type
  readonly speed: number; // m/s
  readonly passes: number; // times that it rolls over the same place
}

export interface Rut {
  readonly sinkage: readonly number[]; // m, of each pass
  readonly across: readonly number[]; // m, from the middle of the track
  readonly height: readonly number[]; // m, of the snow there, mean along the track
  readonly updates: number;
  readonly seconds: number; // all updates together, until the GPU has done them
}

const HALF_WAY = 3; // m
const STEP = 1 / 60; // s

/** Roll a wheel, and read the rut back. */
export async function rollWheel(roll: Roll): Promise<Rut> {
  const renderer = new WebGLRenderer({ canvas: document.createElement("canvas") });
  const { depth, compaction } = roll;
  const settings = { depth, compaction, rimShare: 1, repose: 42, recovery: Infinity, snowfall: 0 };
  const field = new SnowField(renderer, {
    resolution: 256,
    texel: 0.03125,
    ground: LEVEL_GROUND,
    terrain: LEVEL,
    settings,
  });
  const sinkage: number[] = [];
  let updates = 0;
  field.follow(0, 0);
  field.update(0, []);
  const begin = performance.now();
  for (let pass = 0; pass < roll.passes; pass++) {
    const [h, W] = await middle(field);
    sinkage.push(wheelSinkage(roll, { h, W }, snowType(roll), compaction) + depth - h);
    updates += oneWay(field, roll, depth - sinkage[pass]! + roll.radius);
  }
  const rut = await profile(field);
  const seconds = (performance.now() - begin) / 1e3;
  field.dispose();
  renderer.dispose();
  return { sinkage, ...rut, updates, seconds };
}

function snowType({ strain, pressure }: Roll): SnowType {
  return { ...SNOW_TYPES.powder, strain, pressure };
}

function oneWay(field: SnowField, roll: Roll, y: number): number {
  const { radius, width, speed } = roll;
  const updates = Math.ceil((2 * HALF_WAY) / (speed * STEP));
  let from = { x: -HALF_WAY, y, z: 0 };
  for (let i = 1; i <= updates; i++) {
    const to = { x: -HALF_WAY + i * speed * STEP, y, z: 0 };
    field.update(STEP, [{ shape: "wheel", ...to, heading: 0, radius, width, slip: 0, from }]);
    from = to;
  }
  return updates;
}

async function middle(field: SnowField): Promise<[number, number]> {
  const [h, W] = await field.read(0, 0, 1, 1);
  return [h!, W!];
}

async function profile(field: SnowField): Promise<{ across: number[]; height: number[] }> {
  const along = 32;
  const most = Math.round(0.55 / field.texel);
  const z0 = -most * field.texel;
  const data = await field.read(-0.5 * along * field.texel, z0, along, 2 * most);
  const rows = Array.from({ length: 2 * most }, (_, j) => j);
  const mean = (j: number) => {
    let sum = 0;
    for (let i = 0; i < along; i++) sum += data[2 * (j * along + i)]!;
    return sum / along;
  };
  return { across: rows.map((j) => z0 + (j + 0.5) * field.texel), height: rows.map(mean) };
}

/** Sinkage of a wheel with a load [N] into fresh snow of a depth [m], as the game reckons it. */
export function sinkage(
  wheel: Wheel,
  snow: Pick<SnowType, "strain" | "pressure">,
  depth: number,
  compaction: number,
) {
  return wheelSinkage(wheel, { h: depth, W: depth }, { ...SNOW_TYPES.powder, ...snow }, compaction);
}

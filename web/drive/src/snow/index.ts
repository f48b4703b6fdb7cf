/**
 * Game snow for a three.js page of your own: everything that is public. docs/game_snow.md shows how it is used.
 *
 * ```ts
 * const field = new SnowField(renderer, { resolution: 512, texel: 0.04, ground: LEVEL_GROUND, terrain: LEVEL, settings });
 * field.follow(x, z);                              // the window goes where the player is
 * field.update(dt, footStamps({ x, y, z, heading }));
 * material.vertexShader += field.glsl;             // vec2 snowAt(vec2 xz): depth and mass [m]
 * ```
 */
export { SnowField } from "./field";
export type { SnowOptions, SnowSettings } from "./field";
export type { BoxStamp, Place, Stamp, WheelStamp } from "./stamps";
export { footStamps, type Foot } from "./foot";
export { silhouetteStamps, type Silhouette } from "./silhouette";
export { depthPng, snowExr, type Pixels16 } from "./export/textures";
export { costOf, type SnowCost } from "./cost";
export { press, type Column } from "./law";
export { SNOW_TYPES, type SnowType } from "./types";
export { LEVEL_GROUND, type GroundSource } from "../world/ground_source";
export { LEVEL, type Terrain } from "../world/terrain_type";

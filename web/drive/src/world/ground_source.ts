import type { IUniform } from "three";

/**
 * The height of the ground for shaders: code that defines `float groundHeight(vec2 xz)` [m] and the uniforms it reads.
 * On the processor the same heights come from `Terrain.height`; the two agree within a millimetre near the car.
 */
export interface GroundSource {
  readonly glsl: string;
  readonly uniforms: Record<string, IUniform>;
}

/** Level ground at height 0, for tests of the snow alone. */
export const LEVEL_GROUND: GroundSource = {
  glsl: "float groundHeight(vec2 xz) { return 0.0; }",
  uniforms: {},
};

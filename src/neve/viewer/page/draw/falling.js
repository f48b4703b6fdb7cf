// Flakes in the air, over a finished picture.

/** @import { Falling } from "../protocol.js" */
/** @import { UniformValue } from "./webgl.js" */

import { FALLING_SHADERS } from "./shading/falling_shaders.js";
import { Program } from "./webgl.js";

const FEW = 40_000; // flakes of the cube of air where the processor draws: the first of them

export class FallingSnow {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {boolean} software whether the processor draws
   */
  constructor(gl, software) {
    this.gl = gl;
    this.most = software ? FEW : Infinity;
    /** @type {Program | null} */
    this.program = null;
    this.empty = gl.createVertexArray();
  }

  /**
   * Draw the flakes of a moment before what is drawn already, as its depths say.
   * @param {Falling} law
   * @param {Record<string, UniformValue>} common eye and axes of the camera
   * @param {{ focal: number, distance: number, width: number, height: number }} camera
   * @param {number} time [s]
   */
  draw(law, common, camera, time) {
    const { gl } = this;
    this.program ??= new Program(gl, FALLING_SHADERS.vertex, FALLING_SHADERS.fragment);
    this.program.use({
      ...common,
      uSize: [camera.width, camera.height],
      uFocal: camera.focal,
      uAround: law.around * camera.distance,
      uTime: time,
      uOpen: law.open,
      uEdge: law.edge,
      uVelocity: law.velocity,
      uRadius: law.radius,
      uSway: law.sway,
      uPeriod: law.period,
      uSecond: law.second,
      uPace: law.pace,
      uSpread_: law.spread,
      uNumbers: law.numbers,
      uLeast: law.least,
      uFaintest: law.faintest,
      uNearest: law.nearest,
      uGlow: law.light,
    });
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    gl.depthMask(false);
    gl.bindVertexArray(this.empty);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, Math.min(law.count, this.most));
    gl.bindVertexArray(null);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }
}

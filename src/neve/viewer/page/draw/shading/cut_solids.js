// Solids that a plane cuts open: what is left of them, and a cap wherever the plane goes through them.

/** @import { TriangleMesh } from "../meshes.js" */
/** @import { UniformValue } from "../webgl.js" */

import { SHADERS } from "./shaders.js";
import { Program } from "../webgl.js";

/** In the stencil: the ray of a pixel meets the plane outside of the solid. */
const OUTSIDE = 128;

export class CutSolids {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.faces = new Program(gl, SHADERS.bodyVertex, SHADERS.cutFaces);
    this.body = new Program(gl, SHADERS.bodyVertex, `#define CUT\n${SHADERS.bodyFragment}`);
  }

  /**
   * Draw a solid seen from the side that is cut away. A ray that meets the plane inside of it leaves it once more
   * often than it enters: of what the plane leaves, backs less fronts are counted, pixel by pixel.
   * @param {TriangleMesh} mesh
   * @param {Record<string, UniformValue>} place uMatrix, uClip, uModel and uScale; `body` has its uniforms already
   */
  draw(mesh, place) {
    const { gl } = this;
    gl.enable(gl.STENCIL_TEST);
    gl.clearStencil(OUTSIDE);
    gl.clear(gl.STENCIL_BUFFER_BIT);
    gl.stencilFunc(gl.ALWAYS, 0, 0xff);
    gl.stencilOpSeparate(gl.BACK, gl.KEEP, gl.KEEP, gl.INCR_WRAP);
    gl.stencilOpSeparate(gl.FRONT, gl.KEEP, gl.KEEP, gl.DECR_WRAP);
    gl.disable(gl.DEPTH_TEST);
    gl.colorMask(false, false, false, false);
    this.faces.use(place);
    mesh.draw();
    gl.colorMask(true, true, true, true);
    gl.enable(gl.DEPTH_TEST);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
    gl.stencilFunc(gl.GEQUAL, OUTSIDE, 0xff);
    this.body.use({});
    mesh.draw();
    gl.stencilFunc(gl.LESS, OUTSIDE, 0xff);
    this.body.set({ uCap: 1 });
    mesh.draw();
    this.body.set({ uCap: 0 });
    gl.disable(gl.STENCIL_TEST);
  }
}

// Particles as one surface, of snow or of standing water: targets of the size of the picture, and the passes that fill them.

/** @import { UniformValue } from "./webgl.js" */

import { SURFACE_SHADERS as S } from "./shading/surface_shaders.js";
import {
  Program,
  depthTexture,
  floatTexture,
  halfFloatTexture,
  makeTarget,
  pictureTexture,
} from "./webgl.js";

/**
 * How particles become a surface: shaders; spacings over which depths are smoothed, round by round (a later one smooths
 * what the taps of the one before left), and how far depths may be apart for that; pixels of a spacing from which on
 * they are smoothed less; from which change of depth between pixels on there is an edge [spacings]; whether what is
 * behind shines through.
 * @typedef {object} Look
 * @property {string} vertex
 * @property {string} first
 * @property {string} thick
 * @property {string} shade
 * @property {number[]} reaches
 * @property {number} range
 * @property {number} most
 * @property {number} edge
 * @property {boolean} clear
 */
/** @type {Look} */
export const SNOW_LOOK = {
  ...S.snow,
  reaches: [0.8, 0.3, 0.12],
  range: 0.9,
  most: 12,
  edge: 0.4,
  clear: false,
};
/** @type {Look} waves of a spacing are particles, not water; it lies flat, so that depths change much along it */
export const WATER_LOOK = {
  ...S.water,
  reaches: [2.0, 1.0, 0.5, 0.2],
  range: 3.0,
  most: 1e9,
  edge: 1.5,
  clear: true,
};

/** @typedef {{ place: WebGLTexture, light: WebGLTexture, frame: WebGLFramebuffer }} Layer */

export class Surface {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Look} look
   */
  constructor(gl, look) {
    this.gl = gl;
    this.look = look;
    this.grains = new Program(gl, look.vertex, look.first);
    this.thick = new Program(gl, look.vertex, look.thick);
    this.smooth = new Program(gl, S.pictureVertex, S.smoothFragment);
    this.shade = new Program(gl, S.pictureVertex, look.shade);
    this.empty = gl.createVertexArray();
    this.width = this.height = 0;
    /** @type {WebGLTexture[]} */
    this.textures = [];
    /** @type {WebGLFramebuffer[]} */
    this.frames = [];
  }

  /** Whether depths can be kept in full floats; half ones would show steps. @param {WebGL2RenderingContext} gl */
  static can(gl) {
    return gl.getExtension("EXT_color_buffer_float") !== null;
  }

  /**
   * @param {number} width
   * @param {number} height
   */
  resize(width, height) {
    if (width === this.width && height === this.height) return;
    const gl = this.gl;
    for (const texture of this.textures) gl.deleteTexture(texture);
    for (const frame of this.frames) gl.deleteFramebuffer(frame);
    this.width = width;
    this.height = height;
    const deep = () => floatTexture(gl, width, height);
    const half = () => halfFloatTexture(gl, width, height, gl.LINEAR);
    /** @returns {Layer} */
    const layer = () => {
      const [place, light] = [deep(), half()];
      return { place, light, frame: makeTarget(gl, [place, light], null) };
    };
    this.raw = { place: deep(), light: half(), grain: half() };
    const depth = depthTexture(gl, width, height);
    this.first = makeTarget(gl, [this.raw.place, this.raw.light, this.raw.grain], depth);
    this.layers = [layer(), layer()];
    this.passed = half();
    this.behind = this.look.clear ? pictureTexture(gl, width, height) : null;
    this.sum = makeTarget(gl, [this.passed], null);
    this.textures = [depth, this.passed, this.raw.place, this.raw.light, this.raw.grain];
    this.textures.push(...this.layers.flatMap(({ place, light }) => [place, light]));
    if (this.behind) this.textures.push(this.behind);
    this.frames = [this.first, this.sum, ...this.layers.map(({ frame }) => frame)];
  }

  /** Take a copy of what is drawn so far, to look at it through what is clear. */
  copyPicture() {
    if (!this.behind) return;
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.behind);
    this.gl.copyTexSubImage2D(this.gl.TEXTURE_2D, 0, 0, 0, 0, 0, this.width, this.height);
  }

  /**
   * Smooth depths and light; no blending, an empty vertex array.
   * @param {{ place: WebGLTexture, light: WebGLTexture }} raw
   * @param {number} focal length of the camera [pixels]
   * @param {number} spacing of the grains [m]
   */
  smoothed(raw, focal, spacing) {
    const { gl, layers = [] } = this;
    const { reaches, range, most } = this.look;
    let from = raw;
    for (let pass = 0; pass < 2 * reaches.length; pass++) {
      const to = layers[pass % 2];
      gl.bindFramebuffer(gl.FRAMEBUFFER, to.frame);
      this.smooth.use({
        uPlace: { texture: from.place, unit: 0 },
        uSun: { texture: from.light, unit: 1 },
        uWay: pass % 2 ? [0, 1 / this.height] : [1 / this.width, 0],
        uReach_: reaches[pass >> 1],
        uSpacing: spacing,
        uFocal: focal,
        uRange: range * spacing,
        uMost: most,
      });
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      from = to;
    }
    return from;
  }

  /**
   * Draw the particles.
   * @param {Record<string, UniformValue>} uniforms of grains, light and camera
   * @param {() => void} drawGrains
   * @param {{ width: number, height: number, focal: number, lens: number[], tan: number[], covered: number }} camera
   * @param {number} spacing of the grains [m]
   */
  draw(uniforms, drawGrains, camera, spacing) {
    const { gl } = this;
    const { edge } = this.look;
    this.resize(camera.width, camera.height);
    if (!this.first || !this.raw || !this.layers || !this.sum || !this.passed) return;
    const more = { ...uniforms, uLens: camera.lens, uSpacing: spacing };
    gl.viewport(0, 0, this.width, this.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.first);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.grains.use(more);
    drawGrains();
    gl.disable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.sum);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    this.thick.use(more);
    drawGrains();
    gl.disable(gl.BLEND);
    gl.bindVertexArray(this.empty);
    const from = this.smoothed(this.raw, camera.focal, spacing);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.copyPicture();
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    this.shade.use({
      ...more,
      uEdge: edge * spacing,
      uTan: camera.tan,
      uCovered: camera.covered,
      uPixel_: [1 / this.width, 1 / this.height],
      // The units below 9 are those of the maps.
      uPlace: { texture: from.place, unit: 9 },
      uSun_: { texture: from.light, unit: 10 },
      uGrain: { texture: this.raw.grain, unit: 11 },
      uRaw: { texture: this.raw.place, unit: 12 },
      uThick: { texture: this.passed, unit: 13 },
      ...(this.behind && { uBehind: { texture: this.behind, unit: 14 } }),
    });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
    gl.disable(gl.BLEND);
  }
}

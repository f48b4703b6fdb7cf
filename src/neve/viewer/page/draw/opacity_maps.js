// How much sun and sky reaches each particle: deep opacity maps for the sun and for twelve directions around,
// made anew when the snow has moved, not when the camera has.

/** @import { Drawn } from "../protocol.js" */
/** @import { SnowCloud } from "./snow_cloud.js" */
/** @import { UniformValue } from "./webgl.js" */
/** @import { Vec3 } from "./math.js" */
/**
 * @typedef {object} OpacityMap
 * @property {number} width
 * @property {number} height
 * @property {WebGLTexture} depth where snow begins
 * @property {WebGLTexture} sums optical depth of what follows, in four layers
 * @property {WebGLFramebuffer} front draws `depth`
 * @property {WebGLFramebuffer} add draws `sums`
 */

import { V } from "./math.js";
import { SHADERS } from "./shading/shaders.js";
import { Program, depthTexture, halfFloatTexture, makeTarget } from "./webgl.js";

const SUN_SIZES = [256, 512, 1024];
const SHADOW_SIZE = 1024;
const WATER_SIZE = 512;
const DAMP = 6e-4; // depth of water at which ground is wet [m], as in the film
const MELTED = 0.4; // volume of the water of a particle over that of its snow
const SKY_TILE = 192;
const SKY_COLUMNS = 4;
const SKY_ROWS = 3;
const TABLE = 1024; // texels in a row of the table of particles

export class OpacityMaps {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.front = new Program(gl, SHADERS.mapVertex, SHADERS.mapFront);
    this.sums = new Program(gl, SHADERS.mapVertex, SHADERS.mapSums);
    this.lit = new Program(gl, SHADERS.litVertex, SHADERS.litFragment);
    this.shadow = new Program(gl, SHADERS.shadowVertex, SHADERS.shadowFront);
    this.sky = this.makeMap(SKY_TILE * SKY_COLUMNS, SKY_TILE * SKY_ROWS);
    this.suns = SUN_SIZES.map((size) => this.makeMap(size, size));
    this.sun = this.suns[0];
    this.water = new Program(gl, SHADERS.waterVertex, SHADERS.waterSums);
    this.waterDepth = halfFloatTexture(gl, WATER_SIZE, WATER_SIZE, gl.LINEAR);
    this.waterTarget = makeTarget(gl, [this.waterDepth], null);
    this.shadowDepth = depthTexture(gl, SHADOW_SIZE, SHADOW_SIZE);
    this.shadowTarget = makeTarget(gl, [], this.shadowDepth);
    this.rows = 1;
    this.table = this.makeTable(1);
    this.ball = [0, 0, 0, 1]; // centre and radius of the snow [m]
    this.layers = [0.05, 0.15, 0.4, 1.2]; // their ends [m]
    this.clip = [0, 0, 0, -1]; // plane beyond which all is cut away
    this.ready = false;
    /** @type {number[]} */
    this.direction = [];
    /** @type {number[]} */
    this.across = [];
    /** @type {number[]} */
    this.along = [];
    this.aim([0, 0, 1]);
  }

  /**
   * @param {number} width
   * @param {number} height
   * @returns {OpacityMap}
   */
  makeMap(width, height) {
    const gl = this.gl;
    const depth = depthTexture(gl, width, height);
    const sums = halfFloatTexture(gl, width, height, gl.LINEAR);
    return {
      width,
      height,
      depth,
      sums,
      front: makeTarget(gl, [], depth),
      add: makeTarget(gl, [sums], null),
    };
  }

  /**
   * Make the table of light and normal, one texel for each particle.
   * @param {number} rows
   */
  makeTable(rows) {
    const light = halfFloatTexture(this.gl, TABLE, rows, this.gl.NEAREST);
    const normal = halfFloatTexture(this.gl, TABLE, rows, this.gl.NEAREST);
    return { light, normal, target: makeTarget(this.gl, [light, normal], null) };
  }

  /**
   * Make room in the table.
   * @param {number} count of particles
   */
  reserve(count) {
    const rows = Math.max(1, Math.ceil(count / TABLE));
    if (rows <= this.rows) return;
    this.gl.deleteTexture(this.table.light);
    this.gl.deleteTexture(this.table.normal);
    this.gl.deleteFramebuffer(this.table.target);
    this.rows = rows;
    this.table = this.makeTable(rows);
  }

  /**
   * Choose the directions: one up and five around it, as in the film; their mirror images; the sun.
   * @param {Vec3} sun
   */
  aim(sun) {
    /** @type {Vec3[]} */
    const above = [[0, 0, 1]];
    for (let i = 0; i < 5; i++) {
      const a = (2 * Math.PI * i) / 5;
      above.push([0.766 * Math.cos(a), 0.766 * Math.sin(a), 0.6428]);
    }
    /** @type {Vec3[]} */
    const below = above.map((d) => [d[0], d[1], -d[2]]);
    this.direction = [];
    this.across = [];
    this.along = [];
    for (const d of [...above, ...below, V.unit(sun)]) {
      const side = V.unit(V.cross(Math.abs(d[2]) > 0.9 ? [1, 0, 0] : [0, 0, 1], d));
      this.direction.push(...d);
      this.across.push(...side);
      this.along.push(...V.cross(d, side));
    }
  }

  /** The directions and the ball that the maps cover. */
  frame() {
    const axes = { uDirection: this.direction, uAcross: this.across, uAlong: this.along };
    return { ...axes, uBall: this.ball, uClip: this.clip };
  }

  /**
   * Return what shaders need to ask the maps.
   * @param {number} quality
   * @returns {Record<string, UniformValue>}
   */
  uniforms(quality) {
    return {
      ...this.frame(),
      uLayers: this.layers,
      uSkyDepth: { texture: this.sky.depth, unit: 1 },
      uSkyDepths: { texture: this.sky.sums, unit: 2 },
      uSunDepth: { texture: this.sun.depth, unit: 3 },
      uSunDepths: { texture: this.sun.sums, unit: 4 },
      uSolidDepth: { texture: this.shadowDepth, unit: 5 },
      uWater: { texture: this.waterDepth, unit: 8 },
      uMaps: this.ready && quality > 0 ? 1 : 0,
    };
  }

  /**
   * Make the maps and the light of each particle.
   * @param {SnowCloud} snow
   * @param {Drawn} scene
   * @param {(program: Program) => void} drawSolids
   * @param {number} quality 0 no maps, 1 fast, 2 full
   * @param {boolean} wet whether the particles' values are their liquid shares
   * @param {number} skip of how many particles one is drawn, and needs light
   */
  update(snow, scene, drawSolids, quality, wet, skip) {
    const gl = this.gl;
    this.ball = snow.ball;
    this.layers = [1.5, 4, 10, 30].map((cells) => cells * scene.cell);
    this.reserve(snow.count);
    gl.disable(gl.BLEND);
    if (quality > 0) {
      this.fill(this.sky, 0, 12, SKY_TILE, snow, scene, quality > 1 ? 60000 : 12000);
      // Texels of a third of a particle's distance are fine enough for all that shows.
      const texels = (6 * snow.ball[3]) / scene.spacing;
      const last = quality > 1 ? 2 : 1;
      this.sun = this.suns[Math.min(last, SUN_SIZES.findIndex((size) => size >= texels) >>> 0)];
      this.fill(this.sun, 12, 1, this.sun.width, snow, scene, quality > 1 ? 1e9 : 60000);
      this.pour(snow, scene, wet);
      this.ready = true;
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
      gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
      gl.enable(gl.DEPTH_TEST);
      gl.depthMask(true);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      drawSolids(this.shadow.use(this.frame()));
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.table.target);
    gl.viewport(0, 0, TABLE, this.rows);
    gl.disable(gl.DEPTH_TEST);
    const places = { uLow: snow.low, uStep: snow.step };
    this.lit.use({ ...this.uniforms(quality), ...places, uTable: [TABLE, this.rows], uCell: scene.cell });
    gl.bindVertexArray(snow.array(skip));
    gl.drawArrays(gl.POINTS, 0, Math.floor(snow.count / skip));
    gl.bindVertexArray(null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /**
   * Find how deep water is, seen from above: that of a particle is spread over a disc of two spacings around it.
   * @param {SnowCloud} snow
   * @param {Drawn} scene
   * @param {boolean} wet
   */
  pour(snow, scene, wet) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.waterTarget);
    gl.viewport(0, 0, WATER_SIZE, WATER_SIZE);
    gl.disable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (!wet) return;
    const texel = (2 * snow.ball[3]) / WATER_SIZE;
    const size = Math.max(2, (5 * scene.spacing) / texel);
    const area = 0.25 * Math.PI * (size * texel) ** 2;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    const weight = (MELTED * scene.spacing ** 3) / area / DAMP;
    this.water.use({ ...this.frame(), uLow: snow.low, uStep: snow.step, uSize: size, uWeight: weight });
    gl.bindVertexArray(snow.array(1));
    gl.drawArrays(gl.POINTS, 0, snow.count);
    gl.bindVertexArray(null);
    gl.disable(gl.BLEND);
  }

  /**
   * Fill a map: first the depths, then the sums behind them.
   * @param {OpacityMap} map
   * @param {number} first direction
   * @param {number} directions
   * @param {number} tile texels along a direction's part of the map
   * @param {SnowCloud} snow
   * @param {Drawn} scene
   * @param {number} most particles that are drawn
   */
  fill(map, first, directions, tile, snow, scene, most) {
    const gl = this.gl;
    const skip = Math.min(31, Math.max(1, Math.ceil(snow.count / most)));
    const count = Math.floor(snow.count / skip);
    const texel = (2 * snow.ball[3]) / tile;
    const size = Math.max(1, Math.round((1.35 * scene.spacing * Math.cbrt(skip)) / texel));
    // Optical depth of a particle spread over its texels: 1.2 for each cell of solid snow, as in the film.
    const weight = ((1.2 / scene.cell) * scene.spacing ** 3 * skip) / (size * texel) ** 2;
    const places = { uLow: snow.low, uStep: snow.step, uSize: size, uFirst: first };
    const shared = { ...this.frame(), ...places, uLayers: this.layers, uWeight: weight };
    gl.bindVertexArray(snow.array(skip));
    gl.viewport(0, 0, map.width, map.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, map.front);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.front.use(shared);
    gl.drawArraysInstanced(gl.POINTS, 0, count, directions);
    gl.bindFramebuffer(gl.FRAMEBUFFER, map.add);
    gl.disable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    this.sums.use({ ...shared, uFront: { texture: map.depth, unit: 6 } });
    gl.drawArraysInstanced(gl.POINTS, 0, count, directions);
    gl.disable(gl.BLEND);
    gl.bindVertexArray(null);
  }
}

"use strict";
// How much sun and sky reaches each particle: deep opacity maps for the sun and for twelve directions around,
// made anew when the snow has moved, not when the camera has.

const SUN_SIZES = [256, 512, 1024], BODY_SIZE = 1024, SKY_TILE = 192, SKY_COLUMNS = 4, SKY_ROWS = 3, TABLE = 1024;

class Light {
  constructor(gl) {
    this.gl = gl;
    const plain = `layout(location = 0) in vec3 aPlace; uniform mat4 uModel; uniform vec3 uScale, uCenter; uniform float uRadius;
      ${GLSL_TILES}
      void main() {
        vec3 q = ((uModel * vec4(aPlace * uScale, 1.0)).xyz - uBall.xyz) / (2.0 * uBall.w);
        gl_Position = vec4(dot(q, uAcross[12]), dot(q, uAlong[12]), -dot(q, uDirection[12]), 1.0);
      }`;
    this.front = new Program(gl, SHADERS.mapVertex, SHADERS.mapFront);
    this.sums = new Program(gl, SHADERS.mapVertex, SHADERS.mapSums);
    this.lit = new Program(gl, SHADERS.litVertex, SHADERS.litFragment);
    this.solid = new Program(gl, plain, SHADERS.mapFront);
    const width = SKY_TILE * SKY_COLUMNS, height = SKY_TILE * SKY_ROWS;
    this.sky = this.map(width, height);
    this.suns = SUN_SIZES.map((size) => this.map(size, size));
    this.sun = this.suns[0];
    this.bodies = Textures.depth(gl, BODY_SIZE, BODY_SIZE);
    this.bodyTarget = Textures.target(gl, [], this.bodies);
    this.rows = 0;
    this.table(1);
    this.ball = [0, 0, 0, 1];
    this.layers = [0.05, 0.15, 0.4, 1.2];
    this.ready = false;
    this.aim([0, 0, 1]);
  }

  map(width, height) {
    const gl = this.gl, depth = Textures.depth(gl, width, height), sums = Textures.half(gl, width, height, gl.LINEAR);
    return { width, height, depth, sums, front: Textures.target(gl, [], depth), add: Textures.target(gl, [sums], null) };
  }

  // Make room for one texel a particle.
  table(count) {
    const gl = this.gl, rows = Math.max(1, Math.ceil(count / TABLE));
    if (rows <= this.rows) return;
    for (const texture of [this.light, this.normal]) if (texture) gl.deleteTexture(texture);
    this.rows = rows;
    this.light = Textures.half(gl, TABLE, rows, gl.NEAREST);
    this.normal = Textures.half(gl, TABLE, rows, gl.NEAREST);
    this.litTarget = Textures.target(gl, [this.light, this.normal], null);
  }

  // Choose the directions: one up and five around it, as in the film; their mirror images; the sun.
  aim(sun) {
    const around = [[0, 0, 1]];
    for (let i = 0; i < 5; i++) {
      const a = (2 * Math.PI * i) / 5;
      around.push([0.766 * Math.cos(a), 0.766 * Math.sin(a), 0.6428]);
    }
    const all = [...around, ...around.map((d) => [d[0], d[1], -d[2]]), V.unit(sun)];
    this.direction = [], this.across = [], this.along = [];
    for (const d of all) {
      const side = V.unit(V.cross(Math.abs(d[2]) > 0.9 ? [1, 0, 0] : [0, 0, 1], d));
      this.direction.push(...d), this.across.push(...side), this.along.push(...V.cross(d, side));
    }
  }

  // What shaders need to ask the maps.
  uniforms(quality) {
    return {
      uDirection: this.direction, uAcross: this.across, uAlong: this.along, uBall: this.ball, uLayers: this.layers,
      uSkyDepth: { texture: this.sky.depth, unit: 1 }, uSkyDepths: { texture: this.sky.sums, unit: 2 },
      uSunDepth: { texture: this.sun.depth, unit: 3 }, uSunDepths: { texture: this.sun.sums, unit: 4 },
      uBodyDepth: { texture: this.bodies, unit: 5 }, uMaps: this.ready && quality > 0 ? 1 : 0,
    };
  }

  // Make the maps and the light of each particle. snow: {array, count, low, step, ball, stride(k)}.
  update(snow, scene, drawBodies, quality) {
    const gl = this.gl;
    this.ball = snow.ball;
    const cell = scene.cell;
    this.layers = [1.5 * cell, 4 * cell, 10 * cell, 30 * cell];
    this.table(snow.count);
    gl.disable(gl.BLEND);
    if (quality > 0 && snow.count) {
      const share = quality > 1 ? 60000 : 12000;
      this.fill(this.sky, 0, 12, SKY_TILE, snow, scene, share);
      // Texels of a third of a particle's distance are fine enough for all that shows.
      const texels = (6 * snow.ball[3]) / scene.spacing, last = quality > 1 ? 2 : 1;
      this.sun = this.suns[Math.min(last, SUN_SIZES.findIndex((size) => size >= texels) >>> 0)];
      this.fill(this.sun, 12, 1, this.sun.width, snow, scene, quality > 1 ? 1e9 : 60000);
      this.ready = true;
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.bodyTarget);
      gl.viewport(0, 0, BODY_SIZE, BODY_SIZE);
      gl.enable(gl.DEPTH_TEST);
      gl.depthMask(true);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      const shared = { uDirection: this.direction, uAcross: this.across, uAlong: this.along, uBall: this.ball };
      drawBodies(this.solid.use(shared));
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.litTarget);
    gl.viewport(0, 0, TABLE, this.rows);
    gl.disable(gl.DEPTH_TEST);
    this.lit.use({
      ...this.uniforms(quality), uLow: snow.low, uStep: snow.step, uTable: [TABLE, this.rows], uCell: cell,
    });
    gl.bindVertexArray(snow.array(1));
    gl.drawArrays(gl.POINTS, 0, snow.count);
    gl.bindVertexArray(null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  fill(map, first, directions, tile, snow, scene, most) {
    const gl = this.gl, skip = Math.min(31, Math.max(1, Math.ceil(snow.count / most)));
    const count = Math.floor(snow.count / skip), texel = (2 * snow.ball[3]) / tile;
    const size = Math.max(1, Math.round((1.35 * scene.spacing * Math.cbrt(skip)) / texel));
    // Optical depth of a particle spread over its texels: 1.2 for each cell of solid snow, as in the film.
    const weight = ((1.2 / scene.cell) * scene.spacing ** 3 * skip) / (size * texel) ** 2;
    const shared = {
      uDirection: this.direction, uAcross: this.across, uAlong: this.along, uBall: snow.ball, uLayers: this.layers,
      uLow: snow.low, uStep: snow.step, uSize: size, uFirst: first, uWeight: weight,
    };
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

"use strict";
// The stage: sky, solids and snow in one picture. It knows nothing of where they come from.

const PALETTES = {
  ice: [[34, 60, 122], [36, 104, 160], [58, 160, 190], [160, 222, 205], [250, 250, 210]],
  fire: [[58, 34, 104], [122, 34, 104], [190, 54, 68], [246, 132, 42], [252, 236, 150]],
  swing: [[26, 62, 140], [110, 160, 214], [238, 238, 238], [232, 150, 96], [150, 34, 28]],
  names: [[128, 128, 128], [128, 128, 128]],
};

// The colour of a name, as the shader `named` has it.
function nameColor(value) {
  const turn = ((value * 0.61803399) % 1) * 6.2831853;
  return value ? [0, 2.1, 4.2].map((phase) => Math.round(255 * (0.42 + 0.34 * Math.cos(turn + phase)))) : [128, 128, 128];
}

class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { antialias: true, powerPreference: "high-performance", preserveDrawingBuffer: false });
    if (!gl) throw new Error("this browser has no WebGL 2");
    if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
      throw new Error("this browser cannot draw into textures of half floats");
    this.gl = gl;
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
    this.software = /swiftshader|llvmpipe|software|basic render/i.test(name);
    document.body.classList.toggle("software", this.software);  // blurred glass is dear without a graphics card
    this.quality = this.software ? 1 : 2;
    this.maxGrains = this.software ? 150000 : 900000;
    this.programs = {
      sky: new Program(gl, SHADERS.skyVertex, SHADERS.skyFragment),
      snow: new Program(gl, SHADERS.snowVertex, SHADERS.snowFragment),
      body: new Program(gl, SHADERS.bodyVertex, SHADERS.bodyFragment),
      plain: new Program(gl, SHADERS.plainVertex, SHADERS.plainFragment),
    };
    this.light = new Light(gl);
    this.shapes = { box: Shapes.box(gl), sphere: Shapes.sphere(gl), cylinder: Shapes.cylinder(gl), plane: Shapes.plane(gl) };
    this.empty = gl.createVertexArray();
    this.lines = gl.createBuffer();
    this.lineArray = gl.createVertexArray();
    gl.bindVertexArray(this.lineArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lines);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
    this.palettes = {};
    for (const name in PALETTES) this.palettes[name] = this.palette(PALETTES[name]);
    this.scene = null;
    this.snow = null;
    this.bodies = [];
    this.selected = "";
    this.size = 1;
  }

  palette(stops) {
    const gl = this.gl, data = new Uint8Array(256 * 4);
    for (let i = 0; i < 256; i++) {
      const t = (i / 255) * (stops.length - 1), k = Math.min(Math.floor(t), stops.length - 2);
      const color = V.mix(stops[k], stops[k + 1], t - k);
      data.set([color[0], color[1], color[2], 255], 4 * i);
    }
    return Textures.make(gl, 256, 1, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, gl.LINEAR, data);
  }

  // Take another scene: light and solids.
  stage(scene) {
    this.scene = scene;
    this.light.aim(scene.light.sun);
    this.meshes = scene.solids.map((solid) => (solid.mesh ? this.meshOf(solid) : this.shapes[solid.shape]));
    this.stale = true;
  }

  meshOf(solid) {
    const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
    const key = solid.mesh.vertices.length + solid.mesh.faces.slice(0, 64) + solid.mesh.vertices.slice(0, 256);
    this.known = this.known || new Map();
    if (!this.known.has(key))
      this.known.set(key, Shapes.mesh(this.gl, new Float32Array(bytes(solid.mesh.vertices)), new Uint32Array(bytes(solid.mesh.faces))));
    return this.known.get(key);
  }

  // Take a moment: {n, low, step, bodies, q: Uint16Array}.
  show(moment) {
    const gl = this.gl;
    if (!this.snow) this.snow = { buffer: gl.createBuffer(), arrays: new Map(), array: (k) => this.array(k) };
    const snow = this.snow;
    gl.bindBuffer(gl.ARRAY_BUFFER, snow.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, moment.q, gl.STREAM_DRAW);
    Object.assign(snow, { count: moment.n, low: moment.low, step: moment.step, q: moment.q, ball: ballOf(moment) });
    this.moment = moment;
    this.bodies = moment.bodies;
    this.stale = true;
  }

  // A vertex array that takes every k-th particle.
  array(k) {
    const gl = this.gl, arrays = this.snow.arrays;
    if (!arrays.has(k)) {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.snow.buffer);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, false, 8 * k, 0);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 1, gl.UNSIGNED_SHORT, false, 8 * k, 6);
      gl.bindVertexArray(null);
      arrays.set(k, array);
    }
    return arrays.get(k);
  }

  modelOf(i) {
    const b = this.bodies[i];
    return b ? { frame: M.frame(b.slice(3), b.slice(0, 3)), place: b.slice(0, 3), turn: b.slice(3) } : null;
  }

  eachBody(visit, withPlanes) {
    const solids = this.scene ? this.scene.solids : [];
    solids.forEach((solid, i) => {
      const model = this.modelOf(i);
      if (!model || !solid.visible || !this.meshes[i]) return;
      if (solid.shape === "plane" && !withPlanes) return;
      visit(solid, model, this.meshes[i], solid.mesh ? [1, 1, 1] : solid.half);
    });
  }

  draw(camera) {
    const gl = this.gl, canvas = this.canvas;
    if (gl.isContextLost() || !this.scene || !this.snow) return;
    const lamp = this.scene.light;
    const common = {
      uSun: lamp.sun, uSunColor: lamp.sun_color, uSkyColor: lamp.sky_color, uEye: camera.eye, uReach: camera.reach,
      uRight: camera.right, uUp: camera.up, uForward: camera.forward, uMatrix: camera.matrix,
    };
    if (this.stale) {
      this.light.update(this.snow, this.scene, (program) =>
        this.eachBody((solid, model, mesh, scale) => {
          program.set({ uModel: model.frame, uScale: scale });
          mesh.draw();
        }, false), this.quality);
      this.stale = false;
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawSnow(camera, common);
    this.drawBodies(camera, common);
    this.programs.sky.use({ ...common, uTan: camera.tan, uCovered: camera.covered });
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
  }

  drawSnow(camera, common) {
    const gl = this.gl, snow = this.snow, scene = this.scene, moment = this.moment;
    if (!snow.count) return;
    const mode = moment.mode === "snow" ? 0 : moment.classes ? 2 : 1;
    const pixels = (scene.spacing * camera.focal) / camera.reach;
    const wanted = Math.min(16, Math.max(1, (pixels / 1.35) ** 3)), can = this.maxGrains / snow.count;
    const grains = Math.max(1, Math.floor(Math.min(wanted, can)));
    const entry = scene.modes ? scene.modes.find((m) => m.name === moment.mode) : null;
    this.programs.snow.use({
      ...common, uLow: snow.low, uStep: snow.step, uSpacing: scene.spacing, uFocal: camera.focal, uGrains: grains,
      uSpread: grains > 1 ? 0.66 : 0.0, uSize: this.size * (grains > 1 ? 1 : 1.1), uColored: mode,
      uLight: { texture: this.light.light, unit: 7 }, uNormal: { texture: this.light.normal, unit: 6 },
      uPalette: { texture: this.palettes[entry ? entry.palette : "ice"], unit: 0 },
    });
    gl.bindVertexArray(snow.array(1));
    gl.drawArraysInstanced(gl.POINTS, 0, snow.count, grains);
    gl.bindVertexArray(null);
  }

  drawBodies(camera, common) {
    const program = this.programs.body;
    program.use({ ...common, ...this.light.uniforms(this.quality), uPixel: 1 / camera.focal, uDetail: this.software ? 3 : 6 });
    this.eachBody((solid, model, mesh, half) => {
      let scale = half, frame = model.frame;
      if (solid.shape === "plane") {
        const up = R.column(model.turn, 2), height = V.dot(up, V.sub(camera.eye, model.place));
        if (height <= 0) return;
        scale = [300 * camera.reach, 300 * camera.reach, 1];
      }
      const chosen = solid.name === this.selected;
      program.set({
        uModel: frame, uScale: scale, uColor: solid.color, uGround: solid.ground ? (solid.shape === "terrain" ? 2 : 1) : 0,
        uBound: V.length(half) || 1, uGlow: chosen ? [0.10, 0.16, 0.22] : [0, 0, 0],
      });
      mesh.draw();
    }, true);
  }

  // Where the processor draws, wait for the picture and return how long that took [ms]: a page that asks for the
  // next one at once would have no time left for buttons.
  finish() {
    if (!this.software) return 0;
    const began = performance.now();
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - began;
  }

  // Draw lines over the picture: [{color, points: [[x, y, z], ...]}], each a strip.
  drawLines(camera, strips) {
    const gl = this.gl;
    gl.disable(gl.DEPTH_TEST);
    for (const { color, points } of strips) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.lines);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points.flat()), gl.STREAM_DRAW);
      this.programs.plain.use({ uMatrix: camera.matrix, uColor: color });
      gl.bindVertexArray(this.lineArray);
      gl.drawArrays(gl.TRIANGLES, 0, points.length);
    }
    gl.bindVertexArray(null);
    gl.enable(gl.DEPTH_TEST);
  }
}

// The ball that holds all but a few lost particles: shadows are drawn inside it.
function ballOf({ n, q, low, step }) {
  if (!n) return [...low, 1];
  const some = Math.max(1, Math.floor(n / 3000)), ends = [];
  for (let axis = 0; axis < 3; axis++) {
    const values = [];
    for (let i = 0; i < n; i += some) values.push(q[4 * i + axis]);
    values.sort((a, b) => a - b);
    const cut = Math.floor(values.length * 0.003);
    ends.push([low[axis] + step[axis] * values[cut], low[axis] + step[axis] * values[values.length - 1 - cut]]);
  }
  const middle = ends.map(([a, b]) => 0.5 * (a + b)), half = ends.map(([a, b]) => 0.5 * (b - a));
  return [...middle, Math.max(1.1 * V.length(half), 1e-3)];
}

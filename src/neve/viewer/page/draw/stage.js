// The stage: sky, solids and snow in one picture. It knows nothing of where they come from.

/** @import { Drawn, Solid } from "../protocol.js" */
/** @import { OrbitCamera } from "./camera.js" */
/** @import { Rotation, Vec3 } from "./math.js" */
/** @import { TriangleMesh } from "./meshes.js" */
/** @import { State } from "./snow_cloud.js" */
/** @import { UniformValue } from "./webgl.js" */
/** @typedef {{ place: Vec3, turn: Rotation }} Pose */
/** @typedef {{ color: Vec3, points: Vec3[], alpha?: number }} Triangles */
/** @typedef {{ normal: Vec3, at: number }} Clip what lies farther than `at` [m] along `normal` is cut away */
/** @typedef {(solid: Solid, pose: Pose, mesh: TriangleMesh, scale: Vec3) => void} Visit */

import { colorTable } from "./colors.js";
import { M, R, V } from "./math.js";
import { bytesOf, creasedMesh, shapeMeshes } from "./meshes.js";
import { OpacityMaps } from "./opacity_maps.js";
import { CutSolids } from "./shading/cut_solids.js";
import { SHADERS } from "./shading/shaders.js";
import { FallingSnow } from "./falling.js";
import { Detail } from "./detail.js";
import { partPool } from "./pool.js";
import { SnowCloud } from "./snow_cloud.js";
import { SNOW_LOOK, Surface, WATER_LOOK } from "./surface.js";
import { Program, colorTexture, isSoftware, openWebGL } from "./webgl.js";

/** @type {Vec3[]} */
const GREY = [
  [128, 128, 128],
  [128, 128, 128],
];

export class Stage {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    const gl = openWebGL(canvas);
    this.canvas = canvas;
    this.gl = gl;
    this.software = isSoftware(gl);
    document.body.classList.toggle("software", this.software); // blurred glass is dear without a graphics card
    this.quality = this.software ? 1 : 2;
    this.maxGrains = this.software ? 150000 : 900000;
    this.programs = {
      sky: new Program(gl, SHADERS.skyVertex, SHADERS.skyFragment),
      snow: new Program(gl, SHADERS.snowVertex, SHADERS.snowFragment),
      body: new Program(gl, SHADERS.bodyVertex, SHADERS.bodyFragment),
      plain: new Program(gl, SHADERS.plainVertex, SHADERS.plainFragment),
    };
    this.maps = new OpacityMaps(gl);
    this.snow = new SnowCloud(gl);
    this.pool = new SnowCloud(gl); // water that stands together
    this.falling = new FallingSnow(gl, this.software);
    this.flakes = true; // whether those in the air are drawn
    this.shapes = shapeMeshes(gl);
    /** @type {Map<string, TriangleMesh>} */
    this.known = new Map();
    /** @type {(TriangleMesh | undefined)[]} */
    this.meshes = [];
    this.empty = gl.createVertexArray();
    this.overlayBuffer = gl.createBuffer();
    this.overlayArray = gl.createVertexArray();
    gl.bindVertexArray(this.overlayArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.overlayBuffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
    this.grey = colorTexture(gl, colorTable(GREY, 256));
    /** @type {Map<string, WebGLTexture>} */
    this.palettes = new Map();
    /** @type {Drawn | null} */
    this.scene = null;
    /** @type {State | null} */
    this.state = null;
    this.selected = "";
    this.size = 1;
    this.resolution = 0; // pixels of the picture per pixel of the page, along an edge; 0: as is usual here
    /** @type {Clip | null} */
    this.clip = null;
    /** @type {CutSolids | null} */
    this.cut = null;
    this.stale = true; // the maps are older than the snow
    this.detail = new Detail(this.software);
    this.skip = 1; // of so many particles one is drawn
    /** @type {Surface | null} draws snow as a surface, if it is to look so */
    this.surface = null;
    /** @type {Surface | null} draws the pool, once there is one */
    this.water = null;
  }

  /**
   * Draw snow as a surface, or as grains.
   * @param {boolean} on
   */
  setSurface(on) {
    if (on && !Surface.can(this.gl)) throw new Error("this browser cannot draw into textures of floats");
    this.surface = on ? (this.surface ?? new Surface(this.gl, SNOW_LOOK)) : null;
  }

  /**
   * Take another scene: light, solids and colours.
   * @param {Drawn} scene
   */
  setScene(scene) {
    this.scene = scene;
    this.maps.aim(scene.light.sun);
    this.meshes = scene.solids.map((solid) =>
      solid.mesh ? this.meshOf(solid.mesh) : this.shapes[solid.shape],
    );
    for (const mode of scene.modes) if (!this.palettes.has(mode.name)) this.setPalette(mode.name, mode.stops);
    this.stale = true;
  }

  /**
   * Choose the colours of a mode.
   * @param {string} mode
   * @param {Vec3[]} stops from the least to the greatest value
   */
  setPalette(mode, stops) {
    const old = this.palettes.get(mode);
    if (old) this.gl.deleteTexture(old);
    this.palettes.set(mode, colorTexture(this.gl, colorTable(stops, 256)));
  }

  /** @param {{ vertices: string, faces: string }} mesh */
  meshOf({ vertices, faces }) {
    const key = `${vertices.length} ${faces.slice(0, 64)} ${vertices.slice(0, 256)}`;
    let known = this.known.get(key);
    if (!known) {
      known = creasedMesh(this.gl, new Float32Array(bytesOf(vertices)), new Uint32Array(bytesOf(faces)));
      this.known.set(key, known);
    }
    return known;
  }

  /** @param {State} state */
  show(state) {
    const spacing = this.scene && state.mode === "snow" && Surface.can(this.gl) ? this.scene.spacing : 0;
    const { rest, pool } = spacing
      ? partPool(state, spacing)
      : { rest: state.q, pool: state.q.subarray(0, 0) };
    this.snow.load(state, rest);
    this.pool.load(state, pool);
    this.state = state;
    this.stale = true;
  }

  /**
   * Fit the canvas to its place in the page.
   * @returns whether its size has changed
   */
  resize() {
    const usual = this.software ? 0.7 : Math.min(window.devicePixelRatio || 1, 2);
    const scale = this.resolution || usual;
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    if (this.canvas.width === width && this.canvas.height === height) return false;
    this.canvas.width = width;
    this.canvas.height = height;
    return true;
  }

  /** @param {number} quality */
  setQuality(quality) {
    this.quality = quality;
    this.maps.ready = this.maps.ready && quality > 0;
    this.stale = true;
  }

  /**
   * Return where a solid is; null if the state does not have it.
   * @param {number} i
   * @returns {Pose | null}
   */
  poseOf(i) {
    const row = this.state?.poses[i];
    if (!row) return null;
    return { place: /** @type {Vec3} */ (row.slice(0, 3)), turn: /** @type {Rotation} */ (row.slice(3)) };
  }

  /**
   * @param {Visit} visit
   * @param {boolean} withPlanes
   */
  eachSolid(visit, withPlanes) {
    (this.scene?.solids ?? []).forEach((solid, i) => {
      const pose = this.poseOf(i);
      const mesh = this.meshes[i];
      if (!pose || !mesh || !solid.visible || (solid.shape === "plane" && !withPlanes)) return;
      visit(solid, pose, mesh, solid.mesh ? [1, 1, 1] : solid.half);
    });
  }

  /** @param {OrbitCamera} camera */
  draw(camera) {
    const gl = this.gl;
    const scene = this.scene;
    const state = this.state;
    if (gl.isContextLost() || !scene || !state) return;
    const pixels = (scene.spacing * camera.focal) / camera.distance;
    const skip = this.detail.skip(this.snow.count, pixels, performance.now());
    if (this.stale || skip !== this.skip) {
      this.skip = skip;
      this.maps.clip = this.plane();
      this.maps.update(
        this.snow,
        scene,
        (program) => this.drawShadows(program),
        this.quality,
        state.mode === "snow",
        skip,
      );
      this.stale = false;
    }
    const { sun, sun_color: uSunColor, sky_color: uSkyColor } = scene.light;
    const axes = { uRight: camera.right, uUp: camera.up, uForward: camera.forward, uMatrix: camera.matrix };
    const common = { uSun: sun, uSunColor, uSkyColor, uEye: camera.eye, uReach: camera.distance, ...axes };
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!this.surface) this.drawSnow(camera, common, scene, state);
    this.drawSolids(camera, common);
    this.programs.sky.use({ ...common, uTan: camera.tan, uCovered: camera.covered });
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
    if (this.surface) this.drawSnow(camera, common, scene, state); // its thin edges show what is behind
    this.drawPool(camera, common, scene);
    if (this.flakes && scene.falling) this.falling.draw(scene.falling, common, camera, state.time);
  }

  /**
   * Draw water that stands together over what is seen through it.
   * @param {OrbitCamera} camera
   * @param {Record<string, UniformValue>} common
   * @param {Drawn} scene
   */
  drawPool(camera, common, scene) {
    const { gl, pool } = this;
    if (!pool.count) return;
    this.water ??= new Surface(gl, WATER_LOOK);
    const places = { uLow: pool.low, uStep: pool.step, uFocal: camera.focal };
    const lit = { ...common, ...places, ...this.maps.uniforms(this.quality), uClip: this.plane() };
    const drawBalls = () => {
      gl.bindVertexArray(pool.array(1));
      gl.drawArrays(gl.POINTS, 0, pool.count);
      gl.bindVertexArray(null);
    };
    this.water.draw(lit, drawBalls, camera, scene.spacing);
  }

  /** Normal of the plane that cuts, and minus its distance from the origin; of none, one that cuts nothing. */
  plane() {
    return this.clip ? [...this.clip.normal, -this.clip.at] : [0, 0, 0, -1];
  }

  /**
   * Cut away what lies beyond a plane.
   * @param {Clip | null} clip
   */
  setClip(clip) {
    this.clip = clip;
    if (clip) this.cut ??= new CutSolids(this.gl);
    this.stale = true;
  }

  /** @param {Program} program */
  drawShadows(program) {
    this.eachSolid((_solid, pose, mesh, scale) => {
      program.set({ uModel: M.frame(pose.turn, pose.place), uScale: scale });
      mesh.draw();
    }, false);
  }

  /**
   * @param {OrbitCamera} camera
   * @param {Record<string, UniformValue>} common
   * @param {Drawn} scene
   * @param {State} state
   */
  drawSnow(camera, common, scene, state) {
    const gl = this.gl;
    const snow = this.snow;
    if (!snow.count) return;
    const spacing = scene.spacing * Math.cbrt(this.skip);
    const pixels = (spacing * camera.focal) / camera.distance;
    const count = Math.floor(snow.count / this.skip);
    const wanted = Math.min(this.surface ? 5 : 16, Math.max(1, (pixels / 1.35) ** 3));
    const grains = Math.max(1, Math.floor(Math.min(wanted, this.maxGrains / count)));
    const uniforms = {
      ...common,
      uLow: snow.low,
      uStep: snow.step,
      uSpacing: spacing,
      uSkip: this.skip,
      uFocal: camera.focal,
      uGrains: grains,
      uSpread: grains > 1 ? 0.66 : 0.0,
      uSize: this.size * (grains > 1 ? 1 : 1.1),
      uFloor: this.floor(scene),
      uClip: this.plane(),
      uColored: state.mode === "snow" ? 0 : state.classes ? 2 : 1,
      uLight: { texture: this.maps.table.light, unit: 7 },
      uNormal: { texture: this.maps.table.normal, unit: 6 },
      uPalette: { texture: this.palettes.get(state.mode) ?? this.grey, unit: 0 },
    };
    const drawGrains = () => {
      gl.bindVertexArray(snow.array(this.skip));
      gl.drawArraysInstanced(gl.POINTS, 0, count, grains);
      gl.bindVertexArray(null);
    };
    if (this.surface) this.surface.draw(uniforms, drawGrains, camera, spacing);
    else {
      this.programs.snow.use(uniforms);
      drawGrains();
    }
  }

  /**
   * Return the normal of the ground and how far it lies below the origin [m]; without any, far below.
   * @param {Drawn} scene
   */
  floor(scene) {
    const i = scene.solids.findIndex((solid) => solid.ground && solid.shape === "plane");
    const pose = i < 0 ? null : this.poseOf(i);
    if (!pose) return [0, 0, 0, 1e9];
    const normal = R.column(pose.turn, 2);
    return [...normal, -V.dot(normal, pose.place)];
  }

  /**
   * @param {OrbitCamera} camera
   * @param {Record<string, UniformValue>} common
   */
  drawSolids(camera, common) {
    const { clip } = this;
    const cut = clip && this.cut;
    const program = cut?.body ?? this.programs.body;
    const plane = { uMatrix: camera.matrix, uClip: this.plane() };
    const opened = clip !== null && V.dot(clip.normal, camera.eye) > clip.at; // caps face the camera
    const detail = { uPixel: 1 / camera.focal, uDetail: this.software ? 3 : 6 };
    program.use({ ...common, ...this.maps.uniforms(this.quality), ...detail, ...plane, uCap: 0 });
    const wide = 300 * camera.distance;
    this.eachSolid((solid, pose, mesh, half) => {
      const isPlane = solid.shape === "plane";
      if (isPlane && V.dot(R.column(pose.turn, 2), V.sub(camera.eye, pose.place)) <= 0) return; // seen from below
      const place = {
        uModel: M.frame(pose.turn, pose.place),
        uScale: isPlane ? [wide, wide, 1] : half,
      };
      program.set({
        ...place,
        uColor: solid.color,
        uGround: solid.ground ? (solid.shape === "terrain" ? 2 : 1) : 0,
        uBound: V.length(half) || 1,
        uGlow: solid.name === this.selected ? [0.1, 0.16, 0.22] : [0, 0, 0],
      });
      if (cut && opened && !isPlane && !solid.ground) cut.draw(mesh, { ...plane, ...place });
      else mesh.draw();
    }, true);
  }

  /**
   * Where the processor draws, wait for the picture and return how long that took [ms]: a page that asks for the
   * next one at once would have no time left for buttons.
   */
  finish() {
    if (!this.software) return 0;
    const began = performance.now();
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - began;
  }

  /**
   * Draw triangles of plain colours over the picture.
   * @param {OrbitCamera} camera
   * @param {Triangles[]} overlay
   */
  drawOverlay(camera, overlay) {
    const gl = this.gl;
    if (!overlay.length) return;
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    for (const { color, points, alpha = 1 } of overlay) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.overlayBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points.flat()), gl.STREAM_DRAW);
      this.programs.plain.use({ uMatrix: camera.matrix, uColor: [...color, alpha] });
      gl.bindVertexArray(this.overlayArray);
      gl.drawArrays(gl.TRIANGLES, 0, points.length);
    }
    gl.bindVertexArray(null);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }
}

// The stage: sky, solids and snow in one picture. It knows nothing of where they come from.

/** @import { Drawn, Solid } from "../protocol.js" */
/** @import { OrbitCamera } from "./camera.js" */
/** @import { Rotation, Vec3 } from "./math.js" */
/** @import { TriangleMesh } from "./meshes.js" */
/** @import { State } from "./snow_cloud.js" */
/** @import { UniformValue } from "./webgl.js" */
/** @typedef {{ place: Vec3, turn: Rotation }} Pose */
/** @typedef {{ color: Vec3, points: Vec3[] }} Triangles */
/** @typedef {(solid: Solid, pose: Pose, mesh: TriangleMesh, scale: Vec3) => void} Visit */

import { colorTable } from "./colors.js";
import { M, R, V } from "./math.js";
import { bytesOf, creasedMesh, shapeMeshes } from "./meshes.js";
import { OpacityMaps } from "./opacity_maps.js";
import { SHADERS } from "./shaders.js";
import { SnowCloud } from "./snow_cloud.js";
import { Program, colorTexture } from "./webgl.js";

/** @type {Vec3[]} */
const GREY = [
  [128, 128, 128],
  [128, 128, 128],
];

/**
 * Open WebGL 2 with what the page needs of it.
 * @param {HTMLCanvasElement} canvas
 */
function openWebGL(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true, powerPreference: "high-performance" });
  if (!gl) throw new Error("this browser has no WebGL 2");
  if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
    throw new Error("this browser cannot draw into textures of half floats");
  return gl;
}

/**
 * Whether the processor draws, not a graphics card.
 * @param {WebGL2RenderingContext} gl
 */
function isSoftware(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

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
    this.stale = true; // the maps are older than the snow
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
    for (const mode of scene.modes)
      if (!this.palettes.has(mode.name))
        this.palettes.set(mode.name, colorTexture(this.gl, colorTable(mode.stops, 256)));
    this.stale = true;
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
    this.snow.load(state);
    this.state = state;
    this.stale = true;
  }

  /**
   * Fit the canvas to its place in the page.
   * @returns whether its size has changed
   */
  resize() {
    const scale = this.software ? 0.7 : Math.min(window.devicePixelRatio || 1, 2);
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
    if (this.stale) {
      this.maps.update(
        this.snow,
        scene,
        (program) => this.drawShadows(program),
        this.quality,
        state.mode === "snow",
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
    this.drawSnow(camera, common, scene, state);
    this.drawSolids(camera, common);
    this.programs.sky.use({ ...common, uTan: camera.tan, uCovered: camera.covered });
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
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
    const pixels = (scene.spacing * camera.focal) / camera.distance;
    const wanted = Math.min(16, Math.max(1, (pixels / 1.35) ** 3));
    const grains = Math.max(1, Math.floor(Math.min(wanted, this.maxGrains / snow.count)));
    this.programs.snow.use({
      ...common,
      uLow: snow.low,
      uStep: snow.step,
      uSpacing: scene.spacing,
      uFocal: camera.focal,
      uGrains: grains,
      uSpread: grains > 1 ? 0.66 : 0.0,
      uSize: this.size * (grains > 1 ? 1 : 1.1),
      uFloor: this.floor(scene),
      uColored: state.mode === "snow" ? 0 : state.classes ? 2 : 1,
      uLight: { texture: this.maps.table.light, unit: 7 },
      uNormal: { texture: this.maps.table.normal, unit: 6 },
      uPalette: { texture: this.palettes.get(state.mode) ?? this.grey, unit: 0 },
    });
    gl.bindVertexArray(snow.array(1));
    gl.drawArraysInstanced(gl.POINTS, 0, snow.count, grains);
    gl.bindVertexArray(null);
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
    const program = this.programs.body;
    const detail = { uPixel: 1 / camera.focal, uDetail: this.software ? 3 : 6 };
    program.use({ ...common, ...this.maps.uniforms(this.quality), ...detail });
    const wide = 300 * camera.distance;
    this.eachSolid((solid, pose, mesh, half) => {
      const isPlane = solid.shape === "plane";
      if (isPlane && V.dot(R.column(pose.turn, 2), V.sub(camera.eye, pose.place)) <= 0) return; // seen from below
      program.set({
        uModel: M.frame(pose.turn, pose.place),
        uScale: isPlane ? [wide, wide, 1] : half,
        uColor: solid.color,
        uGround: solid.ground ? (solid.shape === "terrain" ? 2 : 1) : 0,
        uBound: V.length(half) || 1,
        uGlow: solid.name === this.selected ? [0.1, 0.16, 0.22] : [0, 0, 0],
      });
      mesh.draw();
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
    gl.disable(gl.DEPTH_TEST);
    for (const { color, points } of overlay) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.overlayBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points.flat()), gl.STREAM_DRAW);
      this.programs.plain.use({ uMatrix: camera.matrix, uColor: color });
      gl.bindVertexArray(this.overlayArray);
      gl.drawArrays(gl.TRIANGLES, 0, points.length);
    }
    gl.bindVertexArray(null);
    gl.enable(gl.DEPTH_TEST);
  }
}

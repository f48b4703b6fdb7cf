// The few parts of WebGL 2 that the page needs: programs, and textures to draw into.

import { GLSL_HEAD } from "./shading/glsl.js";

/** @typedef {{ texture: WebGLTexture, unit: number }} Sampler a texture, and the unit that it is bound to */
/** @typedef {number | number[] | Float32Array | Sampler} UniformValue */

/**
 * Open WebGL 2 with what the page needs of it.
 * @param {HTMLCanvasElement} canvas
 */
export function openWebGL(canvas) {
  // Smooth edges cost the processor most of a picture.
  const gl = canvas.getContext("webgl2", {
    antialias: !drawsInSoftware(),
    stencil: true, // for solids that are cut
    powerPreference: "high-performance",
  });
  if (!gl) throw new Error("this browser has no WebGL 2");
  if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
    throw new Error("this browser cannot draw into textures of half floats");
  return gl;
}

/**
 * Whether the processor draws, not a graphics card.
 * @param {WebGL2RenderingContext} gl
 */
export function isSoftware(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** Ask a context that is thrown away: a canvas keeps how it was opened first. */
function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const software = gl !== null && isSoftware(gl);
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return software;
}

export class Program {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {string} vertex
   * @param {string} fragment
   */
  constructor(gl, vertex, fragment) {
    this.gl = gl;
    this.program = gl.createProgram();
    this.attach(gl.VERTEX_SHADER, vertex);
    this.attach(gl.FRAGMENT_SHADER, fragment);
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = (gl.getAttachedShaders(this.program) ?? []).map((s) => gl.getShaderInfoLog(s));
      throw new Error(`shader: ${gl.getProgramInfoLog(this.program)} ${logs.join(" ")}`);
    }
    /** @type {Map<string, { place: WebGLUniformLocation | null, type: number }>} */
    this.uniforms = new Map();
    const count = gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS) ?? 0;
    for (let i = 0; i < count; i++) {
      const info = gl.getActiveUniform(this.program, i);
      if (!info) continue;
      const place = gl.getUniformLocation(this.program, info.name);
      this.uniforms.set(info.name.replace(/\[0\]$/, ""), { place, type: info.type });
    }
  }

  /**
   * @param {number} kind
   * @param {string} text
   */
  attach(kind, text) {
    const shader = this.gl.createShader(kind);
    if (!shader) return; // the context is lost
    this.gl.shaderSource(shader, GLSL_HEAD + text);
    this.gl.compileShader(shader);
    this.gl.attachShader(this.program, shader);
  }

  /**
   * Draw with this program from now on, with these uniforms.
   * @param {Record<string, UniformValue>} values
   */
  use(values) {
    this.gl.useProgram(this.program);
    this.set(values);
    return this;
  }

  /**
   * Set uniforms by name; a name that the shader does not use is skipped.
   * @param {Record<string, UniformValue>} values
   */
  set(values) {
    for (const [name, value] of Object.entries(values)) {
      const uniform = this.uniforms.get(name);
      if (!uniform) continue;
      if (typeof value === "number") this.setNumber(uniform.place, uniform.type, value);
      else if ("texture" in value) this.setTexture(uniform.place, value);
      else this.setNumbers(uniform.place, uniform.type, value);
    }
  }

  /**
   * @param {WebGLUniformLocation | null} place
   * @param {number} type
   * @param {number} value
   */
  setNumber(place, type, value) {
    if (type === this.gl.INT) this.gl.uniform1i(place, value);
    else this.gl.uniform1f(place, value);
  }

  /**
   * @param {WebGLUniformLocation | null} place
   * @param {number} type
   * @param {number[] | Float32Array} value
   */
  setNumbers(place, type, value) {
    const gl = this.gl;
    if (type === gl.FLOAT_VEC2) gl.uniform2fv(place, value);
    else if (type === gl.FLOAT_VEC3) gl.uniform3fv(place, value);
    else if (type === gl.FLOAT_VEC4) gl.uniform4fv(place, value);
    else if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(place, false, value);
  }

  /**
   * @param {WebGLUniformLocation | null} place
   * @param {Sampler} sampler
   */
  setTexture(place, { texture, unit }) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(place, unit);
  }
}

/**
 * Make a texture whose filter is the same near and far.
 * @param {WebGL2RenderingContext} gl
 * @param {number} width
 * @param {number} height
 * @param {{ inner: number, format: number, type: number, filter: number, data?: Uint8Array }} how
 */
function makeTexture(gl, width, height, { inner, format, type, filter, data }) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, format, type, data ?? null);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return texture;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {number} width
 * @param {number} height
 */
export function depthTexture(gl, width, height) {
  const how = { inner: gl.DEPTH_COMPONENT24, format: gl.DEPTH_COMPONENT, type: gl.UNSIGNED_INT };
  return makeTexture(gl, width, height, { ...how, filter: gl.NEAREST });
}

/**
 * Make a texture of four half floats.
 * @param {WebGL2RenderingContext} gl
 * @param {number} width
 * @param {number} height
 * @param {number} filter
 */
export function halfFloatTexture(gl, width, height, filter) {
  return makeTexture(gl, width, height, { inner: gl.RGBA16F, format: gl.RGBA, type: gl.HALF_FLOAT, filter });
}

/**
 * Make a texture of four floats, for numbers that are read as they are.
 * @param {WebGL2RenderingContext} gl
 * @param {number} width
 * @param {number} height
 */
export function floatTexture(gl, width, height) {
  const how = { inner: gl.RGBA32F, format: gl.RGBA, type: gl.FLOAT, filter: gl.NEAREST };
  return makeTexture(gl, width, height, how);
}

/**
 * Make a texture that takes a copy of the picture.
 * @param {WebGL2RenderingContext} gl
 * @param {number} width
 * @param {number} height
 */
export function pictureTexture(gl, width, height) {
  const how = { inner: gl.RGBA8, format: gl.RGBA, type: gl.UNSIGNED_BYTE, filter: gl.LINEAR };
  return makeTexture(gl, width, height, how);
}

/**
 * Make a texture of one row of colours, four bytes each.
 * @param {WebGL2RenderingContext} gl
 * @param {Uint8Array} data
 */
export function colorTexture(gl, data) {
  const how = { inner: gl.RGBA8, format: gl.RGBA, type: gl.UNSIGNED_BYTE, filter: gl.LINEAR };
  return makeTexture(gl, data.length / 4, 1, { ...how, data });
}

/**
 * Make a framebuffer that draws into textures.
 * @param {WebGL2RenderingContext} gl
 * @param {WebGLTexture[]} colors
 * @param {WebGLTexture | null} depth
 */
export function makeTarget(gl, colors, depth) {
  const frame = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  colors.forEach((texture, i) =>
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0),
  );
  if (depth) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth, 0);
  gl.drawBuffers(colors.length ? colors.map((_, i) => gl.COLOR_ATTACHMENT0 + i) : [gl.NONE]);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return frame;
}

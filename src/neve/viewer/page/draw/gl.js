"use strict";
// The few parts of WebGL 2 that the page needs: programs, textures to draw into, and meshes of simple bodies.

class Program {
  constructor(gl, vertex, fragment) {
    this.gl = gl;
    this.program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, GLSL_HEAD + text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = gl.getAttachedShaders(this.program).map((s) => gl.getShaderInfoLog(s));
      throw new Error(`shader: ${gl.getProgramInfoLog(this.program)} ${logs.join(" ")}`);
    }
    this.uniforms = {};
    const count = gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const { name, type } = gl.getActiveUniform(this.program, i);
      const short = name.replace(/\[0\]$/, "");
      this.uniforms[short] = { place: gl.getUniformLocation(this.program, name), type };
    }
  }

  // Set uniforms by name; a name that the shader does not use is skipped. A texture is {texture, unit}.
  use(values) {
    const gl = this.gl;
    gl.useProgram(this.program);
    this.set(values);
    return this;
  }

  set(values) {
    const gl = this.gl;
    for (const name in values) {
      const uniform = this.uniforms[name], value = values[name];
      if (!uniform) continue;
      switch (uniform.type) {
        case gl.FLOAT: gl.uniform1f(uniform.place, value); break;
        case gl.INT: gl.uniform1i(uniform.place, value); break;
        case gl.FLOAT_VEC2: gl.uniform2fv(uniform.place, value); break;
        case gl.FLOAT_VEC3: gl.uniform3fv(uniform.place, value); break;
        case gl.FLOAT_VEC4: gl.uniform4fv(uniform.place, value); break;
        case gl.FLOAT_MAT4: gl.uniformMatrix4fv(uniform.place, false, value); break;
        case gl.SAMPLER_2D:
          gl.activeTexture(gl.TEXTURE0 + value.unit);
          gl.bindTexture(gl.TEXTURE_2D, value.texture);
          gl.uniform1i(uniform.place, value.unit);
          break;
      }
    }
  }
}

const Textures = {
  make(gl, width, height, inner, format, type, filter, data = null) {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, format, type, data);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  },
  depth: (gl, w, h) => Textures.make(gl, w, h, gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, gl.NEAREST),
  half: (gl, w, h, filter) => Textures.make(gl, w, h, gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, filter),
  target(gl, colors, depth) {
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    colors.forEach((texture, i) =>
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0));
    if (depth) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth, 0);
    gl.drawBuffers(colors.length ? colors.map((_, i) => gl.COLOR_ATTACHMENT0 + i) : [gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return frame;
  },
};

// Triangles with a normal at each corner.
class Mesh {
  constructor(gl, places, normals, faces) {
    this.gl = gl;
    this.count = faces.length;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    for (const [slot, data] of [[0, places], [1, normals]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(slot);
      gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(faces), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  draw() {
    this.gl.bindVertexArray(this.array);
    this.gl.drawElements(this.gl.TRIANGLES, this.count, this.gl.UNSIGNED_INT, 0);
    this.gl.bindVertexArray(null);
  }
}

const Shapes = {
  box(gl) {
    const places = [], normals = [], faces = [];
    for (let axis = 0; axis < 3; axis++)
      for (const side of [-1, 1]) {
        const first = places.length / 3;
        for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
          const p = [0, 0, 0], n = [0, 0, 0];
          p[axis] = side, p[(axis + 1) % 3] = a * side, p[(axis + 2) % 3] = b;
          n[axis] = side;
          places.push(...p), normals.push(...n);
        }
        faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
      }
    return new Mesh(gl, places, normals, faces);
  },
  sphere(gl) {
    const places = [], faces = [], rows = 32, columns = 64;
    for (let i = 0; i <= rows; i++)
      for (let j = 0; j <= columns; j++) {
        const a = (Math.PI * i) / rows, b = (2 * Math.PI * j) / columns;
        places.push(Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a));
      }
    for (let i = 0; i < rows; i++)
      for (let j = 0; j < columns; j++) {
        const a = i * (columns + 1) + j, b = a + columns + 1;
        faces.push(a, b, b + 1, a, b + 1, a + 1);
      }
    return new Mesh(gl, places, places, faces);
  },
  cylinder(gl) {
    const places = [], normals = [], faces = [], n = 64;
    for (let j = 0; j <= n; j++) {
      const b = (2 * Math.PI * j) / n, c = Math.cos(b), s = Math.sin(b);
      places.push(c, s, -1, c, s, 1, c, s, -1, c, s, 1);
      normals.push(c, s, 0, c, s, 0, 0, 0, -1, 0, 0, 1);
    }
    places.push(0, 0, -1, 0, 0, 1), normals.push(0, 0, -1, 0, 0, 1);
    for (let j = 0; j < n; j++) {
      const a = 4 * j, b = a + 4;
      faces.push(a, b, b + 1, a, b + 1, a + 1, a + 2, 4 * n + 4, b + 2, a + 3, b + 3, 4 * n + 5);
    }
    return new Mesh(gl, places, normals, faces);
  },
  plane(gl) {
    return new Mesh(gl, [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1], [0, 1, 2, 0, 2, 3]);
  },
  // Corners and triangles of the scene; edges sharper than 40 degrees keep their own normals.
  mesh(gl, vertices, faces) {
    const places = [], normals = [], sum = new Map(), flat = [], key = (v) => `${v[0]},${v[1]},${v[2]}`;
    const corner = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [corner(faces[f]), corner(faces[f + 1]), corner(faces[f + 2])];
      const n = V.cross(V.sub(b, a), V.sub(c, a));
      flat.push(n);
      for (const p of [a, b, c]) {
        const around = sum.get(key(p)) || [];
        around.push(n), sum.set(key(p), around);
      }
    }
    const order = [];
    for (let f = 0; f < faces.length; f += 3) {
      const own = V.unit(flat[f / 3]);
      for (let k = 0; k < 3; k++) {
        const p = corner(faces[f + k]);
        let n = [0, 0, 0];
        for (const other of sum.get(key(p))) if (V.dot(V.unit(other), own) > 0.766) n = V.add(n, other);
        order.push(places.length / 3);
        places.push(...p), normals.push(...V.unit(n));
      }
    }
    return new Mesh(gl, places, normals, order);
  },
};

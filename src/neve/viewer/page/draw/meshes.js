// Triangles: of the shapes that are given by a formula, and of the meshes of a scene.

/** @import { Vec3 } from "./math.js" */

import { V } from "./math.js";

/** Triangles with a normal at each corner. */
export class TriangleMesh {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {number[]} places
   * @param {number[]} normals
   * @param {number[]} faces
   */
  constructor(gl, places, normals, faces) {
    this.gl = gl;
    this.count = faces.length;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    [places, normals].forEach((data, slot) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(slot);
      gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 0, 0);
    });
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

/** @param {WebGL2RenderingContext} gl */
function boxMesh(gl) {
  /** @type {number[]} */
  const places = [];
  /** @type {number[]} */
  const normals = [];
  const faces = [];
  const corners = [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ];
  for (let axis = 0; axis < 3; axis++)
    for (const side of [-1, 1]) {
      const first = places.length / 3;
      for (const [a, b] of corners) {
        const place = [0, 0, 0];
        const normal = [0, 0, 0];
        place[axis] = normal[axis] = side;
        place[(axis + 1) % 3] = a * side;
        place[(axis + 2) % 3] = b;
        places.push(...place);
        normals.push(...normal);
      }
      faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  return new TriangleMesh(gl, places, normals, faces);
}

/** @param {WebGL2RenderingContext} gl */
function sphereMesh(gl) {
  const places = [];
  const faces = [];
  const rows = 32;
  const columns = 64;
  for (let i = 0; i <= rows; i++)
    for (let j = 0; j <= columns; j++) {
      const a = (Math.PI * i) / rows;
      const b = (2 * Math.PI * j) / columns;
      places.push(Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a));
    }
  for (let i = 0; i < rows; i++)
    for (let j = 0; j < columns; j++) {
      const a = i * (columns + 1) + j;
      const b = a + columns + 1;
      faces.push(a, b, b + 1, a, b + 1, a + 1);
    }
  return new TriangleMesh(gl, places, places, faces);
}

/** @param {WebGL2RenderingContext} gl */
function cylinderMesh(gl) {
  const places = [];
  const normals = [];
  const faces = [];
  const n = 64;
  for (let j = 0; j <= n; j++) {
    const angle = (2 * Math.PI * j) / n;
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    places.push(c, s, -1, c, s, 1, c, s, -1, c, s, 1);
    normals.push(c, s, 0, c, s, 0, 0, 0, -1, 0, 0, 1);
  }
  places.push(0, 0, -1, 0, 0, 1);
  normals.push(0, 0, -1, 0, 0, 1);
  for (let j = 0; j < n; j++) {
    const a = 4 * j;
    const b = a + 4;
    faces.push(a, b, b + 1, a, b + 1, a + 1, a + 2, 4 * n + 4, b + 2, a + 3, b + 3, 4 * n + 5);
  }
  return new TriangleMesh(gl, places, normals, faces);
}

/** @param {WebGL2RenderingContext} gl */
function planeMesh(gl) {
  const places = [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0];
  return new TriangleMesh(gl, places, [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1], [0, 1, 2, 0, 2, 3]);
}

/**
 * Return the triangles of each shape that is given by a formula, of half extents 1, by its word.
 * @param {WebGL2RenderingContext} gl
 * @returns {Record<string, TriangleMesh>}
 */
export function shapeMeshes(gl) {
  return { plane: planeMesh(gl), box: boxMesh(gl), sphere: sphereMesh(gl), cylinder: cylinderMesh(gl) };
}

/**
 * Make a mesh of corners and triangles; edges sharper than 40 degrees keep their own normals.
 * @param {WebGL2RenderingContext} gl
 * @param {Float32Array} vertices
 * @param {Uint32Array} faces
 */
export function creasedMesh(gl, vertices, faces) {
  /** @param {number} i @returns {Vec3} */
  const corner = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
  /** @type {Map<string, Vec3[]>} normals, as long as twice the area, of the triangles around each corner */
  const around = new Map();
  /** @type {Vec3[]} */
  const flat = [];
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [corner(faces[f]), corner(faces[f + 1]), corner(faces[f + 2])];
    const normal = V.cross(V.sub(b, a), V.sub(c, a));
    flat.push(normal);
    for (const p of [a, b, c]) {
      const known = around.get(String(p));
      if (known) known.push(normal);
      else around.set(String(p), [normal]);
    }
  }
  /** @type {number[]} */
  const places = [];
  /** @type {number[]} */
  const normals = [];
  const order = [];
  for (let f = 0; f < faces.length; f += 3) {
    const own = V.unit(flat[f / 3]);
    for (let k = 0; k < 3; k++) {
      const p = corner(faces[f + k]);
      /** @type {Vec3} */
      let normal = [0, 0, 0];
      for (const other of around.get(String(p)) ?? [])
        if (V.dot(V.unit(other), own) > 0.766) normal = V.add(normal, other);
      order.push(places.length / 3);
      places.push(...p);
      normals.push(...V.unit(normal));
    }
  }
  return new TriangleMesh(gl, places, normals, order);
}

/**
 * Return the bytes of a text in base64.
 * @param {string} text
 */
export function bytesOf(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
}

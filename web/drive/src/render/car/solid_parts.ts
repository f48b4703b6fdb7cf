/** Small solids to build a car of: every one a triangle soup with positions, normals and one colour. */
import {
  BoxGeometry,
  BufferAttribute,
  Color,
  CylinderGeometry,
  ExtrudeGeometry,
  Matrix4,
  Quaternion,
  Shape,
} from "three";
import { TorusGeometry, Vector3 } from "three";
import type { BufferGeometry } from "three";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";

export type Point = readonly [x: number, y: number, z: number];

/** Parts that share a material, with a colour each. */
export class Parts {
  private readonly list: BufferGeometry[] = [];

  /** Add any geometry in colour `tint` (linear hexadecimal as in three). */
  add(geometry: BufferGeometry, tint: number): this {
    const soup = geometry.index ? geometry.toNonIndexed() : geometry;
    for (const name of Object.keys(soup.attributes)) {
      if (name !== "position" && name !== "normal") soup.deleteAttribute(name);
    }
    const { count } = soup.getAttribute("position");
    const colour = new Color(tint);
    const colours = new Float32Array(3 * count);
    for (let k = 0; k < count; k++) colour.toArray(colours, 3 * k);
    soup.setAttribute("color", new BufferAttribute(colours, 3));
    this.list.push(soup);
    return this;
  }

  /** A box of edges rounded by `round` [m], between two corners. */
  box([x0, y0, z0]: Point, [x1, y1, z1]: Point, round: number, tint: number): this {
    const [w, h, d] = [Math.abs(x1 - x0), Math.abs(y1 - y0), Math.abs(z1 - z0)];
    const box = round > 0 ? new RoundedBoxGeometry(w, h, d, 1, round) : new BoxGeometry(w, h, d);
    return this.add(box.translate((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2), tint);
  }

  /** A box on the left and its mirror image on the right. */
  boxes(a: Point, b: Point, round: number, tint: number): this {
    this.box(a, b, round, tint);
    return this.box([a[0], a[1], -a[2]], [b[0], b[1], -b[2]], round, tint);
  }

  /** A round bar between two points. */
  bar(a: Point, b: Point, radius: number, tint: number, sides = 8): this {
    const [from, to] = [new Vector3(...a), new Vector3(...b)];
    const way = to.clone().sub(from);
    const bar = new CylinderGeometry(radius, radius, way.length(), sides);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), way.normalize());
    const middle = from.add(to).multiplyScalar(0.5);
    return this.add(bar.applyMatrix4(new Matrix4().compose(middle, turn, new Vector3(1, 1, 1))), tint);
  }

  /** A bar and its mirror image. */
  bars(a: Point, b: Point, radius: number, tint: number, sides = 8): this {
    this.bar(a, b, radius, tint, sides);
    return this.bar([a[0], a[1], -a[2]], [b[0], b[1], -b[2]], radius, tint, sides);
  }

  /** A disc that looks along x, as a lamp does. */
  lamp([x, y, z]: Point, radius: number, depth: number, tint: number): this {
    const disc = new CylinderGeometry(radius, radius * 0.94, depth, 20);
    return this.add(disc.rotateZ(-Math.PI / 2).translate(x, y, z), tint);
  }

  /** A ring about x. */
  ring([x, y, z]: Point, radius: number, thick: number, tint: number): this {
    return this.add(new TorusGeometry(radius, thick, 8, 24).rotateY(Math.PI / 2).translate(x, y, z), tint);
  }

  /** A side view (x, y) drawn out to `width` [m] about z = 0, with its edges rounded by `round`. */
  drawn(shape: Shape, width: number, round: number, tint: number): this {
    const solid = new ExtrudeGeometry(shape, {
      depth: width - 2 * round,
      bevelEnabled: round > 0,
      bevelSize: round,
      bevelThickness: round,
      bevelOffset: -round,
      bevelSegments: 3,
      curveSegments: 14,
    });
    return this.add(solid.translate(0, 0, round - width / 2), tint);
  }

  /** A prism from a rectangle below to a smaller one above: [x0, x1, half width] at heights y0 and y1. */
  taper(y0: number, below: Point, y1: number, above: Point, tint: number): this {
    const box = new BoxGeometry(1, 1, 1);
    const p = box.getAttribute("position");
    for (let k = 0; k < p.count; k++) {
      const [x0, x1, half] = p.getY(k) < 0 ? below : above;
      p.setXYZ(k, p.getX(k) < 0 ? x0 : x1, p.getY(k) < 0 ? y0 : y1, 2 * half * p.getZ(k));
    }
    const soup = box.toNonIndexed();
    soup.computeVertexNormals();
    return this.add(soup, tint);
  }

  merged(): BufferGeometry {
    const whole = mergeGeometries(this.list);
    for (const part of this.list) part.dispose();
    return whole;
  }
}

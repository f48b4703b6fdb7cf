/** Many things of one shape: a picture draws those in sight of its camera, shadow maps draw all. */
import { DynamicDrawUsage, InstancedBufferAttribute, InstancedMesh, Matrix4, Vector3 } from "three";
import type { BufferGeometry, MeshStandardMaterial, PerspectiveCamera } from "three";

/** Within this distance nothing is left out [m]: what stands there may reach into the picture from anywhere. */
const BESIDE = 12;

/** A cone about all that a camera sees, and will see when it has moved and turned a little. */
export class Sight {
  private readonly eye = new Vector3();
  private readonly ahead = new Vector3(0, 0, -1);
  /** Half the angle of what is seen, turns included [rad]. */
  private half = Math.PI;
  private readonly way: number;
  private readonly turn: number;

  /** It holds until the camera has moved by `way` [m] or turned by `turn` [rad]; a wider lens takes from the turn. */
  constructor(way: number, turn: number) {
    this.way = way;
    this.turn = turn;
  }

  /** Take what a camera sees now. */
  take(camera: PerspectiveCamera): void {
    this.eye.copy(camera.position);
    camera.getWorldDirection(this.ahead);
    this.half = corner(camera) + this.turn;
  }

  /** Whether a camera sees more than what was taken. */
  isLeftBy(camera: PerspectiveCamera): boolean {
    const turned = camera.getWorldDirection(new Vector3()).angleTo(this.ahead);
    return this.eye.distanceTo(camera.position) > this.way || turned + corner(camera) > this.half;
  }

  /** Whether a ball may be seen. */
  holds(x: number, y: number, z: number, radius: number): boolean {
    const [a, b, c] = [x - this.eye.x, y - this.eye.y, z - this.eye.z];
    const away = Math.hypot(a, b, c);
    if (away < BESIDE + radius) return true;
    const cosine = (a * this.ahead.x + b * this.ahead.y + c * this.ahead.z) / away;
    const aside = Math.acos(Math.min(1, Math.max(-1, cosine)));
    // From elsewhere it is in another direction, and larger.
    return aside < this.half + Math.asin(this.way / away) + Math.asin(radius / (away - this.way));
  }
}

/** Angle between the middle and a corner of the picture [rad]. */
export function corner({ fov, aspect, zoom }: PerspectiveCamera): number {
  return Math.atan((Math.tan((fov * Math.PI) / 360) / zoom) * Math.hypot(1, aspect));
}

export class Stand {
  readonly mesh: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  /** How many stand there, and how many of them are drawn in a picture. */
  count = 0;
  seen = 0;
  private readonly matrices: Float32Array;
  private readonly shades: Float32Array;
  private readonly balls: Float32Array;

  /** At most `most` of a shape. */
  constructor(shape: BufferGeometry, material: MeshStandardMaterial, most: number) {
    this.mesh = new InstancedMesh(shape, material, most);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.instanceColor = new InstancedBufferAttribute(new Float32Array(3 * most), 3);
    this.mesh.frustumCulled = false;
    this.mesh.receiveShadow = true;
    this.mesh.onBeforeRender = () => void (this.mesh.count = this.seen);
    this.mesh.onBeforeShadow = () => void (this.mesh.count = this.count);
    this.matrices = new Float32Array(16 * most);
    this.shades = new Float32Array(most);
    this.balls = new Float32Array(4 * most);
    shape.computeBoundingSphere();
  }

  clear(): void {
    this.count = this.seen = 0;
  }

  /** Put one there, in a shade of its colour 0..1; no more than there is room for. */
  add(matrix: Matrix4, shade: number): void {
    if (16 * this.count >= this.matrices.length) return;
    const { center, radius } = this.mesh.geometry.boundingSphere!;
    const middle = center.clone().applyMatrix4(matrix);
    matrix.toArray(this.matrices, 16 * this.count);
    this.shades[this.count] = shade;
    this.balls.set([middle.x, middle.y, middle.z, radius * matrix.getMaxScaleOnAxis()], 4 * this.count);
    this.count++;
  }

  /** Sort what stands there: what is in sight comes first. */
  sort(sight: Sight): void {
    const { mesh, matrices, shades, balls, count } = this;
    const [places, colours] = [mesh.instanceMatrix.array, mesh.instanceColor!.array];
    let [first, last] = [0, count];
    for (let k = 0; k < count; k++) {
      const [x, y, z, radius] = [balls[4 * k]!, balls[4 * k + 1]!, balls[4 * k + 2]!, balls[4 * k + 3]!];
      const to = sight.holds(x, y, z, radius) ? first++ : --last;
      places.set(matrices.subarray(16 * k, 16 * k + 16), 16 * to);
      colours.fill(shades[k]!, 3 * to, 3 * to + 3);
    }
    this.seen = first;
    mesh.instanceMatrix.needsUpdate = true;
    mesh.instanceColor!.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}

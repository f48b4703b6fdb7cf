/** Lumps of snow as they are seen: broken balls, lit as the snow is. */
import {
  DynamicDrawUsage,
  Euler,
  IcosahedronGeometry,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
  Quaternion,
  Vector3,
} from "three";
import type { Atmosphere } from "../sky/atmosphere";
import { random } from "../../world/noise";
import { LUMP, MOST_LUMPS, type LumpMotion } from "./lump_motion";

/** Colour of broken snow, lying or in the air. */
export const BROKEN_SNOW = 0xe4e9f2;
/** How often lumps that wait to be buried are placed anew [s]. */
const LATER = 1;

export class Lumps {
  readonly mesh: InstancedMesh<IcosahedronGeometry, MeshStandardMaterial>;
  private waited = 0;

  constructor(air: Atmosphere) {
    const material = new MeshStandardMaterial({ color: BROKEN_SNOW, roughness: 0.95 });
    air.dress(material);
    this.mesh = new InstancedMesh(broken(), material, MOST_LUMPS);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.receiveShadow = true;
    this.mesh.count = 0;
  }

  /** Show what lies; snow that recovers with the time constant `recovery` [s] buries it. */
  update(dt: number, motion: LumpMotion, recovery: number): void {
    this.waited += dt;
    if (!motion.changed && this.waited < LATER) return;
    this.waited = 0;
    motion.changed = false;
    const [at, turn, size, matrix] = [new Vector3(), new Quaternion(), new Vector3(), new Matrix4()];
    const euler = new Euler();
    for (let k = 0; k < motion.count; k++) {
      const [x, y, z, wide, seed, age] = motion.lumps.subarray(k * LUMP, k * LUMP + LUMP);
      const buried = 1 - Math.exp(-age! / recovery);
      turn.setFromEuler(euler.set(6.28 * seed!, 40 * seed!, 90 * seed!));
      const half = 0.5 * wide!;
      size.set(half, half * (0.65 + 0.3 * seed!), half * (1.15 - 0.3 * seed!));
      this.mesh.setMatrixAt(k, matrix.compose(at.set(x!, y! - buried * wide!, z!), turn, size));
    }
    this.mesh.count = motion.count;
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}

/** A broken ball of twenty flat faces, of radius about 1: hundreds of them are to cost little. */
function broken(): IcosahedronGeometry {
  const ball = new IcosahedronGeometry(1, 0);
  const p = ball.getAttribute("position");
  const at = new Vector3();
  for (let k = 0; k < p.count; k++) {
    at.fromBufferAttribute(p, k);
    // By its place, so that the corners of neighbouring faces stay together.
    const [a, b, c] = [at.x, at.y, at.z].map((v) => Math.round(50 * v)) as [number, number, number];
    at.multiplyScalar(0.78 + 0.4 * random(a + 131 * b, c, 17));
    p.setXYZ(k, at.x, at.y, at.z);
  }
  ball.computeVertexNormals();
  return ball;
}

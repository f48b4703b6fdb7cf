/** The poles and flags of the marked course; the gate that counts next stands out. */
import { BoxGeometry, Color, DynamicDrawUsage, InstancedMesh, Matrix4, MeshStandardMaterial } from "three";
import type { BufferGeometry } from "three";
import { HALF, type Gate } from "../../course/course";
import { Parts } from "../car/solid_parts";
import type { Atmosphere } from "../sky/atmosphere";

const NEXT = new Color(1.6, 0.5, 0.05);
const OTHERS = new Color(0.12, 0.3, 0.85);
const START = new Color(0.15, 1, 0.25);

export class Gates {
  readonly mesh: InstancedMesh<BufferGeometry, MeshStandardMaterial>;
  private shown = -2;
  private readonly count: number;

  /** `surface`: height of the snow [m]. */
  constructor(air: Atmosphere, gates: readonly Gate[], surface: (x: number, z: number) => number) {
    const material = new MeshStandardMaterial({ roughness: 0.8, vertexColors: true });
    air.dress(material);
    this.count = gates.length;
    this.mesh = new InstancedMesh(flag(), material, 2 * gates.length);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.receiveShadow = true;
    gates.forEach(({ x, z, heading }, k) => {
      for (const side of [-1, 1]) {
        const [px, pz] = [x - side * HALF * Math.sin(heading), z + side * HALF * Math.cos(heading)];
        const turn = new Matrix4().makeRotationY(-heading + (side < 0 ? Math.PI : 0));
        this.mesh.setMatrixAt(2 * k + (side + 1) / 2, turn.setPosition(px, surface(px, pz), pz));
      }
    });
    this.show(0, false);
  }

  /** Mark the gate that counts next; whether a run is on. */
  show(next: number, running: boolean): void {
    const key = running ? next : -1;
    if (key === this.shown) return;
    this.shown = key;
    for (let k = 0; k < this.count; k++) {
      const colour = k === next ? (running ? NEXT : START) : OTHERS;
      for (const side of [0, 1]) this.mesh.setColorAt(2 * k + side, colour);
    }
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}

/** A pole with a pennant that hangs outwards, in white: instances colour it. */
function flag(): BufferGeometry {
  const p = new Parts().bar([0, -0.6, 0], [0, 1.9, 0], 0.028, 0x777777, 8);
  const cloth = new BoxGeometry(0.012, 0.62, 0.5, 1, 1, 6);
  const at = cloth.getAttribute("position");
  for (let k = 0; k < at.count; k++) {
    const z = at.getZ(k) + 0.25;
    // It narrows outwards and waves a little.
    at.setXYZ(k, at.getX(k) + 0.05 * Math.sin(9 * z), at.getY(k) * (1 - 1.2 * z) - 0.05 * z, z);
  }
  cloth.computeVertexNormals();
  return p.add(cloth.translate(0, 1.55, 0.02), 0xffffff).merged();
}

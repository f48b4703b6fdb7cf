/** Wheels without a car: those of a recording and of the game beside it. */
import { DynamicDrawUsage, InstancedMesh, Matrix4, MeshStandardMaterial, Quaternion, Vector3 } from "three";
import type { Rolling } from "../../bridge/playback";
import type { Atmosphere } from "../sky/atmosphere";
import { wheelShape } from "./car_shape";

const AXLE = new Vector3(0, 0, 1);

export class RollingWheels {
  readonly mesh: InstancedMesh;

  constructor(air: Atmosphere, count: number) {
    const material = new MeshStandardMaterial({ roughness: 0.7, vertexColors: true });
    air.dress(material);
    this.mesh = new InstancedMesh(wheelShape(), material, count);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.frustumCulled = false;
    this.mesh.receiveShadow = true;
    this.mesh.visible = false;
  }

  /** Show wheels of a radius and a width [m], which roll along x. */
  update(wheels: readonly Rolling[], radius: number, width: number): void {
    const size = new Vector3(radius / 0.38, radius / 0.38, width / 0.26);
    wheels.forEach(({ centre, spin }, k) => {
      const turn = new Quaternion().setFromAxisAngle(AXLE, -spin);
      this.mesh.setMatrixAt(k, new Matrix4().compose(new Vector3(...centre), turn, size));
    });
    this.mesh.visible = wheels.length > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    (this.mesh.material as MeshStandardMaterial).dispose();
    this.mesh.dispose();
  }
}

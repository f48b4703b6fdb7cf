/** The car as it is seen: body, wheels, snow that settles on both, lamps. */
import {
  DynamicDrawUsage,
  Group,
  InstancedMesh,
  Matrix4,
  Mesh,
  MeshPhysicalMaterial,
  MeshStandardMaterial,
  Quaternion,
  Vector3,
} from "three";
import type { BufferGeometry, Texture } from "three";
import type { Atmosphere, Changes } from "../sky/atmosphere";
import { put } from "../sky/atmosphere";
import { carShape, DRAWN, PAINT, wheelShape } from "./car_shape";
import { Cockpit } from "./cockpit";
import type { CarPose } from "./car_pose";

/** How the drawing is laid over a car, in the car's own frame. */
export interface Fit {
  /** Turn about y that brings the drawing's front (+x) to the car's [rad]. */
  readonly turn: number;
  /** Middle of the axles [m]. */
  readonly middle: readonly [number, number, number];
  /** Factors along and across. */
  readonly along: number;
  readonly across: number;
}

/** Lay the drawing over wheels at `places` in the car's frame, the front two first. */
export function fitTo(places: readonly Vector3[]): Fit {
  const mean = (some: readonly Vector3[]) =>
    some.reduce((sum, p) => sum.add(p), new Vector3()).divideScalar(some.length);
  const [front, rear] = [mean(places.slice(0, 2)), mean(places.slice(2))];
  const middle = front.clone().add(rear).multiplyScalar(0.5);
  return {
    turn: Math.atan2(-(front.z - rear.z), front.x - rear.x),
    middle: [middle.x, middle.y, middle.z],
    along: Math.hypot(front.x - rear.x, front.z - rear.z) / DRAWN.base,
    across: Math.hypot(places[0]!.x - places[1]!.x, places[0]!.z - places[1]!.z) / DRAWN.track,
  };
}

const SNOWED = /* glsl */ `
varying vec3 vLocal;
uniform sampler2D noiseMap;
uniform float snowed;
uniform float lying;
// Snow lies on what faces up, and sticks low on the sides and in the corners.
float snowOn(vec3 up) {
  float n = texture2D(noiseMap, vLocal.xz * 0.43 + vLocal.y * 0.17).b * 0.7 + texture2D(noiseMap, vLocal.xy * 1.7 + vLocal.z).b * 0.3;
  float top = smoothstep(0.55, 0.8, up.y * 0.62 + (n - 0.5) * 1.1 + 0.28 * snowed) * step(0.3, up.y) * lying;
  float low = smoothstep(0.32, -0.25, vLocal.y + (n - 0.5) * 0.9) * (0.35 + 0.65 * snowed);
  return clamp(max(top, low * smoothstep(0.32, 0.62, n + 0.25 * snowed)), 0.0, 1.0);
}
`;

/** How a car is drawn: in which colour, and whether as a ghost, without shadow or snow, that one looks through. */
export interface Livery {
  readonly colour?: number;
  readonly ghost?: boolean;
  /** Whether it is the visitor's own: one looks at it from near, and from inside. */
  readonly cockpit?: boolean;
}

export class CarView {
  readonly group = new Group();
  /** What throws the car's shadow. */
  readonly casters: Mesh[] = [];
  private readonly body = new Group();
  private readonly wheels: InstancedMesh;
  private readonly white: MeshStandardMaterial;
  private readonly red: MeshStandardMaterial;
  private readonly materials: MeshStandardMaterial[] = [];
  private readonly air: Atmosphere;
  private readonly noise: Texture;
  private readonly cockpit: Cockpit | null;
  private readonly ghost: boolean;
  private readonly snowed = { value: 0.3 };
  private fit: Fit | null = null;
  private axle = 0;

  constructor(
    air: Atmosphere,
    noise: Texture,
    { colour = PAINT, ghost = false, cockpit = true }: Livery = {},
  ) {
    this.air = air;
    this.noise = noise;
    this.ghost = ghost;
    const shape = carShape(colour);
    const paint = new MeshPhysicalMaterial({
      roughness: 0.42,
      clearcoat: 1,
      clearcoatRoughness: 0.06,
      metalness: 0.1,
    });
    this.part(shape.paint, this.dressed(paint, 1), true);
    this.part(shape.dark, this.dressed(new MeshStandardMaterial({ roughness: 0.75 }), 1), true);
    this.part(
      shape.metal,
      this.dressed(new MeshStandardMaterial({ roughness: 0.25, metalness: 0.9 }), 0.4),
      false,
    );
    this.part(
      shape.glass,
      this.dressed(new MeshStandardMaterial({ roughness: 0.05, metalness: 0.35 }), 0),
      false,
    );
    this.white = this.dressed(new MeshStandardMaterial({ roughness: 0.15 }), 0);
    this.part(shape.white, this.white, false);
    this.red = this.dressed(new MeshStandardMaterial({ roughness: 0.25 }), 0);
    this.part(shape.red, this.red, false);
    this.wheels = new InstancedMesh(
      wheelShape(cockpit),
      this.dressed(new MeshStandardMaterial({ roughness: 0.7 }), 0.7),
      4,
    );
    this.wheels.instanceMatrix.setUsage(DynamicDrawUsage);
    this.wheels.receiveShadow = true;
    if (!ghost) this.casters.push(this.wheels);
    this.cockpit = !cockpit ? null : new Cockpit((material, changes) => this.dressed(material, 0, changes));
    if (this.cockpit) this.body.add(this.cockpit.group);
    this.group.add(this.body, this.wheels);
  }

  /** Place body and wheels; `snowed` 0..1 is how much snow sticks to them. */
  update(pose: CarPose, snowed: number): void {
    const turn = new Quaternion(...pose.rotation);
    const place = new Vector3(...pose.position);
    const back = turn.clone().invert();
    const local = pose.wheels.map((w) => new Vector3(...w.centre).sub(place).applyQuaternion(back));
    const mean = local.reduce((sum, p) => sum + p.y / local.length, 0);
    if (!this.fit) {
      this.fit = fitTo(local);
      this.axle = mean;
    }
    // Springs move the wheels about where they rest; the body is drawn over the mean of where they were.
    this.axle += (mean - this.axle) * 0.01;
    const { fit } = this;
    const own = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), fit.turn);
    this.body.position.set(fit.middle[0], this.axle, fit.middle[2]).applyQuaternion(turn).add(place);
    this.body.quaternion.copy(turn).multiply(own);
    this.body.scale.set(fit.along, (fit.along + fit.across) / 2, fit.across);
    this.body.updateMatrixWorld();
    this.snowed.value = snowed;
    pose.wheels.forEach((wheel, k) => this.placeWheel(wheel, k, local[k]!, turn));
    this.wheels.instanceMatrix.needsUpdate = true;
    // So that wheels out of sight, and out of the reach of the shadows, cost nothing.
    this.wheels.computeBoundingSphere();
  }

  /** Show what the driver reads: speed [m/s], engine 0..1, steering of the front wheels [rad]. */
  read(speed: number, revs: number, steer: number): void {
    this.cockpit?.update(speed, revs, steer);
  }

  /** Draw of the car what `eye` [m] can see: the cockpit from inside only. */
  look(eye: Vector3): void {
    this.cockpit?.look(this.body.worldToLocal(eye.clone()));
  }

  /** Brightness of the lamps: white 0..1, red 0..1 (1 when braking). */
  shine(front: number, rear: number): void {
    this.white.emissive.setRGB(1, 0.93, 0.8).multiplyScalar(0.06 + 7 * front);
    this.red.emissive.setRGB(1, 0.03, 0.015).multiplyScalar(0.05 + 3.2 * rear);
  }

  /** What paint, glass and metal mirror. */
  mirror(environment: Texture | null): void {
    for (const material of this.materials) material.envMap = environment;
  }

  /** A point of the drawing [m] in the world. */
  toWorld(x: number, y: number, z: number): Vector3 {
    return new Vector3(x, y, z).applyMatrix4(this.body.matrixWorld);
  }

  dispose(): void {
    this.wheels.geometry.dispose();
    this.wheels.dispose();
    for (const material of this.materials) material.dispose();
    this.cockpit?.dispose();
    for (const part of this.body.children)
      if (part instanceof Mesh) (part.geometry as BufferGeometry).dispose();
  }

  private placeWheel(wheel: CarPose["wheels"][number], k: number, local: Vector3, turn: Quaternion): void {
    const fit = this.fit!;
    const own = turn.clone().multiply(new Quaternion().setFromAxisAngle(UP, fit.turn));
    // To the right of the drawing is +z: wheels there show their outside as drawn, those on the left turned about.
    const across = new Vector3(local.x - fit.middle[0], 0, local.z - fit.middle[2]).applyAxisAngle(
      UP,
      -fit.turn,
    ).z;
    own.multiply(new Quaternion().setFromAxisAngle(UP, wheel.steer));
    own.multiply(new Quaternion().setFromAxisAngle(AXLE, -wheel.spin));
    if (across < 0) own.multiply(new Quaternion().setFromAxisAngle(UP, Math.PI));
    const size = new Vector3(wheel.radius / 0.38, wheel.radius / 0.38, wheel.width / 0.26);
    this.wheels.setMatrixAt(k, new Matrix4().compose(new Vector3(...wheel.centre), own, size));
  }

  private part(geometry: BufferGeometry, material: MeshStandardMaterial, casts: boolean): void {
    const mesh = new Mesh(geometry, material);
    if (casts && !this.ghost) this.casters.push(mesh);
    mesh.receiveShadow = true;
    this.body.add(mesh);
  }

  private dressed<M extends MeshStandardMaterial>(material: M, snow: number, changes?: Changes): M {
    material.vertexColors = true;
    if (this.ghost) Object.assign(material, { transparent: true, opacity: 0.28, depthWrite: false });
    this.materials.push(material);
    this.air.dress(material, snow > 0 ? this.snowChanges(snow, material) : changes);
    return material;
  }

  private snowChanges(lying: number, material: MeshStandardMaterial): Changes {
    const clear = material instanceof MeshPhysicalMaterial ? "material.clearcoat *= 1.0 - snow;" : "";
    return {
      key: `snowed ${clear.length}`,
      uniforms: { noiseMap: { value: this.noise }, snowed: this.snowed, lying: { value: lying } },
      change: (shader) => {
        shader.vertexShader = put(
          shader.vertexShader,
          "void main() {",
          "varying vec3 vLocal;\nvoid main() {\nvLocal = position;",
        );
        let f = put(shader.fragmentShader, "void main() {", `${SNOWED}\nvoid main() {`);
        f = put(
          f,
          "#include <lights_physical_fragment>",
          SNOW_MATTER + `#include <lights_physical_fragment>\n${clear}`,
        );
        shader.fragmentShader = f;
      },
    };
  }
}

const UP = new Vector3(0, 1, 0);
const AXLE = new Vector3(0, 0, 1);

const SNOW_MATTER = /* glsl */ `
float snow = snowOn(transformNormalByInverseViewMatrix(normal, viewMatrix));
diffuseColor.rgb = mix(diffuseColor.rgb, vec3(0.84, 0.87, 0.91), snow);
roughnessFactor = mix(roughnessFactor, 0.95, snow);
metalnessFactor *= 1.0 - snow;
`;

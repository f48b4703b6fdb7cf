/** Headlamps and tail lamps: the light they give, and their halos in the air. */
import {
  AdditiveBlending,
  BufferAttribute,
  BufferGeometry,
  Group,
  PointLight,
  Points,
  ShaderMaterial,
  SpotLight,
} from "three";
import { Vector3 } from "three";
import type { Atmosphere } from "../sky/atmosphere";
import { HEADLAMPS, TAILLAMPS } from "./car_shape";
import type { CarView } from "./car_view";
import type { Point } from "./solid_parts";

const WARM = 0xffe2b8;

/** Two beams stand for six lamps: a wide one from the front, a long one from the rack. */
const BEAMS: readonly { from: Point; to: Point; angle: number; candela: number }[] = [
  { from: [1.95, 0.42, 0], to: [14, -0.35, 0], angle: 0.62, candela: 120 },
  { from: [0.25, 1.55, 0], to: [30, -0.4, 0], angle: 0.4, candela: 520 },
];

/**
 * How bright the halos of head and tail lamps are, 0..1: `need`, `braking` and `dark` 0..1. A halo is the lamp's light
 * thrown about in air and eye; by day the sky's own is so much brighter that none is seen.
 */
export function haloStrengths(need: number, braking: number, dark: number): [front: number, rear: number] {
  return [need * dark, Math.max(0.45 * need, braking) * dark];
}

export class Lamps {
  readonly group = new Group();
  private readonly air: Atmosphere;
  private readonly beams = BEAMS.map(({ angle }) => new SpotLight(WARM, 0, 120, angle, 0.9, 1.6));
  private readonly tail = new PointLight(0xff1808, 0, 9, 1.8);
  private readonly halos: Points<BufferGeometry, ShaderMaterial>;

  constructor(air: Atmosphere) {
    this.air = air;
    for (const beam of this.beams) this.group.add(beam, beam.target);
    this.group.add(this.tail);
    const count = HEADLAMPS.length + TAILLAMPS.length;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("facing", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("tint", new BufferAttribute(new Float32Array(3 * count), 3));
    const material = new ShaderMaterial({
      uniforms: { scale: { value: 500 } },
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
      blending: AdditiveBlending,
    });
    this.halos = new Points(geometry, material);
    this.halos.frustumCulled = false;
    this.halos.renderOrder = 25;
    this.group.add(this.halos);
  }

  /** Shine by `need` 0..1 from where the car is; `scale` as for flakes; `braking` and how dark it is, 0..1. */
  update(car: CarView, need: number, braking: number, dark: number, scale: number): void {
    const ahead = car
      .toWorld(10, 0, 0)
      .sub(car.toWorld(9, 0, 0))
      .normalize();
    this.beams.forEach((beam, k) => {
      const { from, to, candela } = BEAMS[k]!;
      beam.position.copy(car.toWorld(...from));
      beam.target.position.copy(car.toWorld(...to));
      beam.intensity = candela * need;
      beam.target.updateMatrixWorld();
    });
    this.tail.position.copy(car.toWorld(-2.5, 0.35, 0));
    this.tail.intensity = 0.22 * need + 1.2 * braking * (0.3 + 0.7 * need);
    const u = this.air.uniforms;
    u.lampPlace.value.copy(car.toWorld(1.6, 0.4, 0));
    u.lampDirection.value.copy(ahead);
    u.lampColour.value.setHex(WARM).multiplyScalar(2.2 * need);
    this.placeHalos(car, ahead, haloStrengths(need, braking, dark), scale);
  }

  dispose(): void {
    this.halos.geometry.dispose();
    this.halos.material.dispose();
    for (const light of [...this.beams, this.tail]) light.dispose();
  }

  private placeHalos(car: CarView, ahead: Vector3, [front, rear]: [number, number], scale: number): void {
    const { geometry, material } = this.halos;
    const [place, facing, tint] = ["position", "facing", "tint"].map(
      (name) => geometry.getAttribute(name) as BufferAttribute,
    ) as [BufferAttribute, BufferAttribute, BufferAttribute];
    [...HEADLAMPS, ...TAILLAMPS].forEach(([x, y, z], k) => {
      const forward = k < HEADLAMPS.length ? 1 : -1;
      const at = car.toWorld(x + 0.06 * forward, y, z);
      place.setXYZ(k, at.x, at.y, at.z);
      facing.setXYZ(k, forward * ahead.x, forward * ahead.y, forward * ahead.z);
      if (forward > 0) tint.setXYZ(k, 1.6 * front, 1.35 * front, front);
      else tint.setXYZ(k, 0.9 * rear, 0.05 * rear, 0.02 * rear);
    });
    place.needsUpdate = facing.needsUpdate = tint.needsUpdate = true;
    material.uniforms["scale"]!.value = scale;
    this.halos.visible = front > 0.01 || rear > 0.01;
  }
}

const VERTEX = /* glsl */ `
attribute vec3 facing;
attribute vec3 tint;
uniform float scale;
varying vec3 vTint;
void main() {
  vec3 toEye = cameraPosition - position;
  float seen = pow(max(dot(normalize(toEye), facing), 0.0), 1.5);
  vTint = tint * seen;
  gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
  gl_PointSize = clamp(scale * 1.5 / max(length(toEye), 0.5), 4.0, 220.0);
}
`;

const FRAGMENT = /* glsl */ `
varying vec3 vTint;
void main() {
  float r = length(gl_PointCoord - 0.5) * 2.0;
  float glow = pow(max(0.0, 1.0 - r), 3.0) * 0.5 + 0.5 * pow(max(0.0, 1.0 - r * 2.4), 2.0);
  gl_FragColor = vec4(vTint * glow, 1.0);
  #include <colorspace_fragment>
}
`;

/** The spray of the wheels as it is seen: puffs that throw the light forward, and clods that are shaded as balls of snow. */
import {
  Color,
  DynamicDrawUsage,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  InstancedInterleavedBuffer,
} from "three";
import { InterleavedBufferAttribute, Mesh, PlaneGeometry, ShaderMaterial } from "three";
import type { Texture } from "three";
import type { Atmosphere } from "../sky/atmosphere";
import type { CarPose } from "./car_pose";
import { BROKEN_SNOW } from "./lumps";
import { SprayMotion, STRIDE } from "./spray_motion";

export class Spray {
  readonly mesh: Mesh<InstancedBufferGeometry, ShaderMaterial>;
  private readonly motion: SprayMotion;
  private readonly buffer: InstancedInterleavedBuffer;

  /** `floor`: height on which clods come to rest [m]; `landed`: hears of each, with its size [m]. */
  constructor(
    air: Atmosphere,
    noise: Texture,
    floor: (x: number, z: number) => number,
    landed: (x: number, z: number, size: number) => void,
  ) {
    this.motion = new SprayMotion(floor, Math.random, landed);
    this.buffer = new InstancedInterleavedBuffer(this.motion.grains, STRIDE);
    this.buffer.setUsage(DynamicDrawUsage);
    const plane = new PlaneGeometry(1, 1);
    const geometry = new InstancedBufferGeometry();
    geometry.setIndex(plane.index);
    geometry.setAttribute("position", plane.getAttribute("position") as InstancedBufferAttribute);
    geometry.setAttribute("grain", new InterleavedBufferAttribute(this.buffer, 4, 0));
    geometry.setAttribute("state", new InterleavedBufferAttribute(this.buffer, 4, 4));
    geometry.instanceCount = 0;
    const uniforms = { noiseMap: { value: noise }, brokenSnow: { value: new Color(BROKEN_SNOW) } };
    const common = air.include({ uniforms });
    const material = new ShaderMaterial({
      uniforms,
      vertexShader: `${common}${VERTEX}`,
      fragmentShader: `${air.glsl}${FRAGMENT}`,
      transparent: true,
      depthWrite: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 20;
  }

  /** Go on by dt [s]. */
  update(dt: number, car: CarPose): void {
    this.motion.step(dt, car);
    this.mesh.geometry.instanceCount = this.motion.count;
    this.mesh.visible = this.motion.count > 0;
    this.buffer.clearUpdateRanges();
    this.buffer.addUpdateRange(0, Math.max(1, this.motion.count) * STRIDE);
    this.buffer.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

const VERTEX = /* glsl */ `
attribute vec4 grain;
attribute vec4 state;
varying vec2 vAt;
varying vec2 vSide;
varying vec4 vState;
varying vec3 vCentre;
varying vec3 vLit;
varying float vShade;
void main() {
  float turn = state.y * 6.283 + state.w * (state.y - 0.5) * 2.0;
  mat2 rotation = mat2(cos(turn), sin(turn), -sin(turn), cos(turn));
  vAt = position.xy * 2.0;
  vState = state;
  vCentre = grain.xyz;
  vSide = rotation * vAt;
  vShade = hillLight(grain.xyz);
  vLit = lightInAir(grain.xyz, cameraPosition, vShade);
  vec4 view = viewMatrix * vec4(grain.xyz, 1.0);
  view.xy += 0.5 * vSide * grain.w;
  gl_Position = projectionMatrix * view;
}
`;

const FRAGMENT = /* glsl */ `
uniform sampler2D noiseMap;
uniform vec3 brokenSnow;
varying vec2 vAt;
varying vec2 vSide;
varying vec4 vState;
varying vec3 vCentre;
varying vec3 vLit;
varying float vShade;
void main() {
  float r = length(vAt);
  float alpha = vState.x;
  vec3 c = vLit;
  if (vState.z < 0.5) {
    vec4 n = texture2D(noiseMap, vAt * 0.16 + vState.y * 7.0);
    vec4 fine = texture2D(noiseMap, vAt * 0.55 + vState.y * 3.0);
    float body = 0.65 * n.b + 0.35 * fine.b;
    // Torn edges, and grains that glitter where it is thin.
    alpha *= smoothstep(1.0, 0.15, r + 0.9 * (0.5 - body)) * (0.5 + body);
    alpha += vState.x * 0.5 * step(0.965, fine.a) * smoothstep(1.0, 0.4, r);
  } else {
    alpha *= 1.0 - smoothstep(0.55, 1.0, r);
    // The side of a ball that is seen, broken by noise; from the axes of the camera to those of the world.
    vec2 broken = texture2D(noiseMap, vAt * 0.3 + vState.y * 5.0).rg - 0.5;
    vec3 side = vec3(vSide, sqrt(max(0.0, 1.0 - r * r))) + vec3(0.8 * broken, 0.0);
    c = lightOnSnow(vCentre, normalize((vec4(side, 0.0) * viewMatrix).xyz), brokenSnow, vShade);
  }
  if (alpha < 0.008) discard;
  gl_FragColor = vec4(haze(c, vCentre, cameraPosition), alpha);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

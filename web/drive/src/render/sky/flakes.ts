/** Falling snow: points without memory, wrapped about the camera, so that they are everywhere at no cost. */
import { BufferAttribute, BufferGeometry, Points, ShaderMaterial, Vector3 } from "three";
import type { Atmosphere } from "./atmosphere";
import { random } from "../../world/noise";

/** Flakes at most, and side of the cube about the camera that they fill [m]. */
const COUNT = 7000;
const SIDE = 34;

export class Flakes {
  readonly mesh: Points<BufferGeometry, ShaderMaterial>;
  private time = 0;

  constructor(air: Atmosphere) {
    const places = new Float32Array(4 * COUNT);
    for (let k = 0; k < places.length; k++) places[k] = random(k, 3, 11);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 4));
    const material = new ShaderMaterial({
      uniforms: {
        ...air.uniforms,
        drift: { value: new Vector3() },
        scale: { value: 500 },
        thick: { value: 0 },
        time: { value: 0 },
      },
      vertexShader: `${air.glsl}${VERTEX}`,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
    });
    this.mesh = new Points(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 30;
  }

  /** `thick` 0..1; `scale`: pixels of the canvas that a metre one metre away takes. */
  update(dt: number, thick: number, scale: number): void {
    const u = this.mesh.material.uniforms;
    this.time += dt;
    const gust = 0.8 + 0.5 * Math.sin(this.time * 0.23);
    // The drift is kept within the cube: float32 stays exact over hours.
    const drift = u["drift"]!.value as Vector3;
    drift.addScaledVector(new Vector3(0.9 * gust, -1.15, 0.35 * gust), dt);
    for (const axis of ["x", "y", "z"] as const) drift[axis] %= SIDE;
    u["scale"]!.value = scale;
    u["thick"]!.value = thick;
    u["time"]!.value = this.time % 1000;
    this.mesh.visible = thick > 0.005;
    this.mesh.geometry.setDrawRange(0, Math.ceil(COUNT * thick));
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

const VERTEX = /* glsl */ `
uniform vec3 drift;
uniform float scale;
uniform float thick;
uniform float time;
varying float vAlpha;
varying vec3 vColour;
void main() {
  vec3 seed = vec3(position.y, position.z, position.x) * 6.283;
  vec3 sway = 0.22 * vec3(sin(time * (0.7 + seed.x * 0.2) + seed.y), 0.4 * sin(time * 1.3 + seed.z), cos(time * (0.6 + seed.y * 0.2) + seed.x));
  vec3 p = position.xyz * ${SIDE}.0 + drift * vec3(1.0) + sway - cameraPosition;
  p = mod(p, ${SIDE}.0) - ${(SIDE / 2).toFixed(1)};
  vec3 place = cameraPosition + p;
  vec4 view = viewMatrix * vec4(place, 1.0);
  gl_Position = projectionMatrix * view;
  float away = length(p);
  float pixels = scale * (0.014 + 0.016 * seed.x / 6.283) / max(-view.z, 0.2);
  gl_PointSize = clamp(pixels, 1.5, 26.0);
  // A flake smaller than its point is fainter; one at the lens is a blur; the cube's end is not seen.
  vAlpha = 0.85 * min(1.0, pixels / 1.5) * smoothstep(0.35, 1.6, away) * (1.0 - smoothstep(${(SIDE * 0.36).toFixed(1)}, ${(SIDE * 0.5).toFixed(1)}, away));
  vColour = lightInAir(place, cameraPosition, 1.0) * 1.5;
}
`;

const FRAGMENT = /* glsl */ `
varying float vAlpha;
varying vec3 vColour;
void main() {
  float r = length(gl_PointCoord - 0.5) * 2.0;
  float a = vAlpha * (1.0 - smoothstep(0.25, 1.0, r));
  if (a < 0.01) discard;
  gl_FragColor = vec4(vColour, a);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

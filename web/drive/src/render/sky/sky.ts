/** The dome of the sky: colours of the hour, sun or moon, thin clouds, stars. */
import { BackSide, Mesh, ShaderMaterial, SphereGeometry } from "three";
import type { Texture } from "three";
import type { Atmosphere } from "./atmosphere";

const FRAGMENT = /* glsl */ `
varying vec3 vDirection;
uniform sampler2D noiseMap;
uniform float stars;
uniform float time;
uniform float veil;
uniform float snowBelow;

float starAt(vec3 d) {
  // Cells on the faces of a cube; one star in some of them.
  vec3 a = abs(d);
  vec2 p = a.x > a.y && a.x > a.z ? d.yz / a.x : a.y > a.z ? d.xz / a.y : d.xy / a.z;
  p = p * 70.0 + (a.x > a.y && a.x > a.z ? 200.0 : a.y > a.z ? 400.0 : 600.0);
  vec2 cell = floor(p);
  vec3 r = fract(sin(vec3(dot(cell, vec2(127.1, 311.7)), dot(cell, vec2(269.5, 183.3)), dot(cell, vec2(419.2, 371.9)))) * 43758.5453);
  float bright = pow(r.z, 14.0);
  return bright * (1.0 - smoothstep(0.02, 0.14, length(fract(p) - 0.15 - 0.7 * r.xy)));
}

void main() {
  vec3 d = normalize(vDirection);
  vec3 c = skyColour(d);
  float up = max(d.y, 0.0);
  vec2 p = d.xz / (up + 0.18);
  float wisps = texture2D(noiseMap, p * vec2(0.05, 0.11) + time * 0.0004).b * 0.65 + texture2D(noiseMap, p * vec2(0.19, 0.42) + 0.3).b * 0.35;
  float cloud = smoothstep(0.5, 0.78, wisps) * smoothstep(0.015, 0.2, up) * (1.0 - veil);
  float toLight = max(dot(d, lightDirection), 0.0);
  vec3 lit = skyHorizon * 0.75 + lightColour * (0.05 + 0.22 * pow(toLight, 10.0)) * smoothstep(-0.12, 0.1, lightDirection.y);
  c = mix(c, lit, 0.55 * cloud);
  float disc = smoothstep(0.99985, 0.99994, toLight) * step(-0.03, d.y);
  c += lightColour * disc * mix(6.0, 2.5, stars) * (1.0 - 0.85 * veil);
  c += vec3(0.85, 0.92, 1.0) * starAt(d) * stars * smoothstep(0.0, 0.2, up) * (1.0 - cloud) * (1.0 - veil) * 1.6;
  // What the paint of the car mirrors below the horizon: snow under the same sky.
  c = mix(c, (skyLight + lightColour * max(lightDirection.y, 0.0)) * 0.27, snowBelow * smoothstep(0.01, -0.06, d.y));
  gl_FragColor = vec4(c, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

export class Sky {
  readonly mesh: Mesh<SphereGeometry, ShaderMaterial>;

  constructor(air: Atmosphere, noise: Texture, snowBelow = 0) {
    const material = new ShaderMaterial({
      uniforms: {
        ...air.uniforms,
        noiseMap: { value: noise },
        stars: { value: 0 },
        time: { value: 0 },
        veil: { value: 0 },
        snowBelow: { value: snowBelow },
      },
      vertexShader: /* glsl */ `
        varying vec3 vDirection;
        void main() {
          vDirection = position;
          vec4 p = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
          gl_Position = p.xyww;
        }`,
      fragmentShader: air.glsl + FRAGMENT,
      side: BackSide,
      depthWrite: false,
    });
    this.mesh = new Mesh(new SphereGeometry(10, 32, 20), material);
    this.mesh.frustumCulled = false;
    // Behind everything: drawn last of the opaque, so that only what is seen of it is shaded.
    this.mesh.renderOrder = 10;
  }

  /** Show stars (0..1), let clouds drift by dt [s], hide all behind a veil of fog (0..1). */
  update(stars: number, dt: number, veil: number): void {
    const u = this.mesh.material.uniforms;
    u["stars"]!.value = stars;
    u["time"]!.value += dt;
    u["veil"]!.value = veil;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

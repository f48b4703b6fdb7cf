/**
 * What all that is seen shares: the colours of the hour, haze that lies in the valleys, shadows of the mountains, and
 * the sun's two shadow maps (a fine one of the car, a coarse one of what stands about).
 */
import { Color, ShaderChunk, Vector3 } from "three";
import type { IUniform, Material, WebGLProgramParametersWithUniforms } from "three";
import type { GroundSource } from "../../world/ground_source";
import type { Daylight } from "./daylight";

const SKY = /* glsl */ `
uniform vec3 lightDirection;
uniform vec3 lightColour;
uniform vec3 skyZenith;
uniform vec3 skyHorizon;
uniform vec3 skyGlow;
uniform vec3 skyLight;
uniform vec3 snowLight;
uniform vec3 lampPlace;
uniform vec3 lampDirection;
uniform vec3 lampColour;
uniform vec3 hazeShape; // extinction [1/m] at the base, height of the base [m], height over which it falls by e [m]

vec3 skyColour(vec3 d) {
  float up = max(d.y, 0.0);
  float toLight = max(dot(d, lightDirection), 0.0);
  vec3 c = mix(skyHorizon, skyZenith, 1.0 - pow(1.0 - up, 3.2) * 0.94 - 0.06 * exp(-24.0 * up));
  float band = exp(-5.0 * up);
  c += skyGlow * (0.34 * pow(toLight, 6.0) * band + 0.26 * pow(toLight, 40.0) + 0.3 * pow(toLight, 400.0));
  return c;
}

// What a headlamp sends to a place, without the angle at which it arrives there.
vec3 lampLight(vec3 fromLamp, float away) {
  float cone = smoothstep(0.8, 0.97, dot(fromLamp / away, lampDirection));
  return lampColour * cone * 0.3 / (1.0 + 0.03 * away * away);
}

// Light on small things in the air (flakes, puffs), which throw it forward: sun or moon, sky, headlamps.
vec3 lightInAir(vec3 place, vec3 eye, float shade) {
  vec3 d = normalize(place - eye);
  float toLight = dot(d, lightDirection);
  vec3 fromLamp = place - lampPlace;
  vec3 c = skyLight * 0.3 + lightColour * shade * (0.12 + 0.1 * toLight * toLight + 0.34 * pow(max(toLight, 0.0), 8.0));
  return c + lampLight(fromLamp, max(length(fromLamp), 0.3));
}

// Snow lets light through its edges: what is seen beyond the terminator of what faces the light by a cosine.
vec3 pastTerminator(float facing) {
  float tail = max(0.0, (facing + 0.35) / 1.35) - max(0.0, facing);
  return vec3(0.62, 0.82, 1.0) * tail * 0.55;
}

// Light that a piece of snow throws back, as three's sun and hemisphere light what lies on the ground.
vec3 lightOnSnow(vec3 place, vec3 normal, vec3 colour, float shade) {
  float facing = dot(normal, lightDirection);
  vec3 c = lightColour * shade * (max(0.0, facing) + pastTerminator(facing));
  c += mix(snowLight, skyLight, 0.5 * normal.y + 0.5);
  vec3 fromLamp = place - lampPlace;
  float away = max(length(fromLamp), 0.3);
  return colour * (0.3183099 * c + lampLight(fromLamp, away) * max(0.0, -dot(normal, fromLamp / away)));
}

vec3 haze(vec3 colour, vec3 place, vec3 eye) {
  vec3 way = place - eye;
  float far = length(way);
  vec3 d = way / max(far, 1e-3);
  float rise = way.y / hazeShape.z;
  float mean = abs(rise) > 1e-3 ? (1.0 - exp(-rise)) / rise : 1.0 - 0.5 * rise;
  float depth = far * hazeShape.x * exp(clamp(-(eye.y - hazeShape.y) / hazeShape.z, -20.0, 2.0)) * min(mean, 40.0);
  // Thin air far away is bluer than the mist of the valley.
  vec3 air = far * vec3(3.5e-5, 5.5e-5, 9.0e-5);
  vec3 through = exp(-(vec3(depth) + air));
  vec3 glowing = skyColour(normalize(vec3(d.x, max(d.y, 0.0) * 0.5 + 0.02, d.z)));
  return mix(glowing, colour, through);
}
`;

const TERRAIN_SHADE = /* glsl */ `
// How much of the light the hills leave to a place: a march toward the light in ever longer steps.
float hillLight(vec3 place) {
  float least = 1.0;
  float t = 5.0;
  for (int k = 0; k < 9; k++) {
    vec3 p = place + lightDirection * t;
    // Far steps read coarse levels: they ask for hills, not for stones.
    int level = max(int(groundLevel(p.xz)), int(log2(t / 12.0)));
    float over = p.y + 0.6 - groundAt(level, p.xz);
    least = min(least, 0.5 + over / (0.045 * t + 0.5));
    t *= 1.9;
  }
  return smoothstep(0.0, 1.0, least);
}
`;

/**
 * A shadow with edges as a cubic B-spline over the texels draws them. three's own turns a few samples by the place on the
 * screen, which weaves a pattern into soft edges. Each of the four reads is bilinear over comparisons, by which the
 * sixteen weights are had (Sigg and Hadwiger 2005, "Fast third-order texture filtering", GPU Gems 2, chapter 20).
 */
const SOFT_SHADOW = /* glsl */ `
#if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 1
float softShadow(sampler2DShadow map, vec2 size, float bias, vec3 place) {
  place.z += bias;
  if (any(lessThan(place.xy, vec2(0.0))) || any(greaterThan(place, vec3(1.0)))) return 1.0;
  vec2 p = place.xy * size - 0.5;
  vec2 f = fract(p);
  vec2 g = 1.0 - f;
  // Weights of the texels -1, 0, 1, 2 about p; the first two and the last two are read at once.
  vec2 w0 = g * g * g / 6.0;
  vec2 w3 = f * f * f / 6.0;
  vec2 w1 = 2.0 / 3.0 - 0.5 * f * f * (2.0 - f);
  vec2 w2 = 1.0 - w0 - w1 - w3;
  vec2 low = w0 + w1;
  vec2 high = w2 + w3;
  vec2 a = (p - f - 0.5 + w1 / low) / size;
  vec2 b = (p - f + 1.5 + w3 / high) / size;
  return low.y * (low.x * texture(map, vec3(a, place.z)) + high.x * texture(map, vec3(b.x, a.y, place.z)))
    + high.y * (low.x * texture(map, vec3(a.x, b.y, place.z)) + high.x * texture(map, vec3(b, place.z)));
}
#endif
`;

/** Between these marks three's chunk sums the directional lights; ours has one, with two shadow maps. */
function sunlit(): string {
  const chunk = ShaderChunk.lights_fragment_begin;
  const from = chunk.indexOf("#if ( NUM_DIR_LIGHTS > 0 ) && defined( RE_Direct )");
  const to = chunk.indexOf("#if ( NUM_RECT_AREA_LIGHTS > 0 )");
  return (
    chunk.slice(0, from) +
    /* glsl */ `
    getDirectionalLightInfo(directionalLights[0], directLight);
    float sunVisible = vHillLight;
    #if defined(USE_SHADOWMAP) && NUM_DIR_LIGHT_SHADOWS > 1
      // The car is in the fine map alone, woods and rocks in the coarse one.
      float fall = softShadow(directionalShadowMap[0], directionalLightShadows[0].shadowMapSize,
        directionalLightShadows[0].shadowBias, vDirectionalShadowCoord[0].xyz);
      vec2 edge = abs(vDirectionalShadowCoord[1].xy - 0.5);
      fall *= mix(softShadow(directionalShadowMap[1], directionalLightShadows[1].shadowMapSize,
        directionalLightShadows[1].shadowBias, vDirectionalShadowCoord[1].xyz),
        1.0, smoothstep(0.42, 0.5, max(edge.x, edge.y)));
      if (receiveShadow) sunVisible *= fall;
    #endif
    SUN_HOOK
    directLight.color *= sunVisible;
    RE_Direct(directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight);
    ` +
    chunk.slice(to)
  );
}

/** Replace `what` in `source`, and say so if three no longer has it. */
export function put(source: string, what: string, by: string): string {
  if (!source.includes(what)) throw new Error(`three's shader has no "${what}"`);
  return source.replace(what, () => by);
}

export type Shader = WebGLProgramParametersWithUniforms;

/** Changes to a standard material beyond the air: GLSL put in at named places. */
export interface Changes {
  readonly key: string;
  readonly uniforms?: Record<string, IUniform>;
  change(shader: Shader): void;
  /** GLSL run when the sun's visibility `sunVisible` is known, before its light is added. */
  readonly sun?: string;
}

export class Atmosphere {
  readonly uniforms = {
    lightDirection: { value: new Vector3(0, 1, 0) },
    lightColour: { value: new Color() },
    skyZenith: { value: new Color() },
    skyHorizon: { value: new Color() },
    skyGlow: { value: new Color() },
    skyLight: { value: new Color() },
    snowLight: { value: new Color() },
    lampPlace: { value: new Vector3() },
    lampDirection: { value: new Vector3(1, 0, 0) },
    lampColour: { value: new Color(0) },
    hazeShape: { value: new Vector3(1e-4, 0, 40) },
  };
  /** `vec3 skyColour(vec3 direction)`, `vec3 haze(vec3 colour, vec3 place, vec3 eye)`. */
  readonly glsl = SKY;

  private readonly ground: GroundSource;

  constructor(ground: GroundSource) {
    this.ground = ground;
  }

  /** The ground's code alone. */
  get groundGlsl(): string {
    return this.ground.glsl;
  }

  /** Set the hour's light and the fog, 0..1. */
  set(light: Daylight, fog: number): void {
    const u = this.uniforms;
    u.lightDirection.value.set(...light.direction);
    u.lightColour.value.setRGB(...light.sun);
    u.skyZenith.value.setRGB(...light.zenith);
    u.skyHorizon.value.setRGB(...light.horizon);
    u.skyGlow.value.setRGB(...light.glow);
    u.skyLight.value.setRGB(...light.sky);
    u.snowLight.value.setRGB(...light.bounce);
    u.hazeShape.value.x = 1e-4 * 320 ** fog;
    u.hazeShape.value.z = 24 + 90 * fog;
  }

  /** GLSL and uniforms of the ground, light and air for a shader of one's own. */
  include(shader: { uniforms: Record<string, IUniform> }): string {
    Object.assign(shader.uniforms, this.uniforms, this.ground.uniforms);
    return this.ground.glsl + SKY + TERRAIN_SHADE;
  }

  /** Make a standard material stand in this air: haze, shadows of hills, the two shadow maps. */
  dress(material: Material, changes?: Changes): void {
    material.onBeforeCompile = (shader) => {
      const common = this.include(shader);
      shader.vertexShader = put(
        shader.vertexShader,
        "#include <common>",
        `#include <common>
        varying vec3 vPlace;
        varying float vHillLight;
        ${common}`,
      );
      shader.vertexShader = put(
        shader.vertexShader,
        "#include <fog_vertex>",
        `
        vPlace = worldPosition.xyz;
        vHillLight = hillLight(vPlace);`,
      );
      shader.fragmentShader = put(
        shader.fragmentShader,
        "#include <common>",
        `#include <common>
        varying vec3 vPlace;
        varying float vHillLight;
        ${SKY}${SOFT_SHADOW}`,
      );
      shader.fragmentShader = put(
        shader.fragmentShader,
        "#include <lights_fragment_begin>",
        sunlit().replace("SUN_HOOK", changes?.sun ?? ""),
      );
      shader.fragmentShader = put(
        shader.fragmentShader,
        "#include <tonemapping_fragment>",
        `gl_FragColor.rgb = haze(gl_FragColor.rgb, vPlace, cameraPosition);
        #include <tonemapping_fragment>`,
      );
      Object.assign(shader.uniforms, changes?.uniforms);
      changes?.change(shader);
    };
    material.customProgramCacheKey = () => changes?.key ?? "air";
  }
}

// Snow as one surface: depths of grains, smoothed in the picture where they belong together; normals from them, light
// from the opacity maps, fine grain and hollows from what the smoothing took away. After van der Laan, Green and Sainz
// 2009, Screen space fluid rendering with curvature flow, with a bilateral filter in place of the flow.

import { GLSL_BALL, GLSL_CHUNK, GLSL_COMMON, GLSL_GRAIN, GLSL_LENS, GLSL_PLACE } from "./glsl.js";
import { POOL } from "./pool_shaders.js";

const SNOW = {
  vertex: `
layout(location = 0) in vec3 aPlace;
layout(location = 1) in float aValue;
uniform vec3 uLow, uStep, uForward;
uniform mat4 uMatrix;
uniform float uSpacing, uFocal, uGrains, uSpread, uSize, uColored, uSkip;
uniform vec4 uClip;
uniform sampler2D uLight, uNormal;
${GLSL_COMMON}
${GLSL_GRAIN}
out vec4 vLight;
out float vDepth, vRadius, vValue;
flat out mat3 vTurn;
flat out vec4 vCut[3];
void main() {
  vec3 p = uLow + uStep * aPlace;
  uint seed = seedOf(uSkip);
  ivec2 texel = ivec2(gl_VertexID % 1024, gl_VertexID / 1024);
  vec4 light = texelFetch(uLight, texel, 0), shape = texelFetch(uNormal, texel, 0);
  float loose = smoothstep(0.62, 0.97, shape.w), u = unit(seed);
  p += uSpread * uSpacing * scattered(seed);
  vRadius = uSize * 0.80 * uSpacing / pow(uGrains, 0.3333) * (0.75 + 0.45 * u * u) * mix(1.0, 0.5, loose);
  vDepth = max(dot(p - uEye, uForward), 1e-4);
  gl_Position = uMatrix * vec4(p, 1.0);
  gl_PointSize = clamp(2.0 * vRadius * uFocal / vDepth, 1.6, 400.0);
  // Where each of its faces is; a grain of few pixels is a ball.
  vTurn = turned(seed);
  float whole = 1.0 - smoothstep(8.0, 24.0, gl_PointSize);
  for (int k = 0; k < 3; ++k) {
    uint bits = scramble(seed + 11u + uint(k));
    vCut[k] = mix(0.50 + 0.34 * vec4(bits & 255u, (bits >> 8) & 255u, (bits >> 16) & 255u, bits >> 24) / 255.0, vec4(1.0), whole);
  }
  bool lost = aPlace.x + aPlace.y + aPlace.z > 196604.0;
  if (lost || dot(uClip.xyz, p) + uClip.w > 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  vLight = vec4(light.xyz, uColored < 0.5 ? aValue / 65535.0 : 0.0);
  vValue = uColored < 0.5 ? u : aValue / 65535.0;
}`,
  first: `
${GLSL_COMMON}
${GLSL_LENS}
${GLSL_BALL}
${GLSL_CHUNK}
uniform vec3 uRight, uUp, uForward;
in vec4 vLight;
in float vDepth, vRadius, vValue;
flat in mat3 vTurn;
flat in vec4 vCut[3];
layout(location = 0) out vec4 place;  // depth [m], its share of the grain's radius
layout(location = 1) out vec4 light;
layout(location = 2) out vec4 grain;  // direction from the grain's middle, and its value
void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  float up = chunkHeight(ballHeight(at), vTurn, uRight * at.x - uUp * at.y, -uForward, vCut);
  float depth = vDepth - vRadius * up;
  gl_FragDepth = lensDepth(depth);
  place = vec4(depth, vRadius, 0.0, 1.0);
  light = vLight;
  grain = vec4(uRight * at.x - uUp * at.y - uForward * up, vValue);
}`,
  // How much snow a ray passes through in all grains, seen or hidden [spacings].
  thick: `
${GLSL_BALL}
in vec4 vLight;
in float vDepth, vRadius, vValue;
uniform float uSpacing;
out vec4 color;
void main() {
  color = vec4(2.0 * vRadius * ballHeight(2.0 * gl_PointCoord - 1.0) / uSpacing);
}`,
  shade: `
${GLSL_COMMON}
${GLSL_PLACE}
uniform sampler2D uSun_, uGrain, uRaw, uThick, uPalette;
uniform float uColored;
out vec4 color;
float corner(uvec3 i, uint seed) {
  return 2.0 * unit(scramble(i.x * 0x9e3779b1u ^ scramble(i.y * 0x85ebca6bu ^ scramble(i.z ^ seed)))) - 1.0;
}
// Smooth noise with its slopes.
vec4 lumps(vec3 at, uint seed) {
  vec3 f = floor(at), t = at - f, s = t * t * (3.0 - 2.0 * t), d = 6.0 * t * (1.0 - t);
  uvec3 i = uvec3(ivec3(f));
  vec4 low = vec4(corner(i, seed), corner(i + uvec3(1, 0, 0), seed), corner(i + uvec3(0, 1, 0), seed), corner(i + uvec3(1, 1, 0), seed));
  i.z += 1u;
  vec4 high = vec4(corner(i, seed), corner(i + uvec3(1, 0, 0), seed), corner(i + uvec3(0, 1, 0), seed), corner(i + uvec3(1, 1, 0), seed));
  vec4 level = mix(low, high, s.z), rise = high - low;
  vec2 along = mix(level.xz, level.yw, s.x), up = mix(rise.xz, rise.yw, s.x), across = level.yw - level.xz;
  return vec4(mix(along.x, along.y, s.y), d * vec3(mix(across.x, across.y, s.y), along.y - along.x, mix(up.x, up.y, s.y)));
}
vec3 named(float value) {
  if (value < 0.5) return vec3(0.50);
  return 0.42 + 0.34 * cos(fract(value * 0.61803399) * 6.2831853 + vec3(0.0, 2.1, 4.2));
}
void main() {
  float depth = depthAt(vAt);
  if (depth <= 0.0) discard;
  vec4 light = textureLod(uSun_, vAt, 0.0), grain = textureLod(uGrain, vAt, 0.0);
  vec2 raw = textureLod(uRaw, vAt, 0.0).xy;
  vec3 here = rayAt(vAt) * depth;
  gl_FragDepth = lensDepth(depth);
  vec3 broad = normalAt(here, depth);
  // Fine grain sits on each particle, so that it moves with the snow; it fades where a pixel is larger.
  float pixels = raw.y * uFocal / depth;
  uint seed = uint(grain.w * 65535.0);
  vec3 bump = vec3(0.0);
  float fleck = 0.0;
  for (int o = 0; o < 3; ++o) {
    float many = 2.6 * pow(2.3, float(o)), fade = clamp(pixels / (1.5 * many) - 0.4, 0.0, 1.0);
    if (fade <= 0.0) break;
    vec4 n = lumps(many * grain.xyz + 31.0, seed + uint(o));
    bump += fade * 0.17 * n.yzw;
    fleck += fade * n.x;
  }
  // Where grains are large their faces stand for themselves; small ones are round.
  vec3 normal = normalize(broad + 0.20 * (1.0 - smoothstep(4.0, 12.0, pixels)) * grain.xyz - bump);
  // Hollows: how much of the snow around stands in front.
  float hollow = 0.0;
  for (int i = 0; i < 8; ++i) {
    float turn = 0.785398 * float(i);
    float far = (i % 2 == 0 ? 0.7 : 1.8) * uSpacing * uFocal / depth;
    float there = depthAt(vAt + uPixel_ * far * vec2(cos(turn), sin(turn)));
    float front = there > 0.0 ? (depth - there) / uSpacing : 0.0;
    hollow += clamp(0.7 * front, 0.0, 1.0) * smoothstep(4.0, 1.5, front) / 8.0;
  }
  float sunk = clamp((raw.x - depth) / (0.8 * uSpacing), -0.4, 1.0);
  float ao = clamp(1.0 - 0.60 * hollow - 0.22 * sunk, 0.5, 1.1);
  float thick = textureLod(uThick, vAt, 0.0).x;
  float sun = max((dot(normal, uSun) + 0.25) / 1.25, 0.0) * light.x;  // light wanders a little way in
  float bright = light.y / (1.0 - 0.60 * (1.0 - clamp(light.y, 0.0, 1.0)));
  float open = (0.80 + 0.24 * normal.z + 0.10 * dot(normal, broad)) * ao;
  vec3 around = uSkyColor * vec3(0.68, 0.79, 0.94) * bright
    + (uSunColor * vec3(0.062, 0.074, 0.090) + uSkyColor * 0.16) * (1.0 - clamp(light.y, 0.0, 1.0))
    + (uSunColor * (0.7 * max(uSun.z, 0.0)) + uSkyColor) * (0.10 * (0.5 - 0.5 * normal.z))
    + uSunColor * vec3(0.72, 0.90, 1.0) * (0.14 * light.z);
  // Thin snow lets the sun through, most of it straight on.
  float ahead = pow(clamp(dot(normalize(here), uSun), 0.0, 1.0), 4.0);
  around += uSunColor * vec3(0.9, 0.95, 1.0) * (light.z * exp(-0.7 * thick) * (0.15 + 0.5 * ahead));
  vec3 lit = (uSunColor * sun * mix(1.0, ao, 0.4) + around * open) * (1.0 + 0.04 * fleck);
  if (uColored > 0.5) {
    vec3 base = uColored > 1.5 ? named(grain.w * 65535.0) : texture(uPalette, vec2(grain.w, 0.5)).rgb;
    lit = base * base * (0.42 + 0.95 * dot(lit, vec3(0.3, 0.5, 0.2)));
  } else {
    float wet = clamp(2.0 * light.w, 0.0, 1.0);
    uvec3 cell = uvec3(ivec3(floor(9.0 * grain.xyz + 20.0)));
    uint facet = scramble(cell.x ^ scramble(cell.y ^ scramble(cell.z ^ seed)));
    vec3 face = normalize(normal + 0.9 * (vec3(unit(facet), unit(scramble(facet + 1u)), unit(scramble(facet + 2u))) - 0.5));
    float glint = smoothstep(0.992, 1.0, dot(face, normalize(uSun - normalize(here))));
    lit += uSunColor * light.x * (1.6 * glint * (1.0 - wet) * clamp(pixels / 14.0 - 0.3, 0.0, 1.0));
    lit *= mix(vec3(1.0), vec3(0.70, 0.76, 0.82), wet);
  }
  float far = haze(depth);
  color = vec4(film(mix(lit, horizon(), far)), 1.0 - exp(-3.0 * thick));
}`,
};

export const SURFACE_SHADERS = {
  snow: SNOW,
  water: POOL,
  pictureVertex: `
out vec2 vAt;
void main() {
  vAt = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0;
  gl_Position = vec4(2.0 * vAt - 1.0, 0.0, 1.0);
}`,
  // Mean along one axis of what is about as deep.
  smoothFragment: `
uniform sampler2D uPlace, uSun;
uniform vec2 uWay;       // one pixel along the axis, in shares of the picture
uniform float uReach_, uSpacing, uFocal, uRange, uMost;
in vec2 vAt;
layout(location = 0) out vec4 place;
layout(location = 1) out vec4 light;
void main() {
  place = textureLod(uPlace, vAt, 0.0);
  light = textureLod(uSun, vAt, 0.0);
  if (place.x <= 0.0) return;
  // Large grains stand for themselves: what makes one surface of small ones would blur their edges.
  float wide = uSpacing * uFocal / place.x, own = wide / uMost;
  float pixels = clamp(uReach_ * wide / (1.0 + own * own * own), 0.6, 24.0), sum = 1.0, deep = place.x;
  vec4 lit = light;
  // What is smoothed is no steeper than about 60 degrees: a step between pixels that are close to each other is an edge.
  float range = min(uRange, 1.7 * pixels * place.x / uFocal);
  for (int i = -6; i <= 6; ++i) {
    if (i == 0) continue;
    float t = float(i) / 3.0;
    vec2 at = vAt + uWay * (t * pixels);
    float depth = textureLod(uPlace, at, 0.0).x;
    float away = (depth - place.x) / range;
    float w = depth > 0.0 ? exp(-0.5 * t * t - away * away) : 0.0;
    deep += w * depth;
    lit += w * textureLod(uSun, at, 0.0);
    sum += w;
  }
  place.x = deep / sum;
  light = lit / sum;
}`,
};

// What all shaders share: random bits, the sky, the film's curve, and how much light passes the snow.
// The light is that of the film (core/render): the same sun, sky, albedo and tone curve. Where the film walks through a
// density grid, the page asks deep opacity maps (Yuksel and Keyser 2008): for each of 13 directions the depth at which
// snow begins and the optical depth of what follows, in four layers.

import { GLSL_TILES, GLSL_WET_GROUND, GLSL_WET_SNOW, WATER_SHADERS } from "./water_shaders.js";

export const GLSL_HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
`;

const GLSL_COMMON = `
uniform vec3 uSun, uSunColor, uSkyColor, uEye;
uniform float uReach;

uint scramble(uint a) {
  a ^= a >> 16; a *= 0x7feb352du; a ^= a >> 15; a *= 0x846ca68bu;
  return a ^ (a >> 16);
}
float unit(uint bits) { return float(bits >> 8) * (1.0 / 16777216.0); }
vec3 horizon() { return uSkyColor * vec3(1.55, 1.58, 1.50) + uSunColor * 0.05; }
vec3 sky(vec3 direction) {
  vec3 zenith = uSkyColor * vec3(0.30, 0.50, 0.82);
  float up = max(direction.z, 0.0);
  float glow = pow(clamp(0.5 + 0.5 * dot(direction, uSun), 0.0, 1.0), 6.0);
  return mix(horizon(), zenith, 1.0 - exp(-6.5 * up)) + uSunColor * (0.06 * glow);
}
float haze(float far) { return 1.0 - exp(-0.10 * max(far / uReach - 1.25, 0.0)); }
vec3 film(vec3 light) {
  vec3 e = 1.0 - exp(-1.05 * pow(max(light, 0.0), vec3(1.15)));
  return mix(12.92 * e, 1.055 * pow(e, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, e));
}
`;

const GLSL_MAPS = `
${GLSL_TILES}
uniform vec4 uLayers;   // ends of the layers [m]
uniform sampler2D uSkyDepth, uSkyDepths, uSunDepth, uSunDepths, uSolidDepth;
uniform float uMaps;    // 0: no maps, all is open

float layered(vec4 sums, float behind) {
  if (behind <= 0.0) return 0.0;
  if (behind < uLayers.x) return sums.x * behind / uLayers.x;
  if (behind < uLayers.y) return mix(sums.x, sums.y, (behind - uLayers.x) / (uLayers.y - uLayers.x));
  if (behind < uLayers.z) return mix(sums.y, sums.z, (behind - uLayers.y) / (uLayers.z - uLayers.y));
  return mix(sums.z, sums.w, min((behind - uLayers.z) / (uLayers.w - uLayers.z), 1.0));
}
// Optical depth of the snow between a point and the light of direction k. skin: snow of the point's own [m].
float depthTo(int k, vec3 p, float skin) {
  vec3 q = (p - uBall.xyz) / uBall.w;
  vec2 st = vec2(dot(q, uAcross[k]), dot(q, uAlong[k]));
  if (uMaps < 0.5 || max(abs(st.x), abs(st.y)) > 0.985) return 0.0;
  vec2 uv = cellOf(k, st);
  float front = k == SKIES ? texture(uSunDepth, uv).r : texture(uSkyDepth, uv).r;
  if (front > 0.9999) return 0.0;
  vec4 sums = k == SKIES ? texture(uSunDepths, uv) : texture(uSkyDepths, uv);
  float behind = (-dot(q, uDirection[k]) - (front * 2.0 - 1.0)) * uBall.w - skin;
  return layered(sums, behind);
}
// Share of the sun that the solids leave.
float pastSolids(vec3 p, vec3 normal) {
  vec3 q = (p + normal * 0.02 * uBall.w - uBall.xyz) / (2.0 * uBall.w);
  vec2 st = vec2(dot(q, uAcross[12]), dot(q, uAlong[12]));
  if (uMaps < 0.5 || max(abs(st.x), abs(st.y)) > 0.99) return 1.0;
  float here = min(0.5 - 0.5 * dot(q, uDirection[12]), 1.0);
  float seen = 0.0;
  vec2 texel = 1.0 / vec2(textureSize(uSolidDepth, 0));
  for (int i = 0; i < 4; ++i) {
    vec2 shift = (vec2(float(i % 2), float(i / 2)) - 0.5) * 1.5 * texel;
    seen += step(here - 0.002, texture(uSolidDepth, 0.5 * st + 0.5 + shift).r);
  }
  return 0.25 * seen;
}
float skyWeight(int k) { return k == 0 ? 0.30 : 0.14; }
`;

// Smooth noise with its slopes, octave by octave until a pixel is larger than its features.
const GLSL_GROUND = `
uniform float uDetail;  // most octaves
vec3 noise(vec2 at, uint seed) {
  vec2 f = floor(at), t = at - f;
  uvec2 i = uvec2(ivec2(f));
  vec2 s = t * t * t * (t * (6.0 * t - 15.0) + 10.0), d = 30.0 * t * t * (t - 1.0) * (t - 1.0);
  float c00 = 2.0 * unit(scramble(i.x * 0x9e3779b1u ^ scramble(i.y + seed))) - 1.0;
  float c10 = 2.0 * unit(scramble((i.x + 1u) * 0x9e3779b1u ^ scramble(i.y + seed))) - 1.0;
  float c01 = 2.0 * unit(scramble(i.x * 0x9e3779b1u ^ scramble(i.y + 1u + seed))) - 1.0;
  float c11 = 2.0 * unit(scramble((i.x + 1u) * 0x9e3779b1u ^ scramble(i.y + 1u + seed))) - 1.0;
  float low = mix(c00, c10, s.x), high = mix(c01, c11, s.x);
  return vec3(mix(low, high, s.y), d.x * mix(c10 - c00, c11 - c01, s.y), d.y * (high - low));
}
vec3 fractal(vec2 at, float size, int octaves, float gain, float pixel, uint seed) {
  vec3 sum = vec3(0.0);
  float weight = 1.0;
  for (int o = 0; o < octaves; ++o) {
    float fade = clamp(size / (2.0 * pixel) - 0.5, 0.0, 1.0);
    if (fade <= 0.0 || float(o) >= uDetail) break;
    vec3 n = noise(at / size, seed + uint(o));
    sum += fade * weight * n * vec3(1.0, 1.0 / size, 1.0 / size);
    weight *= gain;
    at = vec2(0.6 * at.y + 0.8 * at.x, 0.8 * at.y - 0.6 * at.x).xy;
    size *= 0.47;
  }
  return sum;
}
`;

export const SHADERS = {
  ...WATER_SHADERS,
  // Depth and optical depth of the snow seen from the lights: one instance for each direction.
  mapVertex: `
layout(location = 0) in vec3 aPlace;
uniform vec3 uLow, uStep;
uniform float uSize;
uniform int uFirst;
${GLSL_TILES}
out float vDepth;
void main() {
  int k = uFirst + gl_InstanceID;
  vec3 q = (uLow + uStep * aPlace - uBall.xyz) / uBall.w;
  vec2 st = vec2(dot(q, uAcross[k]), dot(q, uAlong[k]));
  float depth = -dot(q, uDirection[k]);
  vDepth = depth;
  bool in_ = max(abs(st.x), abs(st.y)) < 0.97 && abs(depth) < 1.0;
  gl_Position = in_ ? vec4(2.0 * cellOf(k, st) - 1.0, depth, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = uSize;
}`,
  mapFront: `void main() {}`,
  // Depth of the solids seen from the sun.
  shadowVertex: `
layout(location = 0) in vec3 aPlace;
uniform mat4 uModel;
uniform vec3 uScale;
${GLSL_TILES}
void main() {
  vec3 q = ((uModel * vec4(aPlace * uScale, 1.0)).xyz - uBall.xyz) / (2.0 * uBall.w);
  gl_Position = vec4(dot(q, uAcross[12]), dot(q, uAlong[12]), -dot(q, uDirection[12]), 1.0);
}`,
  mapSums: `
uniform sampler2D uFront;
uniform vec4 uBall, uLayers;
uniform float uWeight;
in float vDepth;
out vec4 color;
void main() {
  float front = texelFetch(uFront, ivec2(gl_FragCoord.xy), 0).r * 2.0 - 1.0;
  float behind = (vDepth - front) * uBall.w;
  color = uWeight * vec4(lessThan(vec4(behind), uLayers));
}`,
  // Light at each particle, one texel each: sun, sky, light that wandered through; the surface's normal.
  litVertex: `
layout(location = 0) in vec3 aPlace;
uniform vec3 uLow, uStep;
uniform vec2 uTable;
uniform float uCell;
${GLSL_MAPS}
out vec4 vLight, vNormal;
void main() {
  vec3 p = uLow + uStep * aPlace;
  vec3 sum = vec3(0.0, 0.0, 0.02);
  float open = 0.0;
  float passed[SKIES];
  for (int k = 0; k < SKIES; ++k) {
    passed[k] = exp(-0.55 * depthTo(k, p, 0.8 * uCell));
    sum += uDirection[k] * passed[k];
    open += passed[k] / float(SKIES);
  }
  vec3 normal = normalize(sum);
  float skyLight = 0.0, below = 0.0;
  for (int k = 0; k < 6; ++k)
    skyLight += skyWeight(k) * max((dot(normal, uDirection[k]) + 0.35) / 1.35, 0.0) * passed[k];
  for (int k = 6; k < SKIES; ++k) below += passed[k] / 6.0;
  float tau = depthTo(12, p, 0.5 * uCell);
  float near = min(tau, 2.2);
  float direct = exp(-0.42 * near - (tau - near)), through = exp(-0.38 * tau);
  float past = pastSolids(p, vec3(0.0));
  vLight = vec4(direct * past, 1.333 * skyLight, through * past, below * (0.5 - 0.5 * normal.z));
  vNormal = vec4(normal, open);
  int i = gl_VertexID;
  vec2 at = vec2(float(i % int(uTable.x)), float(i / int(uTable.x)));
  gl_Position = vec4((at + 0.5) / uTable * 2.0 - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}`,
  litFragment: `
in vec4 vLight, vNormal;
layout(location = 0) out vec4 light;
layout(location = 1) out vec4 normal;
void main() { light = vLight; normal = vNormal; }`,
  // Grains: each particle is a cluster of small lumps at fixed places around it.
  snowVertex: `
layout(location = 0) in vec3 aPlace;
layout(location = 1) in float aValue;
uniform vec3 uLow, uStep;
uniform mat4 uMatrix;
uniform vec3 uForward;
uniform float uSpacing, uFocal, uGrains, uSpread, uSize, uColored;
uniform vec4 uFloor;  // normal of the ground, and its height below the origin: what lies on it is drawn with it
uniform sampler2D uLight, uNormal;
${GLSL_COMMON}
out vec3 vSun, vAround, vNormal, vFacet;
out float vValue, vFar, vAlbedo, vWide, vWet;
flat out uint vSeed;
void main() {
  vec3 p = uLow + uStep * aPlace;
  uint seed = scramble(uint(gl_VertexID) * 16u + uint(gl_InstanceID));
  ivec2 texel = ivec2(gl_VertexID % 1024, gl_VertexID / 1024);
  vec4 light = texelFetch(uLight, texel, 0), shape = texelFetch(uNormal, texel, 0);
  float loose = smoothstep(0.62, 0.97, shape.w);
  uint a = scramble(seed + 1u), b = scramble(seed + 2u);
  float z = 2.0 * unit(a) - 1.0, turn = 6.2831853 * unit(b), out_ = pow(unit(scramble(seed + 3u)), 0.3333);
  vec3 offset = out_ * vec3(sqrt(1.0 - z * z) * vec2(cos(turn), sin(turn)), z);
  p += uSpread * uSpacing * offset;
  float u = unit(seed), uneven = 0.65 + 0.75 * u * u;
  float radius = uSize * 0.68 * uSpacing / pow(uGrains, 0.3333) * uneven * mix(1.0, 0.62, loose);
  vWet = uColored < 0.5 ? aValue / 65535.0 : 0.0;
  bool drop = vWet > 0.95;
  if (drop) {  // one smooth ball of about its water
    p -= uSpread * uSpacing * offset;
    radius = 0.30 * uSpacing * (0.6 + 0.5 * u);
  }
  gl_Position = uMatrix * vec4(p, 1.0);
  float depth = max(dot(p - uEye, uForward), 1e-4);
  // Close up a grain is no ball: its outline is uneven, within a sprite that is larger.
  vWide = smoothstep(3.0, 8.0, 2.0 * radius * uFocal / depth);
  gl_PointSize = clamp(2.0 * radius * (1.0 + 0.45 * vWide) * uFocal / depth, 1.3, 120.0);
  vSeed = seed;
  bool lost = aPlace.x + aPlace.y + aPlace.z > 196604.0;
  bool lies = dot(uFloor.xyz, p) + uFloor.w < 1.2 * uSpacing, soaks = shape.w < 0.85;
  if (lost || (drop && (lies || soaks || gl_InstanceID > 0))) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  vFacet = normalize(vec3(unit(scramble(seed + 4u)), unit(scramble(seed + 5u)), unit(scramble(seed + 6u))) - 0.5);
  vAlbedo = 0.90 + 0.08 * unit(scramble(seed + 7u));
  vNormal = normalize(shape.xyz);
  float skyLight = light.y, bright = skyLight / (1.0 - 0.60 * (1.0 - clamp(skyLight, 0.0, 1.0)));
  vSun = uSunColor * light.x;
  vAround = uSkyColor * vec3(0.68, 0.79, 0.94) * bright
    + (uSunColor * vec3(0.062, 0.074, 0.090) + uSkyColor * 0.16) * (1.0 - clamp(skyLight, 0.0, 1.0))
    + (uSunColor * (0.7 * max(uSun.z, 0.0)) + uSkyColor) * (0.20 * light.w)
    + uSunColor * vec3(0.72, 0.90, 1.0) * (0.14 * light.z);
  vValue = aValue;
  vFar = haze(depth);
}`,
  snowFragment: `
${GLSL_COMMON}
uniform vec3 uRight, uUp, uForward;
uniform sampler2D uPalette;
uniform float uColored;  // 0: snow, 1: amounts, 2: names
in vec3 vSun, vAround, vNormal, vFacet;
in float vValue, vFar, vAlbedo, vWide, vWet;
flat in uint vSeed;
out vec4 color;
float corner(uvec3 i) {
  return 2.0 * unit(scramble(i.x * 0x9e3779b1u ^ scramble(i.y * 0x85ebca6bu ^ scramble(i.z ^ vSeed)))) - 1.0;
}
// Smooth noise of a grain in [-1, 1] and its slopes: lumps that stay where they are on it when the camera turns.
vec4 lumps(vec3 at) {
  vec3 f = floor(at), t = at - f, s = t * t * (3.0 - 2.0 * t), d = 6.0 * t * (1.0 - t);
  uvec3 i = uvec3(ivec3(f));
  vec4 low = vec4(corner(i), corner(i + uvec3(1, 0, 0)), corner(i + uvec3(0, 1, 0)), corner(i + uvec3(1, 1, 0)));
  i.z += 1u;
  vec4 high = vec4(corner(i), corner(i + uvec3(1, 0, 0)), corner(i + uvec3(0, 1, 0)), corner(i + uvec3(1, 1, 0)));
  vec4 level = mix(low, high, s.z), rise = high - low;
  vec2 along = mix(level.xz, level.yw, s.x), up = mix(rise.xz, rise.yw, s.x);
  vec2 across = level.yw - level.xz;
  vec3 slope = d * vec3(mix(across.x, across.y, s.y), along.y - along.x, mix(up.x, up.y, s.y));
  return vec4(mix(along.x, along.y, s.y), slope);
}
vec3 named(float value) {
  if (value < 0.5) return vec3(0.50);
  float turn = fract(value * 0.61803399) * 6.2831853;
  return 0.42 + 0.34 * cos(turn + vec3(0.0, 2.1, 4.2));
}
${GLSL_WET_SNOW}
void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  float square = dot(at, at);
  if (square > 1.0) discard;
  vec3 round_ = uRight * at.x - uUp * at.y - uForward * sqrt(1.0 - square);
  vec3 toEye = -uForward, bump = vec3(0.0);
  if (vWide > 0.0 && vWet < 0.95) {
    vec3 rim_ = (uRight * at.x - uUp * at.y) * inversesqrt(max(square, 1e-6));
    float edge = 0.74 + 0.20 * lumps(1.1 * rim_).x + 0.09 * lumps(4.1 * rim_ + 3.0).x;
    if (square > mix(1.0, edge * edge, vWide)) discard;
    bump = -vWide * (0.16 * lumps(3.1 * round_ + 7.0).yzw + 0.10 * lumps(7.3 * round_).yzw);
  }
  vec3 normal = normalize(vNormal + round_ * mix(0.40, 0.22, vWide) + vFacet * mix(0.40, 0.30, vWide) + bump);
  float sun = max((dot(normal, uSun) + 0.12) / 1.12, 0.0);
  float rim = 0.80 + 0.20 * clamp(dot(round_, toEye), 0.0, 1.0);
  float open = 0.86 + 0.22 * dot(normal, vNormal) * (0.6 + 0.4 * normal.z);
  vec3 light = (vSun * sun + vAround * open) * (vAlbedo * rim);
  if (uColored > 0.5) {
    vec3 base = uColored > 1.5 ? named(vValue) : texture(uPalette, vec2(vValue / 65535.0, 0.5)).rgb;
    float shade = dot(light, vec3(0.3, 0.5, 0.2));
    light = base * base * (0.42 + 0.95 * shade);
  } else {
    float glint = dot(normalize(uSun + toEye), normalize(vFacet + vNormal * 0.8));
    float film_ = clamp(2.0 * vWet, 0.0, 1.0);
    light += vSun * (1.2 * smoothstep(0.985, 1.0, glint) * (1.0 - film_));
    if (vWet > 0.0) light = wet(light, film_, round_, toEye, glint);
  }
  color = vec4(film(mix(light, horizon(), vFar)), 1.0);
}`,
  skyVertex: `
out vec2 vAt;
void main() {
  vAt = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 4.0 - 1.0;
  gl_Position = vec4(vAt, 0.9999999, 1.0);
}`,
  skyFragment: `
${GLSL_COMMON}
uniform vec3 uRight, uUp, uForward;
uniform vec2 uTan;
uniform float uCovered;
in vec2 vAt;
out vec4 color;
void main() {
  vec3 ray = normalize(uForward + uRight * ((vAt.x + uCovered) * uTan.x) + uUp * (vAt.y * uTan.y));
  float dither = (unit(scramble(uint(gl_FragCoord.x) * 65536u + uint(gl_FragCoord.y))) - 0.5) / 255.0;
  color = vec4(film(sky(ray)) + dither, 1.0);
}`,
  bodyVertex: `
layout(location = 0) in vec3 aPlace;
layout(location = 1) in vec3 aNormal;
uniform mat4 uMatrix, uModel;
uniform vec3 uScale;
out vec3 vPoint, vNormal, vLocal;
void main() {
  vLocal = aPlace * uScale;
  vPoint = (uModel * vec4(vLocal, 1.0)).xyz;
  vNormal = mat3(uModel) * (aNormal / max(uScale, vec3(1e-6)));
  gl_Position = uMatrix * vec4(vPoint, 1.0);
}`,
  bodyFragment: `
${GLSL_COMMON}
${GLSL_MAPS}
${GLSL_GROUND}
uniform vec3 uColor, uGlow;
uniform mat4 uModel;
uniform float uGround, uPixel, uBound, uHalo;
in vec3 vPoint, vNormal, vLocal;
out vec4 color;
${GLSL_WET_GROUND}
void main() {
  vec3 toEye = uEye - vPoint, direction = -normalize(toEye);
  float distance_ = length(toEye), far = haze(distance_);
  vec3 flat_ = normalize(vNormal), normal = flat_, base = uColor;
  float pixel = distance_ * uPixel / sqrt(max(abs(dot(flat_, direction)), 0.15));
  if (uGround > 0.5) {
    vec3 drift = fractal(vLocal.xy, 0.60 * uReach, 6, 0.50, pixel, 11u);
    vec3 crust = fractal(vLocal.xy, 0.013 * uReach, 4, 0.75, pixel, 71u);
    float frost = smoothstep(-0.7, 1.25, drift.x + 0.40 * crust.x);
    base = mix(vec3(0.150, 0.138, 0.128), vec3(0.330, 0.348, 0.380), frost) * (1.0 + 0.15 * crust.x);
    vec3 bumped = normalize(vec3(-0.0011 * uReach * crust.yz, 1.0));
    normal = uGround > 1.5 ? normalize(flat_ + 0.3 * vec3(bumped.xy, 0.0)) : mat3(uModel) * bumped;
  } else {
    float size = 0.5 * min(uBound, 4.0);
    vec3 wear = fractal(vec2(vLocal.x + 0.37 * vLocal.z, vLocal.y + 0.71 * vLocal.z), size, 5, 0.6, pixel, 131u);
    base *= 1.0 + 0.10 * wear.x;
  }
  float lit = max(dot(normal, uSun), 0.0) * clamp(8.0 * dot(flat_, uSun), 0.0, 1.0);
  float arrives = exp(-depthTo(12, vPoint, 0.0)) * pastSolids(vPoint, flat_);
  float open = 0.0;
  for (int k = 0; k < 6; ++k)
    open += skyWeight(k) * max((dot(flat_, uDirection[k]) + 0.35) / 1.35, 0.0) * exp(-0.55 * depthTo(k, vPoint, 0.0));
  open = 1.333 * open;
  vec3 light = base * uSunColor * (lit * arrives) + base * uSkyColor * mix(0.14, open, clamp(open, 0.0, 1.0));
  light += base * uSunColor * (0.10 * (1.0 - abs(flat_.z)));
  if (uGround < 0.5) {
    vec3 half_ = normalize(uSun - direction);
    light += uSunColor * (0.12 * arrives * step(0.001, lit) * pow(clamp(dot(normal, half_), 0.0, 1.0), 40.0));
  }
  if (uGround > 0.5 && uGround < 1.5) light = wetGround(light, flat_, direction, pixel, open, arrives);
  light += uGlow * (0.25 + 0.75 * pow(1.0 - abs(dot(flat_, direction)), 2.0));
  light = mix(light, sky(normalize(vec3(direction.xy, 0.0001))), far);
  float dither = (unit(scramble(uint(gl_FragCoord.x) * 65536u + uint(gl_FragCoord.y))) - 0.5) / 255.0;
  color = vec4(film(light) + dither, 1.0);
}`,
  // Plain colour: gizmo and pointer ring.
  plainVertex: `
layout(location = 0) in vec3 aPlace;
uniform mat4 uMatrix;
void main() { gl_Position = uMatrix * vec4(aPlace, 1.0); }`,
  plainFragment: `
uniform vec3 uColor;
out vec4 color;
void main() { color = vec4(uColor, 1.0); }`,
};

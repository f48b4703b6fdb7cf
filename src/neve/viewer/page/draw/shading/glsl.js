// What all shaders share: random bits, the sky, the film's curve, and how much light passes the snow.
// The light is that of the film (core/render): the same sun, sky, albedo and tone curve. Where the film walks through a
// density grid, the page asks deep opacity maps (Yuksel and Keyser 2008): for each of 13 directions the depth at which
// snow begins and the optical depth of what follows, in four layers.

import { GLSL_TILES } from "./water_shaders.js";

export const GLSL_HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
`;

export const GLSL_COMMON = `
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

// Grains: each particle is a cluster of small lumps at fixed places around it.
export const GLSL_GRAIN = `
// skip: of so many particles one is drawn; a particle keeps its grains.
uint seedOf(float skip) { return scramble(uint(gl_VertexID) * uint(skip) * 16u + uint(gl_InstanceID)); }
vec3 scattered(uint seed) {
  float z = 2.0 * unit(scramble(seed + 1u)) - 1.0, turn = 6.2831853 * unit(scramble(seed + 2u));
  float out_ = pow(unit(scramble(seed + 3u)), 0.3333);
  return out_ * vec3(sqrt(1.0 - z * z) * vec2(cos(turn), sin(turn)), z);
}
// A turn by chance: of a quaternion (Shoemake 1992, Uniform random rotations).
mat3 turned(uint seed) {
  float u = unit(scramble(seed + 4u)), a = 6.2831853 * unit(scramble(seed + 5u)), b = 6.2831853 * unit(scramble(seed + 6u));
  vec4 q = vec4(sqrt(1.0 - u) * vec2(sin(a), cos(a)), sqrt(u) * vec2(sin(b), cos(b)));
  vec3 x = 2.0 * q.x * q.xyz, y = 2.0 * q.y * q.xyz, w = 2.0 * q.w * q.xyz;
  float zz = 2.0 * q.z * q.z;
  return mat3(1.0 - y.y - zz, x.y + w.z, x.z - w.y, x.y - w.z, 1.0 - x.x - zz, y.z + w.x, x.z + w.y, y.z - w.x, 1.0 - x.x - y.y);
}
`;

export const GLSL_MAPS = `
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
export const GLSL_GROUND = `
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

// From the distance ahead to the depth in the picture.
export const GLSL_LENS = `
uniform vec2 uLens;  // of the projection: depth in the picture = (x d + y) / d
float lensDepth(float depth) { return clamp(0.5 + 0.5 * (uLens.x * depth + uLens.y) / depth, 0.0, 1.0); }
`;

// A point as a ball.
export const GLSL_BALL = `
// How high it rises there over its middle, in radii; beside it nothing is drawn.
float ballHeight(vec2 at) {
  float square = dot(at, at);
  if (square > 1.0) discard;
  return sqrt(1.0 - square);
}
`;

// A broken grain: a ball cut by the twelve planes of a dodecahedron, each at a distance of its own.
export const GLSL_CHUNK = `
// How high it rises over its middle along \`ahead\`, beside it by \`aside\`, where the ball rises \`up\` [radii].
float chunkHeight(float up, mat3 turn, vec3 aside, vec3 ahead, vec4 cut[3]) {
  const vec3 faces[6] = vec3[6](vec3(0.0, 0.850651, 0.525731), vec3(0.0, -0.850651, 0.525731), vec3(0.525731, 0.0, 0.850651),
    vec3(0.525731, 0.0, -0.850651), vec3(0.850651, 0.525731, 0.0), vec3(-0.850651, 0.525731, 0.0));
  vec3 o = aside * turn, v = ahead * turn;
  float low = -up;
  for (int k = 0; k < 6; ++k) {
    float s = dot(faces[k], o), c = dot(faces[k], v);
    vec2 ends = k % 2 == 0 ? cut[k / 2].xy : cut[k / 2].zw;
    float safe = abs(c) < 1e-4 ? 1e-4 : c;
    vec2 t = vec2(ends.x - s, -ends.y - s) / safe;
    up = min(up, max(t.x, t.y));
    low = max(low, min(t.x, t.y));
  }
  if (up < low) discard;
  return up;
}
`;

// Where what a picture's depths say is, and how it slopes.
export const GLSL_PLACE = `
${GLSL_LENS}
uniform vec3 uRight, uUp, uForward;
uniform vec2 uTan, uPixel_;
uniform float uCovered, uSpacing, uFocal, uEdge;
uniform sampler2D uPlace;
in vec2 vAt;
vec3 rayAt(vec2 uv) {
  vec2 at = 2.0 * uv - 1.0;
  return uForward + uRight * ((at.x + uCovered) * uTan.x) + uUp * (at.y * uTan.y);
}
float depthAt(vec2 uv) { return textureLod(uPlace, uv, 0.0).x; }
// Change of the place along one axis of the picture: from both sides, or, at an edge, from the one nearer in depth.
vec3 slope(vec2 way, vec3 here, float depth) {
  float a = depthAt(vAt + way), b = depthAt(vAt - way);
  if (a > 0.0 && b > 0.0 && max(abs(a - depth), abs(b - depth)) < uEdge)
    return 0.5 * (rayAt(vAt + way) * a - rayAt(vAt - way) * b);
  bool first = b <= 0.0 || (a > 0.0 && abs(a - depth) < abs(b - depth));
  float d = first ? a : b, sign_ = first ? 1.0 : -1.0;
  if (d <= 0.0) d = depth;
  return sign_ * (rayAt(vAt + sign_ * way) * d - here);
}
vec3 normalAt(vec3 here, float depth) {
  vec3 n = normalize(cross(slope(vec2(uPixel_.x, 0.0), here, depth), slope(vec2(0.0, uPixel_.y), here, depth)));
  return dot(n, here) > 0.0 ? -n : n;
}
`;

// The shaders of the page; glsl.js has what they share.

import { GLSL_COMMON, GLSL_GRAIN, GLSL_GROUND, GLSL_MAPS } from "./glsl.js";
import { GLSL_TILES, GLSL_WET_GROUND, GLSL_WET_SNOW, WATER_SHADERS } from "./water_shaders.js";

export const SHADERS = {
  ...WATER_SHADERS,
  // Depth and optical depth of the snow seen from the lights: one instance for each direction.
  mapVertex: `
layout(location = 0) in vec3 aPlace;
uniform vec3 uLow, uStep;
uniform float uSize;
uniform int uFirst;
uniform vec4 uClip;
${GLSL_TILES}
out float vDepth;
void main() {
  int k = uFirst + gl_InstanceID;
  vec3 q = (uLow + uStep * aPlace - uBall.xyz) / uBall.w;
  vec2 st = vec2(dot(q, uAcross[k]), dot(q, uAlong[k]));
  float depth = -dot(q, uDirection[k]);
  vDepth = depth;
  bool in_ = max(abs(st.x), abs(st.y)) < 0.97 && abs(depth) < 1.0
    && dot(uClip.xyz, uLow + uStep * aPlace) + uClip.w <= 0.0;
  gl_Position = in_ ? vec4(2.0 * cellOf(k, st) - 1.0, depth, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = uSize;
}`,
  mapFront: `void main() {}`,
  // Depth of the solids seen from the sun.
  shadowVertex: `
layout(location = 0) in vec3 aPlace;
uniform mat4 uModel;
uniform vec3 uScale;
uniform vec4 uClip;
${GLSL_TILES}
out float vBeyond;
void main() {
  vec3 p = (uModel * vec4(aPlace * uScale, 1.0)).xyz;
  vBeyond = dot(uClip.xyz, p) + uClip.w;
  vec3 q = (p - uBall.xyz) / (2.0 * uBall.w);
  gl_Position = vec4(dot(q, uAcross[12]), dot(q, uAlong[12]), -dot(q, uDirection[12]), 1.0);
}`,
  shadowFront: `
in float vBeyond;
void main() { if (vBeyond > 0.0) discard; }`,
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
  snowVertex: `
layout(location = 0) in vec3 aPlace;
layout(location = 1) in float aValue;
uniform vec3 uLow, uStep;
uniform mat4 uMatrix;
uniform vec3 uForward;
uniform float uSpacing, uFocal, uGrains, uSpread, uSize, uColored, uSkip;
uniform vec4 uClip;   // what lies beyond this plane is cut away
uniform vec4 uFloor;  // normal of the ground, and its height below the origin: what lies on it is drawn with it
uniform sampler2D uLight, uNormal;
${GLSL_COMMON}
${GLSL_GRAIN}
out vec3 vSun, vAround, vNormal, vFacet;
out float vValue, vFar, vAlbedo, vWide, vWet;
flat out uint vSeed;
void main() {
  vec3 p = uLow + uStep * aPlace;
  uint seed = seedOf(uSkip);
  ivec2 texel = ivec2(gl_VertexID % 1024, gl_VertexID / 1024);
  vec4 light = texelFetch(uLight, texel, 0), shape = texelFetch(uNormal, texel, 0);
  float loose = smoothstep(0.62, 0.97, shape.w);
  vec3 offset = scattered(seed);
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
  float beyond = dot(uClip.xyz, p) + uClip.w;
  if (beyond > 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  float cap = dot(uClip.xyz, uClip.xyz) * smoothstep(1.5 * uSpacing, 0.5 * uSpacing, -beyond);
  vNormal = normalize(mix(shape.xyz, uClip.xyz, cap));
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
#ifdef CUT
uniform vec4 uClip;
uniform mat4 uMatrix;
uniform float uCap;  // 1: not the back of the solid, but where the ray to it enters through the plane
#endif
void main() {
  vec3 point = vPoint, local = vLocal, flat_ = normalize(vNormal), base = uColor;
#ifdef CUT
  gl_FragDepth = gl_FragCoord.z;
  if (uGround < 0.5 && dot(uClip.xyz, vPoint) + uClip.w > 0.0) discard;
  if (uCap > 0.5) {
    if (gl_FrontFacing) discard;
    vec3 ray = vPoint - uEye;
    point = uEye - ray * ((dot(uClip.xyz, uEye) + uClip.w) / dot(uClip.xyz, ray));
    local = (point - uModel[3].xyz) * mat3(uModel);
    vec4 at = uMatrix * vec4(point, 1.0);
    gl_FragDepth = clamp(0.5 + 0.5 * at.z / at.w, 0.0, 1.0);
    flat_ = uClip.xyz;
    base = mix(uColor, vec3(dot(uColor, vec3(0.333))), 0.35);
  }
#endif
  vec3 toEye = uEye - point, direction = -normalize(toEye);
  float distance_ = length(toEye), far = haze(distance_);
  vec3 normal = flat_;
  float pixel = distance_ * uPixel / sqrt(max(abs(dot(flat_, direction)), 0.15));
  if (uGround > 0.5) {
    vec3 drift = fractal(local.xy, 0.60 * uReach, 6, 0.50, pixel, 11u);
    vec3 crust = fractal(local.xy, 0.013 * uReach, 4, 0.75, pixel, 71u);
    float frost = smoothstep(-0.7, 1.25, drift.x + 0.40 * crust.x);
    base = mix(vec3(0.150, 0.138, 0.128), vec3(0.330, 0.348, 0.380), frost) * (1.0 + 0.15 * crust.x);
    vec3 bumped = normalize(vec3(-0.0011 * uReach * crust.yz, 1.0));
    normal = uGround > 1.5 ? normalize(flat_ + 0.3 * vec3(bumped.xy, 0.0)) : mat3(uModel) * bumped;
  } else {
    float size = 0.5 * min(uBound, 4.0);
    vec3 wear = fractal(vec2(local.x + 0.37 * local.z, local.y + 0.71 * local.z), size, 5, 0.6, pixel, 131u);
    base *= 1.0 + 0.10 * wear.x;
  }
  float lit = max(dot(normal, uSun), 0.0) * clamp(8.0 * dot(flat_, uSun), 0.0, 1.0);
  float arrives = exp(-depthTo(12, point, 0.0)) * pastSolids(point, flat_);
  float open = 0.0;
  for (int k = 0; k < 6; ++k)
    open += skyWeight(k) * max((dot(flat_, uDirection[k]) + 0.35) / 1.35, 0.0) * exp(-0.55 * depthTo(k, point, 0.0));
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
  // What a plane leaves of a solid, to be counted.
  cutFaces: `
uniform vec4 uClip;
in vec3 vPoint;
void main() { if (dot(uClip.xyz, vPoint) + uClip.w > 0.0) discard; }`,
  // Plain colour: gizmo and pointer ring.
  plainVertex: `
layout(location = 0) in vec3 aPlace;
uniform mat4 uMatrix;
void main() { gl_Position = uMatrix * vec4(aPlace, 1.0); }`,
  plainFragment: `
uniform vec4 uColor;
out vec4 color;
void main() { color = uColor; }`,
};

// The shaders of flakes in the air. Their law is that of the film (src/neve/render/falling.py), its constants come from
// there with the scene; tests/viewer/browser/test_flakes.py holds the flakes of both against each other, pixel by pixel.

import { GLSL_COMMON } from "./glsl.js";

export const FALLING_SHADERS = {
  // One instance for each flake, whose four corners stand around its way while the shutter is open.
  vertex: `
uniform mat4 uMatrix;
uniform vec3 uForward, uVelocity;
uniform vec2 uSize;                // of the picture [px]
uniform vec2 uPace, uSpread_;      // least and range of speeds, and of radii, over the average
uniform vec4 uNumbers;             // of a flake's random numbers: for place, pace, phase and radius
uniform float uEdge, uAround, uTime, uOpen, uRadius, uSway, uPeriod, uSecond, uFocal, uLeast, uFaintest, uNearest;
${GLSL_COMMON}
flat out vec4 vWay;                // where it begins and ends [px]
flat out float vWide, vCover;
out vec2 vAt;

// A random number in [0, 1) of a name, another for each k: as the film has it (neve.render.path_tracing.snow).
float chance(uint name, float k) { return unit(scramble(name + (uint(k) + 1u) * 0x9e3779b1u)); }
vec3 swing(float phase, float pace, float time) {
  float turn = phase + 6.2831853 * time / (uPeriod * pace);
  return uSway * vec3(sin(turn), cos(uSecond * turn + phase), 0.0);
}
vec2 seen(vec3 p, out float depth, out float far) {
  vec4 at = uMatrix * vec4(p, 1.0);
  depth = at.z / at.w;
  far = dot(p - uEye, uForward);
  return (0.5 + 0.5 * at.xy / at.w) * uSize;
}
void main() {
  uint name = uint(gl_InstanceID);
  vec3 home = uEdge * vec3(chance(name, uNumbers.x), chance(name, uNumbers.x + 1.0), chance(name, uNumbers.x + 2.0));
  float pace = uPace.x + uPace.y * chance(name, uNumbers.y), phase = 6.2831853 * chance(name, uNumbers.z);
  float begun = uTime - 0.5 * uOpen;
  vec3 velocity = uVelocity * pace, corner = uEye - 0.5 * uEdge;
  vec3 first = corner + mod(home + velocity * begun - corner, uEdge);
  vec3 off = abs(first - uEye);
  bool near_ = max(off.x, max(off.y, off.z)) < uAround;
  vec3 last = first + velocity * uOpen + swing(phase, pace, begun + uOpen);
  first += swing(phase, pace, begun);
  float depth, behind, far, farther;
  vec2 a = seen(first, depth, far), b = seen(last, behind, farther);
  float radius = uRadius * (uSpread_.x + uSpread_.y * chance(name, uNumbers.w)) * uFocal / max(far, uNearest);
  float way = length(b - a);
  vWide = max(radius, uLeast);
  vCover = 3.1415927 * radius * radius / (3.1415927 * vWide * vWide + 2.0 * vWide * way);
  vWay = vec4(a, b);
  vec2 along = way > 1e-4 ? (b - a) / way : vec2(1.0, 0.0), across = vec2(-along.y, along.x);
  float side = float(gl_VertexID % 2) * 2.0 - 1.0, end = float(gl_VertexID / 2) * 2.0 - 1.0;
  vAt = (end < 0.0 ? a : b) + (vWide + 1.0) * (end * along + side * across);
  bool shown = near_ && far > uNearest && farther > uNearest && vCover > uFaintest;
  gl_Position = shown ? vec4(2.0 * vAt / uSize - 1.0, depth, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}`,
  fragment: `
uniform vec3 uGlow;
${GLSL_COMMON}
flat in vec4 vWay;
flat in float vWide, vCover;
in vec2 vAt;
out vec4 color;
void main() {
  vec2 way = vWay.zw - vWay.xy, from = vAt - vWay.xy;
  float t = clamp(dot(from, way) / max(dot(way, way), 1e-12), 0.0, 1.0);
  float share = clamp(vWide - length(from - t * way) + 0.5, 0.0, 1.0);
  color = vec4(film(uGlow), vCover * share);
}`,
};

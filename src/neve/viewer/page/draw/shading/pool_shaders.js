// Standing water: one smooth surface that mirrors the sky and bends the light of what lies below it.

import { GLSL_BALL, GLSL_COMMON, GLSL_LENS, GLSL_MAPS, GLSL_PLACE } from "./glsl.js";

export const POOL = {
  // A ball for each particle, so large that no gap is left between them.
  vertex: `
layout(location = 0) in vec3 aPlace;
uniform vec3 uLow, uStep, uForward, uEye;
uniform mat4 uMatrix;
uniform float uSpacing, uFocal;
uniform vec4 uClip;
out float vDepth, vRadius;
void main() {
  vec3 p = uLow + uStep * aPlace;
  vRadius = 0.75 * uSpacing;
  vDepth = max(dot(p - uEye, uForward), 1e-4);
  gl_Position = uMatrix * vec4(p, 1.0);
  gl_PointSize = clamp(2.0 * vRadius * uFocal / vDepth, 1.6, 160.0);
  if (dot(uClip.xyz, p) + uClip.w > 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`,
  first: `
${GLSL_LENS}
${GLSL_BALL}
in float vDepth, vRadius;
layout(location = 0) out vec4 place;
layout(location = 1) out vec4 light;
layout(location = 2) out vec4 grain;
void main() {
  float depth = vDepth - vRadius * ballHeight(2.0 * gl_PointCoord - 1.0);
  gl_FragDepth = lensDepth(depth);
  place = vec4(depth, vRadius, 0.0, 1.0);
  light = grain = vec4(0.0);
}`,
  // How much water a ray passes through [m]: a ball holds the water of a cube of one spacing.
  thick: `
${GLSL_BALL}
in float vDepth, vRadius;
uniform float uSpacing;
out vec4 color;
void main() {
  float ball = 4.18879 * vRadius * vRadius * vRadius;
  color = vec4(2.0 * vRadius * ballHeight(2.0 * gl_PointCoord - 1.0) * uSpacing * uSpacing * uSpacing / ball);
}`,
  shade: `
${GLSL_COMMON}
${GLSL_PLACE}
${GLSL_MAPS}
uniform sampler2D uThick, uBehind;
out vec4 color;
const vec3 LOST = vec3(3.4, 1.25, 0.95);  // of light, along a metre of water
// The light that a colour of the picture stands for.
vec3 lightOf(vec3 seen) {
  vec3 e = mix(seen / 12.92, pow((seen + 0.055) / 1.055, vec3(2.4)), step(0.04045, seen));
  return pow(-log(max(1.0 - e, 0.02)) / 1.05, vec3(1.0 / 1.15));
}
void main() {
  float depth = depthAt(vAt), thick = textureLod(uThick, vAt, 0.0).x;
  if (depth <= 0.0) discard;
  gl_FragDepth = lensDepth(depth);
  vec3 here = rayAt(vAt) * depth, along = normalize(here), normal = normalAt(here, depth);
  float facing = clamp(-dot(normal, along), 0.05, 1.0), slant = 1.0 - facing;
  float mirror = 0.02 + 0.98 * slant * slant * slant * slant * slant;  // Schlick 1994, water in air
  vec3 back = reflect(along, normal);
  // What is mirrored from below the horizon is the ground around, in shade.
  vec3 around = mix(0.25 * horizon(), sky(back), smoothstep(-0.1, 0.05, back.z));
  // The bent ray leaves the water on the ground that the straight one meets: it is as long as the depth there asks.
  vec3 bent = refract(along, normal, 0.75);
  float way = thick * facing / max(-dot(normal, bent), 0.05);
  vec3 end = here + bent * way;
  vec2 at = vec2(dot(end, uRight), dot(end, uUp)) / (max(dot(end, uForward), 1e-4) * uTan) - vec2(uCovered, 0.0);
  vec3 behind = lightOf(textureLod(uBehind, 0.5 + 0.5 * at, 0.0).rgb);
  vec3 kept = exp(-LOST * way);
  float arrives = exp(-depthTo(12, uEye + here, 0.0)) * pastSolids(uEye + here, normal);
  vec3 deep = vec3(0.020, 0.075, 0.095) * (uSunColor * max(uSun.z, 0.0) * arrives + uSkyColor);
  float covers = 1.0 - exp(-4.0 * thick / uSpacing);  // thin edges fade
  float glint = 4.0 * arrives * covers * covers * pow(clamp(dot(back, uSun), 0.0, 1.0), 400.0);
  vec3 light = mix(mix(deep, behind, kept), around, mirror) + uSunColor * glint;
  color = vec4(film(mix(light, horizon(), haze(depth))), covers);
}`,
};

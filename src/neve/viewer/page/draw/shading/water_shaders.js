// Melt water, drawn as in the film (core/render/puddle.hpp, snow.hpp): wet snow, drops, and wet ground.

const WATER = "62258.0"; // value from which a particle is water: 0.95 of 65535

export const GLSL_TILES = `
const int SKIES = 12;
uniform vec3 uDirection[13], uAcross[13], uAlong[13];  // 0..11 the sky and below, 12 the sun
uniform vec4 uBall;  // centre and radius of the snow [m]
vec2 cellOf(int k, vec2 st) {
  return k == SKIES ? 0.5 * st + 0.5 : (vec2(float(k % 4), float(k / 4)) + 0.5 * st + 0.5) / vec2(4.0, 3.0);
}
`;

export const GLSL_WET_GROUND = `
uniform sampler2D uWater;  // depth of melt water seen from above, in depths at which ground is wet
// How wet a place below the snow and beside it is, 0 to 1.
float wetness(vec3 p) {
  vec3 q = (p - uBall.xyz) / uBall.w;
  vec2 st = vec2(dot(q, uAcross[0]), dot(q, uAlong[0]));
  if (uMaps < 0.5 || max(abs(st.x), abs(st.y)) > 0.985) return 0.0;
  return 1.0 - exp(-texture(uWater, 0.5 * st + 0.5).r);
}
// Light of ground that shines so, wet as it is: dark, and a mirror of the sky where water stands.
vec3 wetGround(vec3 light, vec3 normal, vec3 direction, float pixel, float open, float arrives) {
  float wet = wetness(vPoint);
  if (wet < 0.001) return light;
  float film_ = smoothstep(0.35, 0.75, wet - 0.25 * fractal(vLocal.xy, 0.05 * uReach, 4, 0.6, pixel, 907u).x);
  float slant = 1.0 - clamp(-dot(normal, direction), 0.0, 1.0);
  float mirror = film_ * (0.02 + 0.98 * slant * slant * slant * slant * slant);
  float shine = pow(clamp(dot(normal, normalize(uSun - direction)), 0.0, 1.0), 220.0);
  vec3 dark = light * mix(vec3(1.0), vec3(0.42, 0.41, 0.42), clamp(1.7 * wet, 0.0, 1.0)) * (1.0 - mirror);
  return dark + sky(reflect(direction, normal)) * (mirror * open) + uSunColor * (1.5 * shine * film_ * arrives);
}
`;

export const GLSL_WET_SNOW = `
// Light of wet snow, or of a drop of water, as in the film.
vec3 wet(vec3 dry, float film_, vec3 round_, vec3 toEye, float glint) {
  vec3 normal = normalize(vNormal + round_ * (vWet > 0.95 ? 2.0 : 0.12));
  float sun = max((dot(normal, uSun) + 0.12) / 1.12, 0.0);
  float shine = pow(max(dot(normal, normalize(uSun + toEye)), 0.0), 50.0);
  float slant = 1.0 - clamp(dot(normal, toEye), 0.0, 1.0), mirror = 0.02 + 0.98 * slant * slant * slant * slant * slant;
  if (vWet > 0.95) {
    vec3 ground_ = vec3(0.10, 0.10, 0.11) * (uSunColor * max(uSun.z, 0.0) + uSkyColor);
    return ground_ + sky(reflect(-toEye, normal)) * mirror + vSun * (1.5 * shine);
  }
  vec3 slush = vWet < 0.3333 ? mix(vec3(1.0), vec3(0.78, 0.82, 0.84), 3.0 * vWet)
                             : mix(vec3(0.78, 0.82, 0.84), vec3(0.47, 0.56, 0.61), 1.5 * vWet - 0.5);
  vec3 smooth_ = (vSun * sun + vAround) * 0.92;
  return mix(dry, smooth_, film_) * slush + (vAround * (0.6 * mirror) + vSun * (0.35 * shine)) * film_;
}
`;

export const WATER_SHADERS = {
  // Melt water seen from above: each particle of it is a soft disc.
  waterVertex: `
layout(location = 0) in vec3 aPlace;
layout(location = 1) in float aValue;
uniform vec3 uLow, uStep;
uniform float uSize;
${GLSL_TILES}
void main() {
  vec3 q = (uLow + uStep * aPlace - uBall.xyz) / uBall.w;
  vec2 st = vec2(dot(q, uAcross[0]), dot(q, uAlong[0]));
  gl_Position = aValue > ${WATER} && max(abs(st.x), abs(st.y)) < 0.97 ? vec4(st, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = uSize;
}`,
  waterSums: `
uniform float uWeight;
out vec4 color;
void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  color = vec4(2.0 * uWeight * max(1.0 - dot(at, at), 0.0), 0.0, 0.0, 0.0);
}`,
};

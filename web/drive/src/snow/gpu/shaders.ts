import { DENSEST, PACKED_RATIO, PACKED_STEEPER } from "../law";
import { RIM_REACH, STAMPS } from "../footprint";
import { TILE } from "../window/tiles";

/** Rectangles that one draw can cover. */
export const RECTS = 32;
/** Texels of the coarse lattice of the cover along a tile, and their distance in texels of snow. */
export const COVER_STEP = 8;
export const COVER_SIDE = TILE / COVER_STEP + 1;
/** Sums are first made by so many lanes for each stamp, then over the lanes. */
export const LANES = 64;

const f = (value: number) => value.toFixed(6);

/** Quads that cover rectangles of the target [texels] exactly; each has two numbers for its fragments. */
export const VERTEX = `
precision highp float;
in vec2 position;
uniform vec2 target;
uniform vec4 rects[${RECTS}];
uniform vec2 extras[${RECTS}];
flat out vec2 extra;
void main() {
  vec4 rect = rects[gl_InstanceID];
  extra = extras[gl_InstanceID];
  gl_Position = vec4(mix(rect.xy, rect.zw, position) / target * 2.0 - 1.0, 0.0, 1.0);
}`;

/** "Local" texels count from the least corner of the window; "slots" are where they lie in the texture. */
const HEAD = `
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D snow;
uniform sampler2D bed;       // (height of the ground [m], cover) for each texel
uniform ivec2 corner;        // slot of the least texel
uniform int mask;            // resolution - 1
uniform float texel;
uniform float depth;         // fresh depth of the settings [m]
flat in vec2 extra;
ivec2 localOf(ivec2 slot) { return (slot - corner) & mask; }
ivec2 slotOf(ivec2 local) { return (local + corner) & mask; }
ivec2 here() { return ivec2(gl_FragCoord.xy); }
`;

/** Ground and cover of tiles that entered. The cover comes from a lattice that the processor made. */
export const bedShader = (ground: string) => `${HEAD}
${ground}
uniform sampler2D cover;
uniform vec2 origin;         // least corner of the window [m]
out vec2 result;
void main() {
  ivec2 slot = here();
  ivec2 at = slot & ${TILE - 1};
  vec2 place = (vec2(at) + 0.5) / ${f(COVER_STEP)};
  ivec2 cell = ivec2(place);
  vec2 t = place - vec2(cell);
  ivec2 base = (slot / ${TILE}) * ${COVER_SIDE} + cell;
  float a = mix(texelFetch(cover, base, 0).r, texelFetch(cover, base + ivec2(1, 0), 0).r, t.x);
  float b = mix(texelFetch(cover, base + ivec2(0, 1), 0).r, texelFetch(cover, base + ivec2(1, 1), 0).r, t.x);
  result = vec2(groundHeight(origin + (vec2(localOf(slot)) + 0.5) * texel), mix(a, b, t.y));
}`;

export const FRESH = `${HEAD}
out vec2 result;
void main() { result = vec2(depth * texelFetch(bed, here(), 0).y); }`;

/** A copy, without the sign that STAMP gives to the mass. */
export const COPY = `${HEAD}
out vec2 result;
void main() { result = abs(texelFetch(snow, here(), 0).xy); }`;

/** Every depth times extra.x: when the fresh depth of the settings changes. */
export const SCALE = `${HEAD}
out vec2 result;
void main() { result = texelFetch(snow, here(), 0).xy * extra.x; }`;

/** law.ts: recover, with extra = (gain, fall). */
export const RECOVER = `${HEAD}
out vec2 result;
void main() {
  vec2 s = texelFetch(snow, here(), 0).xy;
  float fresh = depth * texelFetch(bed, here(), 0).y;
  s += (fresh - s) * extra.x;
  result = s + min(extra.y, max(0.0, fresh - s.x));
}`;

/** The underside of the stamps, what they press and where their rims go. */
const STAMP_HEAD = `${HEAD}
uniform vec4 stamps[${4 * STAMPS}];
uniform int count;
uniform float compaction;
const float NOWHERE = 1e9;

// The part of 0..1 in which |q - s dq| <= r; empty where x > y.
vec2 within(float q, float dq, float r) {
  if (abs(dq) < 1e-6) return abs(q) <= r ? vec2(0.0, 1.0) : vec2(1.0, 0.0);
  float a = (q - r) / dq, b = (q + r) / dq;
  return vec2(max(0.0, min(a, b)), min(1.0, max(a, b)));
}
vec2 turned(vec2 axis, vec2 d) { return vec2(dot(axis, d), axis.x * d.y - axis.y * d.x); }

// Height of the underside of stamp i over a place, the least while it came from where it was (s = 1) to where it is
// (s = 0); NOWHERE beside it.
float underside(int i, vec2 place) {
  vec4 at = stamps[4 * i], shape = stamps[4 * i + 1], motion = stamps[4 * i + 2], more = stamps[4 * i + 3];
  vec2 q = turned(shape.xy, place - at.xz);
  vec2 dq = turned(shape.xy, motion.xz);
  vec2 u = within(q.x, dq.x, shape.z), v = within(q.y, dq.y, shape.w);
  vec2 span = vec2(max(u.x, v.x), min(u.y, v.y));
  if (span.x > span.y) return NOWHERE;
  if (at.w < 0.5) {
    vec2 p = q - span.x * dq, r = q - span.y * dq;
    return at.y + min(span.x * motion.y + dot(more.xy, p), span.y * motion.y + dot(more.xy, r));
  }
  float s = abs(dq.x) < 1e-6 ? span.x : clamp(q.x / dq.x, span.x, span.y);
  vec2 p = q - s * dq;
  float curve = more.x, over = min(curve, max(0.0, abs(p.y) - (shape.w - curve)));
  float shoulder = curve - sqrt(curve * curve - over * over);
  return at.y + s * motion.y + shoulder - sqrt(max(0.0, shape.z * shape.z - p.x * p.x));
}

// Of stamp i, how much of its rims a place gets, before the sums are divided out: beside it, behind it. A lobe rises
// from the edge of the footprint and dies away before RIM_REACH.
float lobe(float d, float s) { return d > 0.0 ? d * exp(-d / s) : 0.0; }
vec2 rim(int i, vec2 place) {
  vec4 at = stamps[4 * i], shape = stamps[4 * i + 1], motion = stamps[4 * i + 2];
  vec2 d = place - at.xz;
  float long2 = dot(motion.xz, motion.xz);
  d -= motion.xz * (long2 > 0.0 ? clamp(dot(d, motion.xz) / long2, 0.0, 1.0) : 0.0);
  vec2 q = turned(shape.xy, d);
  // Outside the bounds over which the sums are made there must be nothing.
  if (length(max(vec2(0.0), abs(q) - shape.zw)) > ${f(RIM_REACH)}) return vec2(0.0);
  float straight = at.w < 0.5 ? shape.z : 0.0, fade = at.w < 0.5 ? 0.15 : 0.55 * shape.z;
  float along = max(0.0, abs(q.x) - straight) / fade, across = max(0.0, abs(q.y) / shape.w - 0.5) * 2.0;
  return vec2(lobe(abs(q.y) - shape.w, 0.05) * exp(-along * along),
              lobe(-motion.w * q.x - shape.z, 0.06) * exp(-across * across));
}

vec2 placeOf(ivec2 local) { return (vec2(local) + 0.5) * texel; }

// law.ts: press and densestDepth.
vec2 pressed(vec2 s, float to) {
  if (to >= s.x || s.x <= 1e-6) return s;
  float ratio = max(1.0, s.y / s.x);
  // Rounding must not let the densest snow yield a little at each press.
  if (ratio >= ${f(DENSEST)} * 0.9999) return s;
  float h = max(to, s.x * pow(ratio / ${f(DENSEST)}, 1.0 / compaction));
  return h < s.x ? vec2(h, s.y * pow(h / s.x, 1.0 - compaction)) : s;
}
`;

/** For each stamp (row) and lane: what it displaces (volume in texels, mass), and the weights of its rims. */
export const SUM = `${STAMP_HEAD}
uniform vec4 bounds[${STAMPS}];
out vec4 result;
void main() {
  int me = here().y, lane = here().x;
  vec4 sum = vec4(0.0);
  ivec4 box = ivec4(bounds[me]);
  int nx = box.z - box.x, n = me < count ? nx * (box.w - box.y) : 0;
  for (int k = lane; k < n; k += ${LANES}) {
    ivec2 local = box.xy + ivec2(k % nx, k / nx);
    vec2 place = placeOf(local);
    float least = NOWHERE;
    int which = -1;
    for (int i = 0; i < count; i++) {
      float b = underside(i, place);
      if (b < least) { least = b; which = i; }
    }
    if (which < 0) { sum.zw += rim(me, place); continue; }
    if (which != me) continue;
    ivec2 slot = slotOf(local);
    vec2 s = texelFetch(snow, slot, 0).xy;
    sum.xy += s - pressed(s, least - texelFetch(bed, slot, 0).x);
  }
  result = sum;
}`;

export const SUM_LANES = `${HEAD}
uniform sampler2D lanes;
out vec4 result;
void main() {
  result = vec4(0.0);
  for (int i = 0; i < ${LANES}; i++) result += texelFetch(lanes, ivec2(i, here().y), 0);
}`;

/**
 * Press the snow and lay down the rims. Where a stamp stands on the snow the mass gets a minus sign until the slopes
 * have slid: no snow slides to where a wheel is.
 */
export const STAMP = `${STAMP_HEAD}
uniform sampler2D sums;
out vec2 result;
void main() {
  vec2 place = placeOf(localOf(here()));
  vec2 s = texelFetch(snow, here(), 0).xy;
  float least = NOWHERE;
  for (int i = 0; i < count; i++) least = min(least, underside(i, place));
  if (least < NOWHERE) {
    float b = least - texelFetch(bed, here(), 0).x;
    bool stands = b < s.x + 1e-3;
    s = pressed(s, b);
    result = stands ? vec2(s.x, -s.y) : s;
    return;
  }
  for (int i = 0; i < count; i++) {
    vec4 sum = texelFetch(sums, ivec2(0, i), 0);
    if (sum.x <= 0.0) continue;
    float side = stamps[4 * i + 3].z;
    vec2 share = vec2(sum.z > 0.0 ? side : 0.0, sum.w > 0.0 ? 1.0 - side : 0.0);
    float whole = share.x + share.y;
    if (whole <= 0.0) share = vec2(sum.z > 0.0 ? 1.0 : 0.0, sum.z > 0.0 ? 0.0 : 1.0), whole = 1.0;
    vec2 w = share / whole * rim(i, place) / max(sum.zw, vec2(1e-30));
    s += (w.x + w.y) * vec2((1.0 - compaction) * sum.x, sum.y);
  }
  result = s;
}`;

/**
 * One step of sliding: between a texel and each of its eight neighbours snow goes down where the surface is steeper
 * than it stands (law.ts: standingSlope) and than it fell. What one gives the other takes: both reckon the same flux.
 * A slide goes on until it is a little less steep than that, so it ends after finitely many.
 */
export const SLIDE = `${HEAD}
uniform vec4 region;         // local texels; its edges are closed
uniform float repose;        // tangent
uniform bool last;
out vec2 result;
float ratio(vec2 s) { return s.x > 1e-6 ? max(1.0, abs(s.y) / s.x) : 1.0; }
float flux(vec2 from, vec2 fromBed, vec2 to, vec2 toBed, float apart, float rate) {
  float ground = fromBed.x - toBed.x;
  float drop = ground + (from.x - to.x);
  if (drop <= 0.0 || from.x <= 0.0) return 0.0;
  float packed = clamp((max(ratio(from), ratio(to)) - 1.0) / ${f(PACKED_RATIO - 1)}, 0.0, 1.0);
  float limit = repose * (1.0 + ${f(PACKED_STEEPER - 1)} * packed) * apart;
  float fallen = ground + depth * (fromBed.y - toBed.y);
  if (fallen > limit) limit = fallen + 1e-4;
  return drop > limit ? min(rate * (drop - 0.97 * limit), 0.125 * from.x) : 0.0;
}
void main() {
  ivec2 local = localOf(here());
  vec2 me = texelFetch(snow, here(), 0).xy, bedHere = texelFetch(bed, here(), 0).xy;
  vec2 s = vec2(me.x, abs(me.y));
  if (me.y >= 0.0)
    for (int k = 0; k < 9; k++) {
      ivec2 way = ivec2(k % 3 - 1, k / 3 - 1), other = local + way;
      if (k == 4 || any(lessThan(vec2(other), region.xy)) || any(greaterThanEqual(vec2(other), region.zw))) continue;
      ivec2 slot = slotOf(other);
      vec2 s2 = texelFetch(snow, slot, 0).xy;
      if (s2.y < 0.0) continue;
      vec2 bed2 = texelFetch(bed, slot, 0).xy;
      bool across = way.x != 0 && way.y != 0;
      // All rates together are at most 1/2: then no step overshoots.
      float apart = across ? 1.4142136 * texel : texel, rate = across ? 1.0 / 24.0 : 1.0 / 12.0;
      float out1 = flux(me, bedHere, s2, bed2, apart, rate), in1 = flux(s2, bed2, me, bedHere, apart, rate);
      if (out1 > 0.0) s -= out1 * vec2(1.0, me.y / me.x);
      if (in1 > 0.0) s += in1 * vec2(1.0, s2.y / s2.x);
    }
  result = last || me.y >= 0.0 ? s : vec2(s.x, -s.y);
}`;

/** For whoever draws the snow; `linear` is whether floating-point textures can be filtered. */
export const sampling = (linear: boolean) => `
uniform highp sampler2D snowMap;
uniform highp vec4 snowWindow;   // least corner, size, texel [m]
uniform highp float snowFresh;   // fresh depth of the settings [m]

// 1 inside the window, fading to 0 towards its edge, 0 outside.
float snowInside(vec2 xz) {
  vec2 q = abs(xz - snowWindow.xy - 0.5 * snowWindow.z) / (0.5 * snowWindow.z);
  return 1.0 - smoothstep(0.85, 0.97, max(q.x, q.y));
}
// Depth and mass (as depth at fresh density) of the snow [m]. Outside the window: the fresh depth without the cover.
vec2 snowAt(vec2 xz) {
  vec2 q = abs(xz - snowWindow.xy - 0.5 * snowWindow.z);
  if (max(q.x, q.y) >= 0.5 * snowWindow.z) return vec2(snowFresh);
${
  linear
    ? "  return texture(snowMap, fract(xz / snowWindow.z)).xy;"
    : `  vec2 p = fract(xz / snowWindow.z) * (snowWindow.z / snowWindow.w) - 0.5;
  ivec2 n = textureSize(snowMap, 0), i = ivec2(floor(p)) + n, j = (i + 1) % n;
  i = i % n;
  vec2 t = fract(p);
  return mix(mix(texelFetch(snowMap, i, 0).xy, texelFetch(snowMap, ivec2(j.x, i.y), 0).xy, t.x),
             mix(texelFetch(snowMap, ivec2(i.x, j.y), 0).xy, texelFetch(snowMap, j, 0).xy, t.x), t.y);`
}
}
`;

/** Shader code of the snow: where its surface is, what it is made of, and how light meets it. */

/** Stand-in for a field of tracks where there is none yet: fresh snow everywhere. */
export const NO_TRACKS = /* glsl */ `
vec2 snowAt(vec2 xz) { return vec2(0.0); }
float snowInside(vec2 xz) { return 0.0; }
`;

/**
 * Weights by which a vertex takes the snow half a cell before it, at it, and half a cell after it, in each direction:
 * they leave half of a wave of two cells and nothing of a wave of one, which would stand as lozenges along a rut.
 */
export const VERTEX_WEIGHTS = [0.25, 0.5, 0.25] as const;

/**
 * `float snowDepth(vec2 xz, float level, float width)` [m] at a vertex, `width` [m] from the next: tracks inside the
 * window, fresh snow outside. Cells of two texels and less take the tracks as they are.
 */
export const DEPTH = /* glsl */ `
uniform float freshDepth;
float trackDepth(vec2 xz, float width) {
  float e = min(0.5 * width, max(0.0, width - 2.0 * snowTexel));
  if (e == 0.0) return snowAt(xz).x;
  const float weights[3] = float[3](${VERTEX_WEIGHTS.map((w) => w.toFixed(4)).join(", ")});
  float sum = 0.0;
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) sum += weights[i] * weights[j] * snowAt(xz + e * vec2(i - 1, j - 1)).x;
  return sum;
}
float snowDepth(vec2 xz, float level, float width) {
  float inside = snowInside(xz);
  if (inside >= 1.0) return trackDepth(xz, width);
  float fresh = freshDepth * groundKind(xz, level).x;
  return inside > 0.0 ? mix(fresh, trackDepth(xz, width), inside) : fresh;
}
`;

/** What is at a pixel: depth, density, slopes, kinds; lumps and grains; the ground where snow is thin. */
export const MATTER = /* glsl */ `
uniform sampler2D noiseMap;

struct Matter {
  vec3 colour;
  float roughness;
  vec2 slope;      // of the surface with its grain
  float occlusion; // of the light of the sky
  float snowy;     // 1 snow, 0 bare ground
  float loose;     // 1 fresh or heaped, 0 packed
  float glaze;     // how much of the sky a smooth surface mirrors: 1 bare ice, less where snow is packed hard
  float inside;
  float depth;
};

vec2 turned(vec2 p, float a) { return mat2(cos(a), sin(a), -sin(a), cos(a)) * p; }
vec2 bump(vec2 p) { return texture2D(noiseMap, p).rg - 0.5; }

vec3 bareGround(vec2 xz, vec2 slope, vec3 kind, vec4 broad, vec4 fine, out float rough) {
  float steep = smoothstep(0.45, 0.95, length(slope) + 0.5 * (broad.b - 0.5));
  vec3 earth = mix(vec3(0.105, 0.08, 0.058), vec3(0.21, 0.17, 0.125), fine.b);
  vec3 straw = mix(vec3(0.2, 0.17, 0.085), vec3(0.4, 0.34, 0.19), fine.a);
  earth = mix(earth, straw, smoothstep(0.5, 0.68, broad.b) * 0.8);
  vec3 rock = mix(vec3(0.1, 0.102, 0.11), vec3(0.26, 0.25, 0.24), 0.55 * fine.b + 0.45 * broad.b);
  vec3 gravel = mix(vec3(0.085, 0.085, 0.09), vec3(0.19, 0.185, 0.18), fine.a * 0.5 + fine.b * 0.5);
  rough = 0.95;
  return mix(mix(earth, gravel, smoothstep(0.3, 0.7, kind.y)), rock, steep);
}

vec3 lakeIce(vec2 xz, vec4 broad, vec4 fine) {
  vec4 b = texture2D(noiseMap, turned(xz, 0.4) * 0.013);
  // Cracks: thin lines where two smooth fields are equal.
  float crack = smoothstep(0.022, 0.0, abs(broad.b - b.b)) + 0.5 * smoothstep(0.01, 0.0, abs(b.b - 0.52));
  vec3 deep = mix(vec3(0.055, 0.15, 0.2), vec3(0.18, 0.33, 0.4), smoothstep(0.3, 0.7, broad.b));
  return mix(deep, vec3(0.62, 0.74, 0.8), clamp(0.75 * crack + 0.25 * smoothstep(0.55, 0.75, fine.b), 0.0, 1.0));
}

Matter matterAt(vec2 xz, float level, vec3 kind, vec2 ground, float near) {
  Matter m;
  m.inside = snowInside(xz);
  float spacing = max(1.0, groundLevels[int(level)].z * 2.0);
  float fresh = freshDepth * kind.x;
  vec2 covers = vec2(groundKind(xz + vec2(spacing, 0.0), level).x, groundKind(xz + vec2(0.0, spacing), level).x);
  vec2 tilt = freshDepth * (covers - kind.x) / spacing;
  float depth = fresh;
  vec4 broad = texture2D(noiseMap, turned(xz, 1.1) * 0.047);
  vec4 fine = texture2D(noiseMap, turned(xz, 0.3) * 0.61);
  // Wind sweeps ice and hard snow bare; what it lays over them lies in drifts along its way.
  vec4 streaks = texture2D(noiseMap, turned(xz * vec2(1.0, 2.6), 0.8) * 0.029);
  float blown = smoothstep(0.54, 0.66, 0.8 * streaks.b + 0.2 * fine.b);
  float hard = clamp(kind.y, 0.0, 1.0) * (1.0 - blown);
  float icy = kind.z * (1.0 - blown);
  float packed = max(0.3 * clamp(kind.y, 0.0, 1.0), 0.85 * hard);
  float moved = 0.0;
  m.occlusion = 1.0;
  if (m.inside > 0.0) {
    vec2 s = snowAt(xz);
    float e = max(snowTexel, length(fwidth(xz)) * 0.5);
    vec4 h = vec4(snowAt(xz + vec2(e, 0.0)).x, snowAt(xz - vec2(e, 0.0)).x, snowAt(xz + vec2(0.0, e)).x, snowAt(xz - vec2(0.0, e)).x);
    tilt = mix(tilt, (h.xz - h.yw) / (2.0 * e), m.inside);
    depth = mix(fresh, s.x, m.inside);
    packed = max(packed, m.inside * smoothstep(1.06, 2.3, s.y / max(s.x, 1e-3)));
    moved = m.inside * smoothstep(0.01, 0.06, abs(s.x - fresh) + 0.35 * max(0.0, length(tilt) - 0.25));
    if (near > 0.0) {
      // Sky hidden by the walls of a rut: how much higher the snow stands all about.
      const float r = 0.19;
      vec4 a = vec4(snowAt(xz + r).x, snowAt(xz - r).x, snowAt(xz + vec2(r, -r)).x, snowAt(xz + vec2(-r, r)).x);
      vec4 rise = max(a - s.x, 0.0);
      float about = dot(rise, vec4(0.25)) + 0.5 * dot(max(h - s.x, 0.0), vec4(0.25));
      m.occlusion = 1.0 - 0.62 * near * m.inside * (1.0 - exp(-about * 7.5));
    }
  }
  m.depth = depth;
  m.loose = 1.0 - packed;
  float bareRough;
  vec3 bare = bareGround(xz, ground, kind, broad, fine, bareRough);
  bare = mix(bare, lakeIce(xz, broad, fine), kind.z);
  bareRough = mix(bareRough, 0.16 + 0.25 * fine.b, kind.z);
  m.snowy = smoothstep(0.006, 0.045, depth + (broad.b - 0.5) * 0.05 + (fine.b - 0.5) * 0.03) * (1.0 - icy);
  vec3 snow = mix(vec3(0.62, 0.735, 0.86), vec3(0.87, 0.9, 0.94), m.loose);
  snow *= 0.94 + 0.12 * broad.b;
  // A packed road carries some of its gravel.
  float dirt = kind.y * smoothstep(0.45, 0.75, 0.55 * fine.b + 0.45 * broad.b);
  snow = mix(snow, vec3(0.4, 0.385, 0.37), 0.4 * dirt);
  // Hard snow is greyer, and breaks into slabs along thin cracks.
  snow *= 1.0 - hard * (0.16 + 0.4 * smoothstep(0.014, 0.0, abs(broad.b - streaks.b)));
  m.colour = mix(bare, snow, m.snowy);
  m.roughness = mix(bareRough, mix(0.42 + 0.3 * fine.b, 0.94, m.loose), m.snowy);
  m.glaze = max(kind.z * (1.0 - m.snowy), 0.3 * hard * m.snowy * (1.0 - moved));
  // Grain: crumbs where snow was thrown up, ripples of the wind where it lies as it fell.
  vec2 grain = 0.5 * bump(turned(xz, 0.3) * 1.9) + 0.5 * bump(turned(xz, 2.1) * 0.61) * (0.5 + moved);
  vec2 crumbs = bump(turned(xz, 1.7) * 0.23) * (0.35 + 1.2 * moved * m.loose);
  vec2 ripples = bump(turned(xz * vec2(1.0, 2.1), 0.8) * 0.021) * 0.5 * (1.0 - moved) * (1.0 - kind.y);
  vec2 swells = bump(turned(xz, 2.6) * 0.0047) * 0.46 * (1.0 - kind.z);
  float soft = mix(0.55, 1.0, m.loose) * mix(1.0, 0.12, kind.z * (1.0 - m.snowy)) * (1.0 - 0.4 * hard * (1.0 - moved));
  m.slope = ground + tilt + soft * (1.5 * grain + crumbs + ripples) + swells * (1.0 - moved);
  return m;
}
`;

/** Shadows of rims and walls of ruts: a short march over the snow toward the light. */
export const RUT_SHADE = /* glsl */ `
float rutLight(vec2 xz, float depth, vec2 ground, vec3 light) {
  float least = 1.0;
  float across = max(length(light.xz), 1e-3);
  vec2 d = light.xz / across;
  float climb = light.y / across - dot(ground, d);
  // Steps as short as leave no bands in the soft edge; steps that differ from pixel to pixel would weave a pattern.
  float t = 0.03;
  for (int k = 0; k < 16; k++) {
    float over = depth + 0.008 + climb * t - snowAt(xz + d * t).x;
    least = min(least, 0.5 + over / (0.02 + 0.16 * t));
    t *= 1.3;
  }
  return smoothstep(0.0, 1.0, least);
}
`;

/** Glints: each small cell of the surface has a facet of its own, which flashes when it mirrors the light to the eye. */
export const SPARKLE = /* glsl */ `
vec3 cellNoise(vec2 cell) {
  uvec2 q = uvec2(ivec2(cell)) * uvec2(1597334673u, 3812015801u);
  uint n = (q.x ^ q.y) * 1597334673u;
  uvec3 r = n * uvec3(1u, 747796405u, 2891336453u);
  r ^= r >> 15u;
  r *= 2246822519u;
  return vec3(r >> 8u) / 16777216.0;
}
float glints(vec2 xz, float size, vec3 half_, float foot) {
  vec2 p = xz / size;
  vec3 r = cellNoise(floor(p));
  vec2 centre = 0.25 + 0.5 * r.xy;
  float round_ = 1.0 - smoothstep(0.1, 0.3, length(fract(p) - centre));
  vec3 r2 = cellNoise(floor(p) + 91.0);
  vec3 facet = normalize(vec3(r2.x - 0.5, 0.42, r2.y - 0.5));
  return round_ * pow(max(dot(facet, half_), 0.0), 380.0) * (0.4 + r.z);
}
float sparkle(vec2 xz, vec3 light, vec3 view) {
  vec2 w = fwidth(xz);
  float foot = max(w.x, w.y) * 1.6 + 1e-5;
  // Cells as large as a pixel or two, blended between sizes so that nothing pops.
  float scale = max(log2(foot / 0.004), 0.0);
  float size = 0.004 * exp2(floor(scale));
  vec3 half_ = normalize(light + view);
  return mix(glints(xz, size, half_, foot), glints(xz + 3.7, 2.0 * size, half_, foot), fract(scale));
}
`;

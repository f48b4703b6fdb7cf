/** The ground for shaders: nested square lattices of heights about the car, each twice as coarse as the one within. */
import {
  DataArrayTexture,
  FloatType,
  HalfFloatType,
  LinearFilter,
  NearestFilter,
  RedFormat,
  RepeatWrapping,
  RGBAFormat,
  RGFormat,
  Vector3,
} from "three";
import type { IUniform, PixelFormat, TextureDataType, TypedArray } from "three";
import type { GroundSource } from "../../world/ground_source";
import type { Terrain } from "../../world/terrain_type";
import { CLIP_SIZE, ClipLevel, KIND_SIZE } from "./clip_level";

/** Levels: 128 m * 2^l square each, the last 8 km. */
const LEVELS = 7;
const SPACING = 0.5;

const GLSL = /* glsl */ `
uniform highp sampler2DArray groundHeights;
uniform highp sampler2DArray groundSlopes;
uniform highp sampler2DArray groundKinds;
uniform vec3 groundLevels[${LEVELS}]; // middle [m], spacing [m]

float groundAt(int level, vec2 xz) {
  vec2 p = xz / groundLevels[level].z;
  ivec2 i = ivec2(floor(p)) & ${CLIP_SIZE - 1};
  ivec2 k = (i + 1) & ${CLIP_SIZE - 1};
  vec2 f = fract(p);
  float a = texelFetch(groundHeights, ivec3(i, level), 0).r;
  float b = texelFetch(groundHeights, ivec3(k.x, i.y, level), 0).r;
  float c = texelFetch(groundHeights, ivec3(i.x, k.y, level), 0).r;
  float d = texelFetch(groundHeights, ivec3(k, level), 0).r;
  return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

// The finest level that holds a place, plus the share of the next coarser one near its edge.
float groundLevel(vec2 xz) {
  for (int l = 0; l < ${LEVELS - 1}; l++) {
    vec2 d = abs(xz - groundLevels[l].xy) / (groundLevels[l].z * ${CLIP_SIZE / 2}.0);
    float r = max(d.x, d.y);
    // The finest is pure to 57 m: the snow takes its ground as far as the corner of its largest window, 56 m.
    if (r < 0.97) return float(l) + smoothstep(0.89, 0.97, r);
  }
  return ${LEVELS - 1}.0;
}

float groundHeight(vec2 xz) {
  float level = groundLevel(xz);
  int l = int(level);
  float share = level - float(l);
  float h = groundAt(l, xz);
  return share > 0.0 ? mix(h, groundAt(l + 1, xz), share) : h;
}

vec3 groundPlace(int level, vec2 xz, float texels, float stride) {
  return vec3((xz / (groundLevels[level].z * stride) + 0.5) / texels, float(level));
}

vec2 groundSlope(vec2 xz, float level) {
  int l = int(level);
  vec2 s = texture(groundSlopes, groundPlace(l, xz, ${CLIP_SIZE}.0, 1.0)).rg;
  if (l == ${LEVELS - 1}) return s;
  return mix(s, texture(groundSlopes, groundPlace(l + 1, xz, ${CLIP_SIZE}.0, 1.0)).rg, level - float(l));
}

// Cover (factor of the depth of fresh snow), shares of packed snow and of ice.
vec3 groundKind(vec2 xz, float level) {
  int l = int(level);
  vec3 k = texture(groundKinds, groundPlace(l, xz, ${KIND_SIZE}.0, 2.0)).rgb;
  if (l < ${LEVELS - 1}) k = mix(k, texture(groundKinds, groundPlace(l + 1, xz, ${KIND_SIZE}.0, 2.0)).rgb, level - float(l));
  return k * vec3(2.0, 1.0, 1.0);
}
`;

export class GroundClipmap implements GroundSource {
  readonly glsl = GLSL;
  readonly uniforms: Record<string, IUniform>;
  /** Bytes of the textures. */
  readonly textureBytes = LEVELS * (CLIP_SIZE ** 2 * (4 + 4) + KIND_SIZE ** 2 * 4);
  private readonly levels: ClipLevel[] = [];
  private readonly textures: DataArrayTexture[];
  private readonly places: Vector3[] = [];

  constructor(terrain: Terrain) {
    const n = CLIP_SIZE ** 2;
    const heights = new Float32Array(LEVELS * n);
    const slopes = new Uint16Array(LEVELS * 2 * n);
    const kinds = new Uint8Array(LEVELS * n);
    for (let l = 0; l < LEVELS; l++) {
      const level = new ClipLevel(terrain, SPACING * 2 ** l, {
        heights: heights.subarray(l * n, (l + 1) * n),
        slopes: slopes.subarray(l * 2 * n, (l + 1) * 2 * n),
        kinds: kinds.subarray(l * n, (l + 1) * n),
      });
      this.levels.push(level);
      this.places.push(new Vector3(0, 0, level.spacing));
    }
    this.textures = [
      layers(heights, CLIP_SIZE, RedFormat, FloatType, "nearest"),
      layers(slopes, CLIP_SIZE, RGFormat, HalfFloatType, "linear"),
      layers(kinds, KIND_SIZE, RGBAFormat, undefined, "linear"),
    ];
    const [groundHeights, groundSlopes, groundKinds] = this.textures;
    this.uniforms = {
      groundHeights: { value: groundHeights },
      groundSlopes: { value: groundSlopes },
      groundKinds: { value: groundKinds },
      groundLevels: { value: this.places },
    };
    this.follow(0, 0, LEVELS);
  }

  /** Keep the levels about (x, z) [m]; at most `most` of them move in one call, finest first. */
  follow(x: number, z: number, most = 1): void {
    for (const [l, level] of this.levels.entries()) {
      if (most === 0) return;
      if (!level.move(x, z)) continue;
      most--;
      this.places[l]!.set(...level.middle, level.spacing);
      for (const texture of this.textures) {
        texture.addLayerUpdate(l);
        texture.needsUpdate = true;
      }
    }
  }

  /** Take over that the terrain has other kinds of snow than before. */
  repaint(): void {
    for (const level of this.levels) level.repaint();
    const kinds = this.textures[2]!;
    kinds.clearLayerUpdates();
    kinds.needsUpdate = true;
  }

  /** After a lost context: everything is uploaded again. */
  restore(): void {
    for (const texture of this.textures) {
      texture.clearLayerUpdates();
      texture.needsUpdate = true;
    }
  }

  dispose(): void {
    for (const texture of this.textures) texture.dispose();
  }
}

function layers(
  data: TypedArray,
  size: number,
  format: PixelFormat,
  type: TextureDataType | undefined,
  filter: "nearest" | "linear",
): DataArrayTexture {
  const texture = new DataArrayTexture(data as Uint8Array<ArrayBuffer>, size, size, LEVELS);
  texture.format = format;
  if (type) texture.type = type;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.minFilter = texture.magFilter = filter === "linear" ? LinearFilter : NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

/** The snow that is seen: grid rings lifted to ground plus depth, and the material of snow, ice and bare ground. */
import { BufferAttribute, BufferGeometry, Mesh, MeshStandardMaterial, Vector2, Vector3 } from "three";
import type { IUniform, PerspectiveCamera, Texture } from "three";
import type { Atmosphere } from "../sky/atmosphere";
import { put } from "../sky/atmosphere";
import { arc, byDirection, ringGlsl, ringGrid, type Turned } from "./ring_layout";
import { DEPTH, MATTER, NO_TRACKS, RUT_SHADE, SPARKLE } from "./snow_glsl";
import { corner } from "./stand";

/** What the surface needs to know of a field of tracks. */
export interface Tracks {
  readonly glsl: string;
  readonly uniforms: Record<string, IUniform>;
  readonly texel: number;
}

/** How fine the grid is: cells along a side of each ring (a multiple of 4), rings, smallest cell [m]. */
export interface RingSize {
  readonly cells: number;
  readonly levels: number;
  readonly cell: number;
}

export const RINGS: RingSize = { cells: 112, levels: 10, cell: 0.1 };
/** For machines without a graphics card: a quarter of the triangles. */
export const COARSE_RINGS: RingSize = { cells: 56, levels: 10, cell: 0.1 };

/** Levels that are always drawn; of the others only what lies ahead, in sectors of a turn. */
const NEAR = 2;
const SECTORS = 24;
/** How far a vertex may be from where the middle of its triangle is in the grid [cells]: lattices snap, and rings glide. */
const SNAP = 5;

export class SnowSurface {
  /** The nearest levels; the others are its child. */
  readonly mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly far: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly turned: Turned;
  private readonly air: Atmosphere;
  private readonly rings: RingSize;
  private readonly uniforms = {
    freshDepth: { value: 0.4 },
    ringCentre: { value: new Vector2() },
    ringCell: { value: 0.1 },
    noiseMap: { value: null as Texture | null },
  };

  constructor(air: Atmosphere, noise: Texture, rings: RingSize = RINGS) {
    this.air = air;
    this.rings = rings;
    const grid = ringGrid(rings.cells, rings.levels);
    const { near, far } = byDirection(grid, NEAR, SECTORS);
    this.turned = far;
    const positions = new BufferAttribute(grid.positions, 3);
    const [inner, outer] = [near, far.indices].map((indices) =>
      new BufferGeometry().setAttribute("position", positions).setIndex(new BufferAttribute(indices, 1)),
    ) as [BufferGeometry, BufferGeometry];
    outer.setDrawRange(...arc(far, 0, Math.PI));
    this.uniforms.noiseMap.value = noise;
    this.uniforms.ringCell.value = rings.cell;
    const material = this.material(null);
    this.mesh = new Mesh(inner, material);
    this.far = new Mesh(outer, material);
    for (const mesh of [this.mesh, this.far]) {
      mesh.frustumCulled = false;
      mesh.receiveShadow = true;
    }
    this.mesh.add(this.far);
  }

  /** Show the tracks of a field from now on. */
  attach(tracks: Tracks): void {
    this.mesh.material.dispose();
    this.mesh.material = this.far.material = this.material(tracks);
  }

  /** Set the depth of fresh snow [m] and the middle of the finest cells [m]. */
  update(depth: number, x: number, z: number): void {
    this.uniforms.freshDepth.value = depth;
    this.uniforms.ringCentre.value.set(x, z);
  }

  /** Draw only what lies ahead of a camera. */
  look(camera: PerspectiveCamera): void {
    const ahead = camera.getWorldDirection(new Vector3());
    const half = corner(camera);
    const level = Math.hypot(ahead.x, ahead.z);
    // Width of the camera's cone as a part of the horizon, and how much wider it is seen from the middle of the rings.
    const wide = Math.sin(half) < level && half < Math.PI / 2 ? Math.asin(Math.sin(half) / level) : Math.PI;
    const { x, y } = this.uniforms.ringCentre.value;
    const { cells, cell } = this.rings;
    const aside = Math.hypot(camera.position.x - x, camera.position.z - y);
    const inner = (cells / 4 - SNAP) * cell * 2 ** NEAR;
    const more = aside < inner ? Math.asin(aside / inner) + SNAP / (cells / 4) : Math.PI;
    this.far.geometry.setDrawRange(...arc(this.turned, Math.atan2(ahead.z, ahead.x), wide + more));
  }

  dispose(): void {
    this.far.geometry.dispose();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }

  private material(tracks: Tracks | null): MeshStandardMaterial {
    const material = new MeshStandardMaterial({ roughness: 0.9 });
    const field = `#define snowTexel ${(tracks?.texel ?? 0.05).toFixed(5)}\n${tracks?.glsl ?? NO_TRACKS}\n${DEPTH}`;
    this.air.dress(material, {
      key: tracks ? `tracks ${tracks.texel}` : "no tracks",
      uniforms: { ...this.uniforms, ...tracks?.uniforms },
      sun: SUN,
      change: (shader) => {
        shader.vertexShader = put(
          shader.vertexShader,
          "void main() {",
          `${field}\n${ringGlsl(this.rings.cells)}\nvoid main() {`,
        );
        shader.vertexShader = put(shader.vertexShader, "#include <beginnormal_vertex>", VERTEX_NORMAL);
        shader.vertexShader = put(shader.vertexShader, "#include <begin_vertex>", VERTEX_PLACE);
        let f = shader.fragmentShader;
        f = put(f, "void main() {", `${field}\n${MATTER}\n${RUT_SHADE}\n${SPARKLE}\nvoid main() {`);
        f = put(f, "#include <map_fragment>", FRAGMENT_MATTER);
        f = put(f, "#include <roughnessmap_fragment>", "float roughnessFactor = matter.roughness;");
        f = put(f, "#include <normal_fragment_begin>", FRAGMENT_NORMAL);
        f = put(f, "#include <aomap_fragment>", GLAZE);
        f = put(f, "#include <opaque_fragment>", `${FRAGMENT_GLINTS}\n#include <opaque_fragment>`);
        // The ground's code is wanted in the fragments as well as in the vertices.
        shader.fragmentShader = put(f, "#include <common>", `#include <common>\n${this.air.groundGlsl}`);
      },
    });
    return material;
  }
}

const VERTEX_NORMAL = /* glsl */ `
float width;
vec2 xz = ringPlace(position, width);
float level = groundLevel(xz);
vec2 incline = groundSlope(xz, level);
vec3 objectNormal = normalize(vec3(-incline.x, 1.0, -incline.y));
`;

const VERTEX_PLACE = /* glsl */ `
vec3 transformed = vec3(xz.x, groundHeight(xz) + snowDepth(xz, level, width), xz.y);
`;

const FRAGMENT_MATTER = /* glsl */ `
vec2 xz = vPlace.xz;
float level = groundLevel(xz);
vec2 ground = groundSlope(xz, level);
vec3 kind = groundKind(xz, level);
float near = 1.0 - smoothstep(14.0, 22.0, distance(vPlace, cameraPosition));
Matter matter = matterAt(xz, level, kind, ground, near);
diffuseColor.rgb = matter.colour;
`;

const FRAGMENT_NORMAL = /* glsl */ `
float faceDirection = 1.0;
vec3 up = normalize(vec3(-matter.slope.x, 1.0, -matter.slope.y));
vec3 normal = normalize((viewMatrix * vec4(up, 0.0)).xyz);
vec3 nonPerturbedNormal = normal;
`;

// Snow lets light through its edges and throws it forward: a soft tail beyond the terminator, bluer the longer the
// way in the ice; brighter against a low sun.
const SUN = /* glsl */ `
if (matter.inside > 0.0 && near > 0.0) {
  sunVisible *= mix(1.0, rutLight(xz, matter.depth, ground, lightDirection), matter.inside * near);
}
float facing = dot(geometryNormal, directLight.direction);
float against = pow(max(0.0, -dot(geometryViewDir, directLight.direction)), 5.0);
vec3 through = pastTerminator(facing) + vec3(1.0, 0.93, 0.86) * 0.13 * against * max(0.0, facing + 0.2);
reflectedLight.directDiffuse += matter.snowy * sunVisible * directLight.color * through * material.diffuseColor * RECIPROCAL_PI;
`;

// Smooth ice mirrors the sky by Schlick's formula (1994); 0.018 is what ice (n = 1.31) mirrors straight down.
const GLAZE = /* glsl */ `
{
  vec3 toEye = normalize(cameraPosition - vPlace);
  float mirrored = 0.018 + 0.982 * pow(1.0 - clamp(dot(up, toEye), 0.0, 1.0), 5.0);
  reflectedLight.indirectSpecular += matter.glaze * mirrored * skyColour(reflect(-toEye, up));
}
reflectedLight.indirectDiffuse *= matter.occlusion;
reflectedLight.indirectSpecular *= matter.occlusion;
`;

const FRAGMENT_GLINTS = /* glsl */ `
{
  vec3 toEye = normalize(cameraPosition - vPlace);
  float flash = sparkle(xz, lightDirection, toEye) * matter.snowy * mix(0.35, 1.0, matter.loose);
  float fading = 1.0 - smoothstep(6.0, 60.0, distance(cameraPosition, vPlace));
  outgoingLight += lightColour * sunVisible * flash * 2.2 * fading;
}
`;

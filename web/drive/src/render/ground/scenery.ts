/** Trees, rocks and poles about the camera: few shapes, drawn many times, coarser far away. */
import { DoubleSide, FrontSide, Group, Matrix4, MeshStandardMaterial, Quaternion, Vector3 } from "three";
import type { BufferGeometry, InstancedMesh, PerspectiveCamera, Texture } from "three";
import type { Atmosphere, Changes } from "../sky/atmosphere";
import { put } from "../sky/atmosphere";
import { pine, pole, rock } from "./plant_shapes";
import { Sight, Stand } from "./stand";
import type { Place, Places } from "../../world/places";
import { TILE } from "../../world/places";

/** Trees: up to which distance [m] each shape is drawn, how many at most, whether it throws shadows. */
const RANGES = [
  { far: 42, most: 80, shadow: true },
  { far: 150, most: 600, shadow: true },
  { far: 900, most: 3000, shadow: false },
] as const;
/** Rocks: up to which distance [m], how finely, how many at most; the nearest throw shadows. */
const ROCKS = [
  { far: 60, detail: 2, most: 80, shadow: true },
  { far: 220, detail: 1, most: 260, shadow: false },
] as const;
const POLES = { far: 260, most: 160 };
/** Tiles known at most; more than a circle of the far range holds. */
const KNOWN = 900;
/** Distance the camera moves before what is drawn is chosen anew [m]. */
const STRIDE = 6;
/** How far it moves [m] and turns [rad] before what is in sight is sorted anew. */
const WAY = 2;
const TURN = 0.12;

const HEAD = /* glsl */ `
varying vec3 vLeaf;
varying vec3 vLocal;
uniform sampler2D noiseMap;
`;

const PINE = /* glsl */ `
float snow = 0.0;
if (vLeaf.z > 0.5) {
  vec4 n = texture2D(noiseMap, vec2(vLeaf.y * 0.37, vLeaf.x * 0.33 + vLocal.y * 1.9));
  vec4 sharp = texture2D(noiseMap, vec2(vLeaf.y * 1.9, vLeaf.x * 0.9 + vLocal.y * 3.1));
  // The rim frays into needles.
  if (vLeaf.x > 0.74 + 0.6 * (sharp.b - 0.36) + 0.3 * (n.a - 0.5)) discard;
  vec3 needles = mix(vec3(0.026, 0.055, 0.042), vec3(0.075, 0.11, 0.065), sharp.b) * (0.75 + 0.7 * vLeaf.x);
  // Snow lies in cushions on the branches and has slid off between them.
  float cushion = 0.55 * n.b + 0.45 * sharp.b + 0.1 * cos(6.283 * vLeaf.y) - 0.3 * smoothstep(0.6, 1.0, vLeaf.x) - 0.12 * smoothstep(0.25, 0.0, vLeaf.x);
  snow = smoothstep(0.36, 0.52, cushion + 0.06);
  // From below one sees needles, and the light of the snow on the ground on them.
  if (!gl_FrontFacing) snow *= 0.22;
  diffuseColor.rgb = mix(gl_FrontFacing ? needles : needles * 0.8, vec3(0.8, 0.84, 0.9), snow);
} else {
  diffuseColor.rgb = vec3(0.075, 0.058, 0.048);
}
`;

const ROCK = /* glsl */ `
vec4 n = texture2D(noiseMap, vPlace.xz * 0.31 + vPlace.y * 0.23);
vec4 fine = texture2D(noiseMap, vPlace.xy * 0.9 + vPlace.z * 0.7);
vec3 facing = transformNormalByInverseViewMatrix(normalize(vNormal), viewMatrix);
float snow = smoothstep(0.5, 0.62, facing.y + 0.5 * (n.b - 0.5) + 0.3 * (fine.b - 0.5));
diffuseColor.rgb = mix(mix(vec3(0.085, 0.086, 0.095), vec3(0.24, 0.235, 0.23), 0.5 * n.b + 0.5 * fine.b), vec3(0.84, 0.87, 0.91), snow);
`;

const POLE = /* glsl */ `
float band = step(0.5, fract(vLeaf.x * 1.25));
diffuseColor.rgb = mix(vec3(0.85, 0.84, 0.8), vec3(0.82, 0.16, 0.03), band);
`;

interface Kind {
  readonly stand: Stand;
  readonly from: number;
  readonly far: number;
}

export class Scenery {
  readonly group = new Group();
  /** What throws shadows. */
  readonly casters: InstancedMesh[] = [];
  private readonly placesOn: (i: number, j: number) => Places;
  private readonly tiles = new Map<string, Places>();
  private readonly trees: Kind[] = [];
  private readonly rocks: Kind[] = [];
  private readonly poles: Kind;
  private readonly chosenAt = new Vector3(Infinity, 0, 0);
  private readonly sight = new Sight(WAY, TURN);
  private sorted = false;
  private unseen = 0;

  constructor(air: Atmosphere, noise: Texture, placesOn: (i: number, j: number) => Places) {
    this.placesOn = placesOn;
    const shapes = [
      pine({ whorls: 11, branches: 7, steps: 2 }, 3),
      pine({ whorls: 6, branches: 5, steps: 1 }, 4),
      pine({ whorls: 3, branches: 2, steps: 1 }, 5),
    ];
    const needles = dressed(air, noise, "pine", PINE, DoubleSide);
    RANGES.forEach(({ far, most, shadow }, k) => {
      const from = RANGES[k - 1]?.far ?? 0;
      this.trees.push({ stand: this.stand(shapes[k]!, needles, most, shadow), from, far });
    });
    const stone = dressed(air, noise, "rock", ROCK, FrontSide);
    ROCKS.forEach(({ far, detail, most, shadow }, k) => {
      const from = ROCKS[k - 1]?.far ?? 0;
      this.rocks.push({ stand: this.stand(rock(detail), stone, most, shadow), from, far });
    });
    const paint = dressed(air, noise, "pole", POLE, FrontSide);
    this.poles = { stand: this.stand(pole(), paint, POLES.most, true), from: 0, far: POLES.far };
  }

  /**
   * Choose what is drawn about (x, z) [m]; at most `tiles` new tiles of the world are planted in one call. True if
   * something else is drawn than before.
   */
  follow(x: number, z: number, tiles = 1): boolean {
    const planted = this.plant(x, z, tiles);
    this.unseen += planted;
    // New tiles are shown by the dozen: to choose costs more than to plant.
    const due = this.unseen >= 24 || (this.unseen > 0 && planted < tiles);
    const moved = Math.hypot(x - this.chosenAt.x, z - this.chosenAt.z) > STRIDE;
    if (!moved && !due) return false;
    this.unseen = 0;
    this.chosenAt.set(x, 0, z);
    this.choose(x, z);
    return true;
  }

  /** Draw in pictures only what this camera sees. */
  look(camera: PerspectiveCamera): void {
    if (this.sorted && !this.sight.isLeftBy(camera)) return;
    this.sorted = true;
    this.sight.take(camera);
    for (const { stand } of this.kinds) stand.sort(this.sight);
  }

  /** Triangles of a picture, and of a shadow map. */
  get triangles(): { seen: number; cast: number } {
    const sum = (of: (stand: Stand) => number) =>
      this.kinds.reduce((all, { stand }) => all + (of(stand) * stand.mesh.geometry.index!.count) / 3, 0);
    const cast = (stand: Stand) => (this.casters.includes(stand.mesh) ? stand.count : 0);
    return { seen: sum(({ seen }) => seen), cast: sum(cast) };
  }

  dispose(): void {
    for (const { stand } of this.kinds) stand.dispose();
  }

  private get kinds(): readonly Kind[] {
    return [...this.trees, ...this.rocks, this.poles];
  }

  private stand(shape: BufferGeometry, material: MeshStandardMaterial, most: number, shadow: boolean): Stand {
    const stand = new Stand(shape, material, most);
    if (shadow) this.casters.push(stand.mesh);
    this.group.add(stand.mesh);
    return stand;
  }

  /** Plant the tiles in sight that are not known yet, the nearest first, at most `budget`; how many it were. */
  private plant(x: number, z: number, budget: number): number {
    const reach = Math.ceil(RANGES[2].far / TILE);
    let planted = 0;
    const [ci, cj] = [Math.floor(x / TILE), Math.floor(z / TILE)];
    for (let ring = 0; ring <= reach; ring++) {
      for (let dj = -ring; dj <= ring; dj++) {
        const step = Math.abs(dj) === ring ? 1 : 2 * ring;
        for (let di = -ring; di <= ring; di += Math.max(1, step)) {
          const key = `${ci + di},${cj + dj}`;
          if (this.tiles.has(key)) continue;
          if (planted === budget) return planted;
          planted++;
          this.tiles.set(key, this.placesOn(ci + di, cj + dj));
          // The oldest goes: a Map keeps the order in which its keys came.
          if (this.tiles.size > KNOWN) this.tiles.delete(this.tiles.keys().next().value!);
        }
      }
    }
    return planted;
  }

  private choose(x: number, z: number): void {
    const all = [...this.tiles.values()];
    for (const kind of this.trees) fill(kind, all, (p) => p.trees, x, z, 1);
    for (const kind of this.rocks) fill(kind, all, (p) => p.rocks, x, z, 0.7);
    fill(this.poles, all, (p) => p.poles, x, z, 1);
    this.sorted = false;
  }
}

const matrix = new Matrix4();
const turn = new Quaternion();
const size = new Vector3();
const at = new Vector3();
const UP = new Vector3(0, 1, 0);

/** Take what stands between `kind.from` and `kind.far` of (x, z); thinner toward the far end. */
function fill(
  { stand, from, far }: Kind,
  tiles: readonly Places[],
  of: (p: Places) => readonly Place[],
  x: number,
  z: number,
  tall: number,
): void {
  stand.clear();
  for (const tile of tiles) {
    for (const p of of(tile)) {
      const away = Math.hypot(p.x - x, p.z - z);
      if (away < from || away >= far) continue;
      // Woods keep their closed look with fewer, wider trees.
      const keep = away < 200 ? 1 : (200 / away) ** 1.1;
      if (p.rank > keep) continue;
      const wide = p.size * (1 + 0.35 * (1 - keep)) * (0.92 + 0.25 * p.rank);
      turn.setFromAxisAngle(UP, p.turn);
      matrix.compose(at.set(p.x, p.y, p.z), turn, size.set(wide, p.size * tall, wide));
      stand.add(matrix, 0.82 + 0.18 * p.rank);
    }
  }
}

function dressed(
  air: Atmosphere,
  noise: Texture,
  key: string,
  code: string,
  side: typeof DoubleSide | typeof FrontSide,
): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ roughness: 0.92, side });
  const changes: Changes = {
    key,
    uniforms: { noiseMap: { value: noise } },
    change: (shader) => {
      shader.vertexShader = put(
        shader.vertexShader,
        "void main() {",
        "attribute vec3 leaf;\nvarying vec3 vLeaf;\nvarying vec3 vLocal;\nvoid main() {\nvLeaf = leaf;\nvLocal = position + instanceMatrix[3].xzx * 0.37;",
      );
      let f = put(shader.fragmentShader, "void main() {", `${HEAD}\nvoid main() {`);
      f = put(f, "#include <map_fragment>", code);
      // Needles keep the normal of their cone on both sides: a tree is lit as one soft body.
      f = put(
        f,
        "#include <normal_fragment_begin>",
        "float faceDirection = 1.0;\nvec3 normal = normalize(vNormal);\nvec3 nonPerturbedNormal = normal;",
      );
      shader.fragmentShader = f;
    },
  };
  air.dress(material, changes);
  return material;
}

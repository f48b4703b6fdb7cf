/** What the driver sees of the car: dashboard with dials whose needles move, steering wheel, mirror. */
import { CircleGeometry, Group, Mesh, MeshStandardMaterial, RingGeometry } from "three";
import type { BufferGeometry, Vector3 } from "three";
import { put, type Changes } from "../sky/atmosphere";
import { numeral } from "./numerals";
import { Parts } from "./solid_parts";

const BLACK = 0x101113;
const PLASTIC = 0x1b1d1f;
const LEATHER = 0x2a1c14;
const STEEL = 0xb9bdc1;

/** Dials: middle in the drawing, radius [m], marks, the number at the last of them; every other one has its number. */
const DIALS = [
  { name: "speed", z: -0.47, radius: 0.062, marks: 13, last: 120 }, // km/h
  { name: "engine", z: -0.26, radius: 0.062, marks: 13, last: 6 }, // 1000 / min
] as const;
/** Height of the numbers, and how far from the middle they stand [m]. */
const NUMBER = { height: 0.0088, radius: 0.0295 };
const FACE = { x: 0.236, y: 0.805 };
/** Needles sweep from lower left to lower right [rad]. */
const SWEEP = 1.5 * Math.PI;
/** Speed at the end of the dial [m/s], and turns of the steering wheel for one of the front wheels. */
const FULL_SPEED = 120 / 3.6;
const STEERING = 9;
/** Steering column: where its wheel is, and how far it leans back [rad]. */
const COLUMN = { x: 0.1, y: 0.752, z: -0.36, lean: 0.42 };

/** The room behind the windows, in the drawing [m]: an eye in it sees the cockpit, from outside the glass hides it. */
const CAB = { x: [-1.95, 0.67], y: [0.6, 1.3], z: [-0.785, 0.785] } as const;

/**
 * The body is one solid up to the windows, and the wheel reaches down into it: inside of the cab it is drawn before
 * what is there, nearer by this in clip space. Nothing is between it and the driver.
 */
const BEFORE: Changes = {
  key: "before the board",
  change: (shader) => {
    shader.vertexShader = put(
      shader.vertexShader,
      "#include <project_vertex>",
      "#include <project_vertex>\ngl_Position.z -= 0.25 * gl_Position.w;",
    );
  },
};

/** Angle of a needle from straight up for a reading 0..1, to the right as the driver sees it [rad]. */
export function needleAngle(reading: number): number {
  return SWEEP * (Math.min(1, Math.max(0, reading)) - 0.5);
}

export class Cockpit {
  readonly group = new Group();
  private readonly needles: Mesh[] = [];
  private readonly wheel: Mesh;

  /** `dress`: gives a material the air of the scene, and changes beyond it. */
  constructor(dress: (material: MeshStandardMaterial, changes?: Changes) => MeshStandardMaterial) {
    const plastic = dress(new MeshStandardMaterial({ roughness: 0.8 }));
    const leather = dress(new MeshStandardMaterial({ roughness: 0.5 }), BEFORE);
    const metal = dress(new MeshStandardMaterial({ roughness: 0.3, metalness: 0.9 }));
    const glowing = dress(new MeshStandardMaterial({ roughness: 0.6 }));
    glowing.emissive.setRGB(0.5, 0.46, 0.4);
    glowing.emissiveIntensity = 0.35;
    this.add(dashboard(), plastic);
    this.add(trim(), metal);
    this.add(marks(), glowing).name = "marks";
    for (const { name, z, radius } of DIALS) {
      const needle = this.add(needleShape(radius), glowing);
      needle.name = name;
      needle.position.set(FACE.x - 0.006, FACE.y, z);
      this.needles.push(needle);
    }
    this.wheel = this.add(steeringWheel(), leather);
    this.wheel.position.set(COLUMN.x, COLUMN.y, COLUMN.z);
    this.update(0, 0, 0);
  }

  /** Speed [m/s], engine 0..1, steering of the front wheels, to the left [rad]. */
  update(speed: number, revs: number, steer: number): void {
    // The driver looks along +x: to the right is +z, so that a turn to the right is one about +x.
    this.needles[0]!.rotation.x = needleAngle(Math.abs(speed) / FULL_SPEED);
    this.needles[1]!.rotation.x = needleAngle(revs);
    this.wheel.rotation.set(-STEERING * steer, 0, -COLUMN.lean, "ZXY");
  }

  /** Draw it only for an eye in the cab; `eye`: in the drawing [m]. */
  look({ x, y, z }: Vector3): void {
    const within = (a: number, [low, high]: readonly [number, number]) => low < a && a < high;
    this.group.visible = within(x, CAB.x) && within(y, CAB.y) && within(z, CAB.z);
  }

  dispose(): void {
    for (const part of this.group.children) (part as Mesh).geometry.dispose();
  }

  private add(geometry: BufferGeometry, material: MeshStandardMaterial): Mesh {
    const mesh = new Mesh(geometry, material);
    mesh.receiveShadow = true;
    this.group.add(mesh);
    return mesh;
  }
}

function dashboard(): BufferGeometry {
  const p = new Parts();
  // The body is one solid up to the windows: a black board over it is all that is seen of the room below.
  p.box([-1.85, 0.68, -0.765], [0.62, 0.715, 0.765], 0, BLACK);
  p.box([0.26, 0.6, -0.74], [0.6, 0.79, 0.74], 0.05, PLASTIC);
  // The hood over the dials, open to the driver, and the middle of the board.
  p.box([0.24, 0.725, -0.58], [0.42, 0.735, -0.15], 0.004, 0x141517);
  p.box([0.2, 0.872, -0.59], [0.44, 0.89, -0.14], 0.008, 0x141517);
  p.boxes([0.2, 0.73, -0.6], [0.44, 0.89, -0.575], 0.008, 0x141517);
  p.box([0.245, 0.735, -0.58], [0.43, 0.875, -0.15], 0.01, 0x0d0e0f);
  p.box([0.235, 0.64, -0.08], [0.3, 0.78, 0.16], 0.012, 0x141517);
  for (const z of [-0.05, 0.05]) p.box([0.228, 0.735, z - 0.035], [0.24, 0.765, z + 0.035], 0.004, BLACK);
  p.box([0.245, 0.66, 0.24], [0.27, 0.75, 0.66], 0.012, 0x17191b);
  for (const { z, radius } of DIALS) p.lamp([FACE.x + 0.004, FACE.y, z], radius, 0.008, 0x050607);
  // Mirror, column.
  p.box([0.2, 1.09, -0.12], [0.225, 1.155, 0.12], 0.01, BLACK);
  p.bar([0.21, 1.15, 0], [0.21, 1.21, 0], 0.01, BLACK);
  p.bar([0.34, 0.66, -0.36], [COLUMN.x + 0.02, COLUMN.y - 0.01, COLUMN.z], 0.032, BLACK);
  return p.merged();
}

function trim(): BufferGeometry {
  const p = new Parts();
  for (const { z, radius } of DIALS) p.ring([FACE.x - 0.004, FACE.y, z], radius, 0.004, STEEL);
  for (const z of [0.03, 0.09, 0.15]) p.lamp([0.228, 0.69, z - 0.05], 0.016, 0.02, STEEL);
  p.ring([0.232, 0.7, 0.57], 0.032, 0.004, STEEL);
  return p.merged();
}

/** Marks about the dials: every other one is long and has its number. */
function marks(): BufferGeometry {
  const p = new Parts();
  for (const { z, radius, marks: count, last } of DIALS)
    for (let k = 0; k < count; k++) {
      const angle = needleAngle(k / (count - 1));
      const long = k % 2 === 0 ? 0.016 : 0.009;
      const [up, right] = [NUMBER.radius * Math.cos(angle), NUMBER.radius * Math.sin(angle)];
      if (k % 2 === 0)
        p.add(
          numeral((last * k) / (count - 1), NUMBER.height).translate(FACE.x - 0.003, FACE.y + up, z + right),
          0xe8e4da,
        );
      const mark = new Parts()
        .box([-0.001, radius - 0.006 - long, -0.0014], [0.001, radius - 0.006, 0.0014], 0, 0xe8e4da)
        .merged();
      p.add(mark.rotateX(angle).translate(FACE.x - 0.003, FACE.y, z), 0xe8e4da);
    }
  return p.merged();
}

function needleShape(radius: number): BufferGeometry {
  return new Parts()
    .box([-0.0015, -0.012, -0.0022], [0.0015, radius - 0.012, 0.0022], 0, 0xe0451c)
    .lamp([0, 0, 0], 0.008, 0.006, BLACK)
    .merged();
}

/** Rim, three spokes and boss about the x axis. */
function steeringWheel(): BufferGeometry {
  const p = new Parts();
  p.ring([0, 0, 0], 0.16, 0.0145, LEATHER);
  for (const angle of [Math.PI / 2, -Math.PI / 2, Math.PI]) {
    const spoke = new Parts().box([-0.006, 0.03, -0.016], [0.006, 0.158, 0.016], 0.004, 0x6d7176).merged();
    p.add(spoke.rotateX(angle), 0x6d7176);
  }
  p.lamp([0, 0, 0], 0.045, 0.03, BLACK);
  p.add(new RingGeometry(0.026, 0.03, 20).rotateY(-Math.PI / 2).translate(-0.018, 0, 0), STEEL);
  p.add(new CircleGeometry(0.012, 6).rotateY(-Math.PI / 2).translate(-0.018, 0, 0), STEEL);
  return p.merged();
}

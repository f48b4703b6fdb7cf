/**
 * The shape of the car, made of code: an upright little 4x4. Its front looks along +x, y is up from the line of the
 * axles, z to the right; axles at x = +-1.3 m, middles of the tyres at z = +-0.76 m.
 */
import { BoxGeometry, LatheGeometry, Matrix4, Path, Shape, Vector2 } from "three";
import type { BufferGeometry } from "three";
import { Parts } from "./solid_parts";
import type { Point } from "./solid_parts";

/** Axle to axle and tyre to tyre of the drawing [m]; the picture is scaled to the car that drives. */
export const DRAWN = { base: 2.6, track: 1.52 };

/** Colour of the body. */
export const PAINT = 0xc4380f;
const ROOF = 0xe9e4d8;
const BLACK = 0x101113;
const GREY = 0x3a3d40;
const STEEL = 0xb9bdc1;

/** Where the lamps are: middles of their glass. */
export const HEADLAMPS: readonly Point[] = [
  [1.885, 0.39, -0.6],
  [1.885, 0.39, 0.6],
];
export const TAILLAMPS: readonly Point[] = [
  [-2.045, 0.42, -0.72],
  [-2.045, 0.42, 0.72],
];

export interface CarShape {
  readonly paint: BufferGeometry;
  readonly dark: BufferGeometry;
  readonly metal: BufferGeometry;
  readonly glass: BufferGeometry;
  readonly white: BufferGeometry;
  readonly red: BufferGeometry;
}

/** The car in a colour. */
export function carShape(colour: number = PAINT): CarShape {
  return {
    paint: paint(colour),
    dark: dark(),
    metal: metal(),
    glass: glass(),
    white: whiteLamps(),
    red: redLamps(),
  };
}

function sideView(): Shape {
  const s = new Shape();
  s.moveTo(-2.0, 0.16);
  s.lineTo(-2.03, 0.62);
  s.quadraticCurveTo(-2.03, 0.7, -1.95, 0.7);
  s.lineTo(0.66, 0.7);
  s.lineTo(1.62, 0.64);
  s.quadraticCurveTo(1.86, 0.62, 1.87, 0.5);
  s.lineTo(1.87, 0.14);
  s.lineTo(1.79, 0.08);
  s.absarc(1.3, 0.02, 0.5, 0.12, Math.PI - 0.12, false);
  s.lineTo(0.76, -0.1);
  s.lineTo(-0.76, -0.1);
  s.absarc(-1.3, 0.02, 0.5, 0.12, Math.PI - 0.12, false);
  s.closePath();
  return s;
}

function paint(colour: number): BufferGeometry {
  const p = new Parts();
  p.drawn(sideView(), 1.74, 0.055, colour);
  // A raised middle of the bonnet, shoulders over the doors, panels of the roof's frame.
  p.box([0.74, 0.655, -0.5], [1.66, 0.705, 0.5], 0.02, colour);
  p.boxes([-1.98, 0.56, 0.845], [0.7, 0.64, 0.885], 0.018, colour);
  const pillars: readonly [Point, Point, number][] = [
    [[0.67, 0.68, 0.775], [0.27, 1.2, 0.665], 0.042],
    [[-0.42, 0.68, 0.79], [-0.44, 1.2, 0.68], 0.05],
    [[-1.28, 0.68, 0.79], [-1.25, 1.2, 0.68], 0.05],
    [[-1.93, 0.68, 0.76], [-1.84, 1.2, 0.66], 0.06],
  ];
  for (const [a, b, radius] of pillars) p.bars(a, b, radius, colour, 10);
  p.box([-1.94, 1.18, -0.74], [0.34, 1.28, 0.74], 0.048, ROOF);
  p.box([-1.84, 1.26, -0.62], [0.2, 1.305, 0.62], 0.02, ROOF);
  // Mirrors.
  p.boxes([0.5, 0.72, 0.9], [0.6, 0.87, 1.06], 0.03, colour);
  return p.merged();
}

function glass(): BufferGeometry {
  const p = new Parts();
  p.taper(0.66, [-1.95, 0.67, 0.785], 1.21, [-1.87, 0.26, 0.675], 0x0a0d10);
  return p.merged();
}

/** Half a ring over a wheel: the flare of an arch. */
function flare(p: Parts, x: number): void {
  const arc = new Path().absarc(0, 0, 0.53, -0.05, Math.PI + 0.05, false);
  const inner = new Path().absarc(0, 0, 0.455, -0.05, Math.PI + 0.05, false);
  const shape = new Shape([...arc.getPoints(16), ...inner.getPoints(16).reverse()]);
  for (const side of [-1, 1]) {
    const strip = new Parts().drawn(shape, 0.13, 0.03, BLACK).merged();
    p.add(strip.translate(x, 0.02, side * 0.87), BLACK);
  }
}

function dark(): BufferGeometry {
  const p = new Parts();
  // Underside, wells of the wheels, sills.
  p.box([-1.9, -0.06, -0.52], [1.72, 0.52, 0.52], 0.04, BLACK);
  p.boxes([-0.78, -0.15, 0.74], [0.78, -0.07, 0.96], 0.03, BLACK);
  flare(p, 1.3);
  flare(p, -1.3);
  // Bumpers with their horns, grille, plate.
  p.box([1.8, -0.02, -0.86], [2.03, 0.17, 0.86], 0.05, GREY);
  p.boxes([1.93, 0.12, 0.3], [2.02, 0.3, 0.37], 0.03, GREY);
  p.bar([1.98, 0.29, -0.34], [1.98, 0.29, 0.34], 0.028, GREY);
  p.box([-2.17, 0.0, -0.84], [-1.94, 0.17, 0.84], 0.05, GREY);
  p.box([1.84, 0.25, -0.78], [1.885, 0.55, 0.78], 0.02, BLACK);
  for (let k = 0; k < 9; k++) {
    const z = -0.4 + 0.1 * k;
    p.box([1.875, 0.29, z - 0.016], [1.9, 0.51, z + 0.016], 0.006, GREY);
  }
  // Lines of the doors, handles, wipers, snorkel, mud flaps.
  for (const x of [0.6, -0.43, -1.22]) p.boxes([x - 0.007, -0.05, 0.866], [x + 0.007, 0.69, 0.875], 0, BLACK);
  for (const x of [-0.28, -1.07]) p.boxes([x - 0.09, 0.5, 0.87], [x + 0.09, 0.535, 0.905], 0.014, BLACK);
  p.bar([0.66, 0.73, 0.1], [0.44, 1.02, 0.5], 0.012, BLACK, 6);
  p.bar([0.66, 0.73, -0.5], [0.44, 1.02, -0.1], 0.012, BLACK, 6);
  p.bar([0.85, 0.6, 0.87], [0.72, 0.74, 0.89], 0.045, BLACK).bar(
    [0.72, 0.74, 0.89],
    [0.32, 1.24, 0.79],
    0.042,
    BLACK,
  );
  p.box([0.25, 1.22, 0.73], [0.4, 1.4, 0.86], 0.04, BLACK);
  for (const x of [0.76, -1.84]) p.boxes([x - 0.02, -0.32, 0.64], [x, 0.0, 0.9], 0, BLACK);
  rack(p);
  // The spare wheel on the back.
  p.add(
    tyre()
      .rotateY(Math.PI / 2)
      .translate(-2.14, 0.52, 0.14),
    BLACK,
  );
  p.lamp([-2.14, 0.52, 0.14], 0.21, 0.12, GREY).lamp([-2.24, 0.52, 0.14], 0.06, 0.06, BLACK);
  return p.merged();
}

function rack(p: Parts): void {
  const y = 1.4;
  for (const z of [-0.62, 0.62])
    p.bar([-1.75, y, z], [0.1, y, z], 0.018, BLACK).bar(
      [-1.75, y + 0.09, z],
      [0.1, y + 0.09, z],
      0.014,
      BLACK,
    );
  for (let k = 0; k < 7; k++) {
    const x = -1.75 + (1.85 * k) / 6;
    p.bar([x, y, -0.62], [x, y, 0.62], 0.013, BLACK, 6);
    if (k % 2 === 0) p.bars([x, 1.29, 0.62], [x, y + 0.09, 0.62], 0.014, BLACK, 6);
  }
  p.bar([0.1, y + 0.09, -0.62], [0.1, y + 0.09, 0.62], 0.014, BLACK).bar(
    [-1.75, y + 0.09, -0.62],
    [-1.75, y + 0.09, 0.62],
    0.014,
    BLACK,
  );
  // What it carries: a box, a rolled tent, cans, a shovel.
  p.box([-1.62, y + 0.02, -0.5], [-0.82, y + 0.27, 0.02], 0.05, 0x23292c);
  p.bar([-1.6, y + 0.12, 0.32], [-0.75, y + 0.12, 0.32], 0.12, 0x59603a, 14);
  p.box([-0.62, y + 0.02, 0.1], [-0.28, y + 0.34, 0.26], 0.035, 0x37452c);
  p.box([-0.62, y + 0.02, 0.3], [-0.28, y + 0.34, 0.46], 0.035, 0x37452c);
  p.bar([-0.7, y + 0.04, -0.3], [0.05, y + 0.04, -0.3], 0.018, 0x7a5a36);
  // Housings of the lamps on the rack.
  for (const z of [-0.45, -0.15, 0.15, 0.45]) p.lamp([0.14, y + 0.12, z], 0.085, 0.09, BLACK);
}

function metal(): BufferGeometry {
  const p = new Parts();
  for (const [x, y, z] of HEADLAMPS) p.ring([x - 0.005, y, z], 0.118, 0.018, STEEL);
  p.box([1.86, -0.1, -0.42], [1.9, 0.0, 0.42], 0.015, STEEL);
  p.bars([-0.78, -0.13, 0.985], [0.78, -0.13, 0.985], 0.03, STEEL);
  p.bar([-2.1, -0.04, -0.55], [-2.28, -0.06, -0.55], 0.035, STEEL, 12);
  p.box([-2.19, 0.04, -0.24], [-2.165, 0.14, 0.24], 0.005, 0xdadada);
  return p.merged();
}

function whiteLamps(): BufferGeometry {
  const p = new Parts();
  for (const at of HEADLAMPS) p.lamp(at, 0.108, 0.03, 0xffffff);
  for (const z of [-0.45, -0.15, 0.15, 0.45]) p.lamp([0.187, 1.52, z], 0.07, 0.012, 0xffffff);
  return p.merged();
}

function redLamps(): BufferGeometry {
  const p = new Parts();
  for (const [x, y, z] of TAILLAMPS)
    p.box([x - 0.02, y - 0.13, z - 0.07], [x + 0.02, y + 0.13, z + 0.07], 0.018, 0xff1408);
  p.box([-1.97, 1.21, -0.2], [-1.935, 1.245, 0.2], 0.01, 0xff1408);
  return p.merged();
}

/** A tyre about the z axis: radius 0.38 m, width 0.26 m; `fine`: with its tread. */
export function tyre(fine = true): BufferGeometry {
  const p = new Parts();
  const section: readonly [r: number, z: number][] = [
    [0.205, -0.1],
    [0.25, -0.122],
    [0.31, -0.13],
    [0.345, -0.122],
    [0.362, -0.1],
    [0.366, -0.05],
    [0.366, 0.05],
    [0.362, 0.1],
    [0.345, 0.122],
    [0.31, 0.13],
    [0.25, 0.122],
    [0.205, 0.1],
  ];
  const turned = new LatheGeometry(
    section.map(([r, z]) => new Vector2(r, z)),
    fine ? 36 : 28,
  );
  p.add(turned.rotateX(Math.PI / 2), 0x17181a);
  const LUGS = fine ? 20 : 0;
  for (let k = 0; k < LUGS; k++) {
    const angle = (2 * Math.PI * k) / LUGS;
    for (const [z, lean, shift] of [
      [-0.092, 0.35, 0],
      [0.092, -0.35, 0.5],
      [-0.03, -0.5, 0.5],
      [0.03, 0.5, 0],
    ] as const) {
      const lug = new BoxGeometry(0.022, 0.05, 0.062);
      const at = angle + (shift * 2 * Math.PI) / LUGS;
      lug.applyMatrix4(new Matrix4().makeRotationX(lean).setPosition(0.37, 0, z));
      p.add(lug.applyMatrix4(new Matrix4().makeRotationZ(at)), 0x1b1c1e);
    }
  }
  return p.merged();
}

/** A wheel about the z axis with its outside toward +z: tyre, rim, spokes, hub; `fine`: to be seen from near. */
export function wheelShape(fine = true): BufferGeometry {
  const p = new Parts();
  p.add(tyre(fine), 0x17181a);
  const dish: readonly [r: number, z: number][] = [
    [0.02, 0.055],
    [0.14, 0.03],
    [0.19, 0.05],
    [0.2, 0.1],
    [0.222, 0.112],
    [0.228, 0.1],
    [0.21, -0.1],
  ];
  const rim = new LatheGeometry(dish.map(([r, z]) => new Vector2(r, z)).reverse(), fine ? 28 : 20);
  p.add(rim.rotateX(Math.PI / 2), 0x70757a);
  for (let k = 0; k < 6; k++) {
    const spoke = new Parts()
      .box([0.05, -0.03, 0.03], [0.205, 0.03, 0.075], fine ? 0.012 : 0, STEEL)
      .merged();
    p.add(spoke.rotateZ((k * Math.PI) / 3), 0x9a9fa4);
  }
  p.add(
    new Parts()
      .lamp([0, 0, 0], 0.05, 0.06, STEEL)
      .merged()
      .rotateY(-Math.PI / 2)
      .translate(0, 0, 0.07),
    0x33363a,
  );
  return p.merged();
}

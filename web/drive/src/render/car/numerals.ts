/** Numbers of little bars, as seven of them make each digit, for dials. They stand upright and look along -x. */
import type { BufferGeometry } from "three";
import { Parts } from "./solid_parts";

/** Which bars a digit has: the upper one, clockwise to the upper left one, the middle one. */
const DIGITS = [
  "012345",
  "12",
  "01346",
  "01236",
  "1256",
  "02356",
  "023456",
  "012",
  "0123456",
  "012356",
] as const;
/** Middles of the bars in units of the height, to the right and up, and whether they stand. */
const BARS = [
  [0, 0.5, false],
  [0.25, 0.25, true],
  [0.25, -0.25, true],
  [0, -0.5, false],
  [-0.25, -0.25, true],
  [-0.25, 0.25, true],
  [0, 0, false],
] as const;
/** Half the thickness of a bar, half the length, and from digit to digit, in units of the height. */
const [HALF, LONG, PITCH] = [0.055, 0.27, 0.74];

/** A whole number from 0, `height` [m] high, about the origin; the right of the reader is +z. */
export function numeral(number: number, height: number): BufferGeometry {
  const p = new Parts();
  const digits = Array.from(String(number));
  digits.forEach((digit, n) => {
    const middle = (n - (digits.length - 1) / 2) * PITCH;
    for (const bar of DIGITS[Number(digit)]!) {
      const [right, up, stands] = BARS[Number(bar)]!;
      const [wide, high] = stands ? [HALF, LONG] : [LONG, HALF];
      const at = (side: number) =>
        [side * 0.02, up + side * high, middle + right + side * wide].map((a) => a * height);
      p.box(at(-1) as [number, number, number], at(1) as [number, number, number], 0, 0xffffff);
    }
  });
  return p.merged();
}

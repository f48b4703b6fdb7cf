import type { BoxStamp, Place } from "./stamps";

/** A foot on the ground; x, y, z is the middle of its sole [m]. */
export interface Foot extends Place {
  /** Direction of the toes: (cos, sin) in (x, z) [radians]. */
  readonly heading: number;
  /** From heel to toes [m]; 0.29 if left out. */
  readonly length?: number;
  /** Of the ball of the foot [m]; 0.11 if left out. */
  readonly width?: number;
  /** How far the heel is lifted above the sole's middle while the foot rolls off [m]; 0 if left out. */
  readonly heel?: number;
}

/** The parts of a sole along its length: from, to (-1/2 heel, 1/2 toes), width as a share, rise of the sole [lengths]. */
const PARTS = [
  { from: -0.5, to: -0.18, width: 0.72, rise: 0 },
  { from: -0.18, to: 0.1, width: 0.6, rise: 0.02 },
  { from: 0.1, to: 0.34, width: 1, rise: 0 },
  { from: 0.34, to: 0.5, width: 0.74, rise: 0.01 },
] as const;

/** Return the stamps of a foot: heel, arch, ball and toes, in one set of passes. */
export function footStamps(foot: Foot): BoxStamp[] {
  const { x, y, z, heading, length = 0.29, width = 0.11, heel = 0 } = foot;
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const slope = heel > 0 ? -heel / (0.5 * length) : 0;
  return PARTS.map((part) => {
    const along = 0.5 * (part.from + part.to) * length;
    return {
      shape: "box",
      x: x + c * along,
      y: y + part.rise * length + Math.max(0, slope * along),
      z: z + s * along,
      heading,
      length: (part.to - part.from) * length,
      width: part.width * width,
      slopeAlong: along < 0 ? slope : 0,
      slopeAcross: 0,
    };
  });
}

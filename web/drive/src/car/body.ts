/** The measures of the car, a small four-wheel-drive estate. Chassis frame: x forward, y up, z right, from the centre of mass. */

export const BODY = {
  length: 4.0,
  width: 1.7,
  /** Height of the lower part (doors) and of the cabin on top of it [m]. */
  hullHeight: 0.62,
  cabin: { length: 2.2, height: 0.5, width: 1.45, x: -0.3 },
  /** Underside below the centre of mass [m]. */
  underside: 0.34,
  /** Middle of the wheels below the centre of mass when the car stands on level ground [m]. */
  axle: 0.24,
  wheelbase: 2.6,
  track: 1.56,
  /** Length of an unloaded suspension, and how far it gives from there [m]. */
  restLength: 0.35,
  travel: 0.25,
  /** Drag area c_w A [m2], air at -5 degrees [kg/m3]. */
  dragArea: 0.85,
  airDensity: 1.3,
} as const;

export const GRAVITY = 9.81;

/** Share of critical damping of the suspension. */
export const DAMPING_RATIO = 0.42;

/** A wheel's place in the chassis frame: front left, front right, rear left, rear right. */
export const WHEELS = [
  { x: BODY.wheelbase / 2, z: -BODY.track / 2, front: true },
  { x: BODY.wheelbase / 2, z: BODY.track / 2, front: true },
  { x: -BODY.wheelbase / 2, z: -BODY.track / 2, front: false },
  { x: -BODY.wheelbase / 2, z: BODY.track / 2, front: false },
] as const;

/** Spring and damper of one wheel for a car of mass 1, as Rapier wants them, and how far the car's weight presses it. */
export interface Suspension {
  /** [1/s2] */
  readonly stiffness: number;
  /** [1/s] */
  readonly damping: number;
  /** [m] */
  readonly sag: number;
}

/** Four springs in parallel bounce with `frequency` [Hz]: 4 k / m = (2 pi f)^2 and 4 c / m = 2 zeta 2 pi f. */
export function suspension(frequency: number): Suspension {
  const omega = 2 * Math.PI * frequency;
  const stiffness = (omega * omega) / 4;
  return { stiffness, damping: (2 * DAMPING_RATIO * omega) / 4, sag: GRAVITY / (4 * stiffness) };
}

/** Principal moments of inertia of a box of 4.0 x 1.2 x 1.8 m about its middle [kg m2]. */
export function inertia(mass: number): { x: number; y: number; z: number } {
  const [l, h, w] = [BODY.length, 1.2, 1.8];
  return {
    x: (mass * (h * h + w * w)) / 12,
    y: (mass * (l * l + w * w)) / 12,
    z: (mass * (l * l + h * h)) / 12,
  };
}

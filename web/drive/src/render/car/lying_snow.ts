/** How much snow lies on a car: it gathers where the car digs through deep snow, and blows off slowly. */
import type { CarPose } from "./car_pose";

/** Rates at which it gathers, at most, and at which it blows off [1/s]; what stays in the corners, 0..1. */
const GATHERS = 0.06;
const LEAVES = 0.004;
const STAYS = 0.25;
/** Ruts so deep [m], and a speed [m/s], throw up all the snow that can be thrown. */
const DEEP = 0.15;
const FAST = 6;

/** The share 0..1 of what can lie on a car that lies there dt [s] later; exact, in however many parts dt is taken. */
export function snowedAfter(snowed: number, dt: number, { wheels, velocity }: CarPose): number {
  const deep = wheels.reduce((sum, w) => sum + (w.grounded ? w.sinkage : 0), 0) / wheels.length;
  const gathers = GATHERS * Math.min(1, deep / DEEP) * Math.min(1, Math.hypot(...velocity) / FAST);
  const end = (gathers + LEAVES * STAYS) / (gathers + LEAVES);
  return end + (snowed - end) * Math.exp(-(gathers + LEAVES) * dt);
}

/** What the driver does, whatever the device. */
export interface Controls {
  /** -1 full left .. 1 full right. */
  steer: number;
  /** 0..1 */
  throttle: number;
  brake: number;
  handbrake: number;
  /** Put the car upright where it stands. */
  reset: boolean;
}

export const HANDS_OFF: Readonly<Controls> = { steer: 0, throttle: 0, brake: 0, handbrake: 0, reset: false };

const within = (low: number, high: number, x: number): number =>
  x >= low ? Math.min(x, high) : x < low ? low : 0;

/** Controls within their ranges; what is not a number counts as 0. */
export function clean(raw: Controls): Controls {
  return {
    steer: within(-1, 1, raw.steer),
    throttle: within(0, 1, raw.throttle),
    brake: within(0, 1, raw.brake),
    handbrake: within(0, 1, raw.handbrake),
    reset: raw.reset,
  };
}

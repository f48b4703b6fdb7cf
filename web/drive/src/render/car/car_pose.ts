/** What the picture needs to know of the car: a part of the car's state. */
export interface WheelPose {
  /** Middle of the wheel [m]. */
  readonly centre: readonly [number, number, number];
  /** Steering angle and angle turned about the axle [rad]. */
  readonly steer: number;
  readonly spin: number;
  readonly radius: number;
  readonly width: number;
  /** Circumference minus ground speed [m/s]. */
  readonly slip: number;
  /** How deep the wheel stands in the snow [m]. */
  readonly sinkage: number;
  readonly grounded: boolean;
}

export interface CarPose {
  readonly position: readonly [number, number, number];
  /** Quaternion. */
  readonly rotation: readonly [number, number, number, number];
  /** [m/s] */
  readonly velocity: readonly [number, number, number];
  readonly wheels: readonly WheelPose[];
}

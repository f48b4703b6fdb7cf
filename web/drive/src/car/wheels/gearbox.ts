/** Engine and gears: what the driver wants, the gear that follows from the speed, and the torque for the wheels. */
import type { Controls } from "../driver/controls";

/** Speed of the wheels' circumference at which the engine turns fastest, for each gear [m/s]. */
const TOP = [9, 16, 24, 34, 46, 62] as const;
/** A gear is left downwards when the one below would turn at less than this share of its top. */
const DOWN = 0.72;
/** Time without power while gears change [s]. */
const PAUSE = 0.12;
/** Greatest force of the engine at the wheels in first gear, as a share of the car's weight. */
const LAUNCH = 0.8;
/** Below this speed the car stands [m/s]; the brake pedal, held for so long [s], then means backwards. */
const STANDING = 0.3;
const HELD = 0.4;
/** Top speed backwards [m/s]. */
const REVERSE_TOP = 9;
/** Force of engine braking as a share of the weight. */
const COASTING = 0.02;
/** Deceleration that the pedal asks for at most [m/s2]. */
const BRAKING = 9;

/** What the pedals mean: force of the engine at the wheels, signed, and of the brakes [N], all wheels together. */
export interface Demand {
  readonly drive: number;
  readonly brake: number;
}

export class Gearbox {
  /** -1 backwards, 1..6 forwards. */
  gear = 1;
  private pause = 0;
  private held = 0;

  /** Name of the gear for the dash. */
  get name(): string {
    return this.gear < 0 ? "R" : String(this.gear);
  }

  /**
   * The forces for this step. `speed` of the car forward and `rim` speed of the driven wheels [m/s]; power [W]. The
   * engine gives force F with F |rim| <= power, whatever the gear: the driver's car has a gear for every speed.
   */
  demand(
    controls: Controls,
    speed: number,
    rim: number,
    car: { mass: number; power: number },
    dt: number,
  ): Demand {
    const { throttle, brake } = controls;
    this.pause = Math.max(0, this.pause - dt);
    if (this.gear < 0 && throttle > 0.05 && speed > -STANDING) this.change(1);
    this.held = brake > 0.05 && throttle < 0.05 && speed < STANDING ? this.held + dt : 0;
    if (this.gear > 0 && this.held > HELD) this.change(-1);
    const backwards = this.gear < 0;
    const gas = backwards ? brake : throttle;
    const pedal = backwards ? throttle : brake;
    if (!backwards) this.shift(speed);
    const weight = 9.81 * car.mass;
    const along = backwards ? -rim : rim;
    const top = backwards ? REVERSE_TOP : 1.1 * TOP[this.gear - 1]!;
    const most = Math.min(LAUNCH * weight, car.power / Math.max(Math.abs(rim), 1e-3));
    // Near the top of the gear, be it that the wheels spin, the governor takes the gas away.
    const governed = Math.min(1, Math.max(0, (top - along) / (0.05 * top)));
    const force = this.pause > 0 ? 0 : gas * governed * most;
    const coast = COASTING * weight * (1 - gas) * Math.tanh(along / 0.5);
    return { drive: (backwards ? -1 : 1) * (force - coast), brake: pedal * BRAKING * car.mass };
  }

  /** Speed of the engine as a share of its greatest, for the ear and the eye. */
  revs(rim: number): number {
    const top = this.gear < 0 ? REVERSE_TOP : TOP[this.gear - 1]!;
    return Math.min(1, Math.max(0.12, Math.abs(rim) / top));
  }

  private shift(speed: number): void {
    const now = this.gear - 1;
    if (this.pause > 0) return;
    if (now < TOP.length - 1 && speed > 0.9 * TOP[now]!) this.change(this.gear + 1);
    else if (now > 0 && speed < DOWN * TOP[now - 1]!) this.change(this.gear - 1);
  }

  private change(gear: number): void {
    this.gear = gear;
    this.pause = PAUSE;
  }
}

/** Greatest steering angle at a speed [rad]: what a sideways acceleration of 6 m/s2 needs, and a little for the slide. */
export function steeringLimit(speed: number, wheelbase: number): number {
  return Math.min(0.6, 0.05 + Math.atan((6 * wheelbase) / Math.max(1, speed * speed)));
}

/**
 * One tyre on a firm surface. The rubber (and the snow that it holds) is a spring that is dragged along the ground:
 * du/dt = v_slip - |v| u / L. Rolling, u settles at L times the slip ratio, which gives the rising part of a slip
 * curve; standing, u is an anchor, so that a braked car does not creep. This is the relaxation length model of tyre
 * dynamics (Pacejka, Tire and Vehicle Dynamics, chapter 7). The spin of the wheel is integrated implicitly, because
 * the spring is stiff for the little inertia of a wheel.
 */

/** Relaxation length [m]. */
const RELAXATION = 0.3;
/** Slip ratio at which the tyre holds most. */
export const PEAK_SLIP = 0.12;
/** Share of the grip that a tyre loses when it slides fast, and the speed of sliding at which 63 % of that is gone [m/s]. */
const SLIDING_LOSS = 0.25;
const SLIDING_SPEED = 4;
/** Damping of the anchor at rest [s]; it fades with speed, where rolling damps. */
const DAMPING_TIME = 0.03;

/** What changes from step to step. */
export interface Tyre {
  /** Speed of rotation, positive when it rolls forward [rad/s]. */
  omega: number;
  /** Deflection of the contact along and across the heading [m]. */
  along: number;
  across: number;
}

/** What acts on the tyre during a step. */
export interface Footing {
  /** [N] */
  readonly load: number;
  /** Speed of the contact point over the ground along the heading and to the right [m/s]. */
  readonly forward: number;
  readonly right: number;
  /** Greatest friction along and across the heading, as a share of the load. */
  readonly friction: number;
  readonly sideFriction: number;
  /** What walls of snow add to the sideways hold when the wheel is pushed to the left or to the right [N]. */
  readonly holdLeft: number;
  readonly holdRight: number;
  /** [m] */
  readonly radius: number;
  /** [kg m2] */
  readonly inertia: number;
  /** Torque of the engine and greatest torque of the brakes [N m]. */
  readonly drive: number;
  readonly brake: number;
}

/** Forces of the ground on the wheel [N] and the speed of its circumference minus that of the ground [m/s]. */
export interface Traction {
  forward: number;
  right: number;
  slip: number;
}

/** Rising part of the slip curve: 0 at 0, level at 1 where the grip is full (brush-like cubic). */
export function slipCurve(x: number): number {
  return x >= 1 ? 1 : x * (1.5 - 0.5 * x * x);
}

/** Share of the full grip that is left at a speed of sliding [m/s]. */
export function slidingGrip(speed: number): number {
  return 1 - SLIDING_LOSS * -Math.expm1(-Math.abs(speed) / SLIDING_SPEED);
}

interface Contact {
  forward: number;
  right: number;
  along: number;
  across: number;
}

const now: Contact = { forward: 0, right: 0, along: 0, across: 0 };

/** The forces if the wheel turns with `omega` at the end of the step; the same object each time. */
function contact(tyre: Tyre, on: Footing, omega: number, dt: number): Contact {
  const slip = on.radius * omega - on.forward;
  const speed = Math.max(Math.abs(on.forward), Math.abs(on.radius * tyre.omega));
  const rolls = 1 + (dt * speed) / RELAXATION;
  const full = PEAK_SLIP * RELAXATION;
  let along = (tyre.along + dt * slip) / rolls;
  let across = (tyre.across - dt * on.right) / rolls;
  const over = Math.hypot(along, across) / full;
  if (over > 1) {
    along /= over;
    across /= over;
  }
  const damping = DAMPING_TIME / (1 + speed);
  const a = (along + damping * slip) / full;
  const b = (across - damping * on.right) / full;
  const rho = Math.hypot(a, b);
  const grip = rho > 0 ? (slipCurve(rho) * slidingGrip(Math.hypot(slip, on.right))) / rho : 0;
  now.along = along;
  now.across = across;
  now.forward = on.load * on.friction * grip * a;
  // A force to the right answers a push to the left, against the wall on the left, and the other way round.
  now.right = (on.load * on.sideFriction + (b > 0 ? on.holdLeft : on.holdRight)) * grip * b;
  return now;
}

/** Turn the wheel for dt [s]: the tyre is changed, the forces of the ground are returned. */
export function roll(tyre: Tyre, on: Footing, dt: number): Traction {
  // What is left of the balance of torques, I (omega' - omega) / dt = drive - R F(omega'), without the brake.
  const left = (omega: number) =>
    (on.inertia * (omega - tyre.omega)) / dt - on.drive + on.radius * contact(tyre, on, omega, dt).forward;
  const atRest = left(0);
  let omega = 0;
  if (Math.abs(atRest) > on.brake) {
    // The brake cannot hold the wheel: it turns against the sign of what is left, and the brake works against it.
    const brake = atRest < 0 ? -on.brake : on.brake;
    const reach =
      Math.abs(tyre.omega) +
      (dt * (Math.abs(on.drive) + on.brake + on.radius * on.load * on.friction)) / on.inertia +
      1;
    let [low, high] = atRest < 0 ? [0, reach] : [-reach, 0];
    for (let i = 0; i < 36; i++) {
      omega = 0.5 * (low + high);
      if (left(omega) - brake > 0) high = omega;
      else low = omega;
    }
  }
  const { forward, right, along, across } = contact(tyre, on, omega, dt);
  tyre.omega = omega;
  tyre.along = along;
  tyre.across = across;
  return { forward, right, slip: on.radius * omega - on.forward };
}

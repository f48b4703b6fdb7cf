/** What keys, gamepad and thumbs mean, and how they become one smooth set of controls. No device is touched here. */
import { clean, HANDS_OFF, type Controls } from "./controls";

/** A gamepad as browsers give it, in the standard mapping. */
export interface Pad {
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly value: number; readonly pressed: boolean }[];
}

/** Thumbs on the screen: how far each was moved from where it was put down, in the size of its zone, y upwards. */
export interface Thumbs {
  readonly left: number | null;
  readonly right: number | null;
}

/** Things that happen once for each press. */
export interface Presses {
  reset: boolean;
  camera: boolean;
  lights: boolean;
  /** Only a key does it. */
  figures: boolean;
}

/** Below this share a stick counts as let go. */
export const DEAD_ZONE = 0.12;

/** Controls that some keys ask for; keys as `KeyboardEvent.code` names them. */
export function fromKeys(keys: ReadonlySet<string>): Controls {
  const any = (...names: string[]) => (names.some((name) => keys.has(name)) ? 1 : 0);
  return {
    steer: any("KeyD", "ArrowRight") - any("KeyA", "ArrowLeft"),
    throttle: any("KeyW", "ArrowUp"),
    brake: any("KeyS", "ArrowDown"),
    handbrake: any("Space"),
    reset: keys.has("KeyR"),
  };
}

/** A stick without its dead zone: 0 inside, then even up to 1 at the rim. */
export function alive(axis: number): number {
  const size = Math.abs(axis);
  return size <= DEAD_ZONE || !Number.isFinite(axis)
    ? 0
    : (Math.sign(axis) * Math.min(1, size - DEAD_ZONE)) / (1 - DEAD_ZONE);
}

/** Controls of a gamepad: left stick steers, triggers drive and brake, A or the right bumper is the handbrake, Y resets. */
export function fromPad(pad: Pad): Controls {
  const value = (index: number) => pad.buttons[index]?.value ?? 0;
  const stick = alive(pad.axes[0] ?? 0);
  return {
    // Fine near the middle, quick at the rim.
    steer: stick * (0.4 + 0.6 * Math.abs(stick)),
    throttle: value(7),
    brake: value(6),
    handbrake: Math.max(value(0), value(5)),
    reset: value(3) > 0.5,
  };
}

/** Controls of two thumbs: the left one steers, the right one drives upwards and brakes downwards. */
export function fromThumbs({ left, right }: Thumbs): Controls {
  const pull = 2.5 * (right ?? 0);
  return {
    ...HANDS_OFF,
    steer: 2.5 * (left ?? 0),
    throttle: Math.max(0, pull),
    brake: Math.max(0, -pull),
  };
}

/** One set of controls of several: who steers most steers, who presses most presses. */
export function merge(...several: readonly Controls[]): Controls {
  const all = several.map(clean);
  const most = (of: (one: Controls) => number) => all.reduce((m, one) => Math.max(m, of(one)), 0);
  return {
    steer: all.reduce((m, { steer }) => (Math.abs(steer) > Math.abs(m) ? steer : m), 0),
    throttle: most(({ throttle }) => throttle),
    brake: most(({ brake }) => brake),
    handbrake: most(({ handbrake }) => handbrake),
    reset: all.some(({ reset }) => reset),
  };
}

/** How fast smoothed controls move [1/s]: away from rest, and back to it. */
const RATES = { steer: [2.2, 4.5], throttle: [3.5, 7], brake: [4, 8], handbrake: [10, 10] } as const;

/** Controls that follow what is asked for at limited rates, so that keys drive as gently as sticks. */
export class Smoothing {
  private now: Controls = { ...HANDS_OFF };

  /** Move on by dt [s] towards `asked`. */
  follow(asked: Controls, dt: number): Controls {
    const wanted = clean(asked);
    const next = { ...wanted };
    for (const name of ["steer", "throttle", "brake", "handbrake"] as const) {
      const [out, back] = RATES[name];
      const [from, to] = [this.now[name], wanted[name]];
      const rate = from * (to - from) < 0 ? back : out;
      const most = rate * Math.max(0, dt);
      next[name] = from + Math.min(most, Math.max(-most, to - from));
    }
    this.now = next;
    return { ...next };
  }
}

/** Presses since the last reading: true in the first reading that finds the thing held. */
export class Edges {
  private held: Presses = { reset: false, camera: false, lights: false, figures: false };

  update(now: Presses): Presses {
    const before = this.held;
    this.held = { ...now };
    return {
      reset: now.reset && !before.reset,
      camera: now.camera && !before.camera,
      lights: now.lights && !before.lights,
      figures: now.figures && !before.figures,
    };
  }
}

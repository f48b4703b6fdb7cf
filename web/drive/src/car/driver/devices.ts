/** Keyboard, gamepads, thumbs and mouse of a page. */
import "./touch.css";
import type { CameraInput } from "./cameras";
import type { Controls } from "./controls";
import { Edges, fromKeys, fromPad, fromThumbs, merge, Smoothing, type Pad, type Presses } from "./input";

/** Keys that scroll the page or press a button if they are let through. */
const OURS = new Set(["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Space"]);
/** How far the camera turns for a drag over the whole height of the canvas [rad]. */
const DRAG = Math.PI;

/** Presses that only keys have. */
export interface KeyPresses {
  photo: boolean;
  save: boolean;
  course: boolean;
  sound: boolean;
  /** Times that the lens was narrowed (negative) or widened. */
  lens: number;
}

/** Whether a key is meant for the page: not typed into the panel, and no shortcut of the browser. */
export function isOurs({ target, ctrlKey, metaKey, altKey }: KeyboardEvent): boolean {
  const typed = target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
  return !typed && !ctrlKey && !metaKey && !altKey;
}

export class Devices {
  private readonly keys = new Set<string>();
  /** Keys that went down since the last reading: a tap shorter than a frame counts too. */
  private readonly tapped = new Set<string>();
  private readonly smoothing = new Smoothing();
  private readonly edges = new Edges();
  private readonly leave = new AbortController();
  private readonly left: Thumb;
  private readonly right: Thumb;
  private drag = { x: 0, y: 0, zoom: 0 };

  /** Listen to the page; mouse and wheel on `canvas`. The thumbs' zones are laid over `page`. */
  constructor(canvas: HTMLElement, page: HTMLElement = document.body) {
    const { signal } = this.leave;
    addEventListener("keydown", (event) => this.press(event), { signal });
    addEventListener("keyup", ({ code }) => this.keys.delete(code), { signal });
    // Without the focus, no key would ever be let go.
    addEventListener("blur", () => this.keys.clear(), { signal });
    this.left = new Thumb(page, "left", signal);
    this.right = new Thumb(page, "right", signal);
    this.watchPointers(canvas, signal);
  }

  /** What is asked for now, smoothed over dt [s], and what was pressed since the last call. */
  read(dt: number): { controls: Controls; presses: Presses & KeyPresses } {
    const pads = (navigator.getGamepads?.() ?? []).filter(
      (pad) => pad !== null && pad.mapping === "standard",
    );
    const thumbs = fromThumbs({ left: this.left.x, right: this.right.y });
    const tapped = new Set(this.tapped);
    const keys = new Set([...this.keys, ...tapped]);
    this.tapped.clear();
    const asked = merge(fromKeys(keys), thumbs, ...pads.map((pad) => fromPad(pad as Pad)));
    const button = (index: number) => pads.some((pad) => pad?.buttons[index]?.pressed);
    const pressed = this.edges.update({
      reset: asked.reset,
      camera: button(2),
      lights: button(1),
      figures: false,
    });
    // A key that goes down is a press by itself.
    const presses = {
      ...pressed,
      camera: pressed.camera || tapped.has("KeyC"),
      lights: pressed.lights || tapped.has("KeyL"),
      figures: tapped.has("KeyF"),
      photo: tapped.has("KeyP"),
      save: tapped.has("Enter"),
      course: tapped.has("KeyT"),
      sound: tapped.has("KeyN"),
      lens: Number(tapped.has("BracketRight")) - Number(tapped.has("BracketLeft")),
    };
    return { controls: this.smoothing.follow(asked, dt), presses };
  }

  /** How the camera was dragged and zoomed since the last call, and how the keys I J K O U M move it. */
  readCamera(): CameraInput {
    const { x, y, zoom } = this.drag;
    this.drag = { x: 0, y: 0, zoom: 0 };
    const axis = (more: string, less: string) =>
      (this.keys.has(more) ? 1 : 0) - (this.keys.has(less) ? 1 : 0);
    return {
      turn: x,
      tilt: y,
      zoom,
      ahead: axis("KeyI", "KeyK"),
      right: axis("KeyO", "KeyU"),
      up: axis("KeyJ", "KeyM"),
    };
  }

  /** Stop listening. */
  dispose(): void {
    this.leave.abort();
    this.left.zone.remove();
    this.right.zone.remove();
  }

  private press(event: KeyboardEvent): void {
    if (!isOurs(event)) return;
    if (OURS.has(event.code)) event.preventDefault();
    this.keys.add(event.code);
    if (!event.repeat) this.tapped.add(event.code);
  }

  private watchPointers(canvas: HTMLElement, signal: AbortSignal): void {
    const down = new Map<number, { x: number; y: number }>();
    /** How far two fingers are apart [pixels]; null if it is not two. */
    const span = () => {
      const [a, b, more] = [...down.values()];
      return a && b && !more ? Math.max(1, Math.hypot(a.x - b.x, a.y - b.y)) : null;
    };
    const press = ({ pointerId, clientX, clientY }: PointerEvent) => {
      canvas.setPointerCapture(pointerId);
      down.set(pointerId, { x: clientX, y: clientY });
    };
    const move = ({ pointerId, clientX, clientY }: PointerEvent) => {
      const from = down.get(pointerId);
      if (!from) return;
      const apart = span();
      down.set(pointerId, { x: clientX, y: clientY });
      if (apart !== null) this.drag.zoom += Math.log(apart / span()!);
      if (down.size > 1) return;
      const scale = DRAG / Math.max(1, canvas.clientHeight);
      this.drag.x += (clientX - from.x) * scale;
      this.drag.y += (clientY - from.y) * scale;
    };
    canvas.addEventListener("pointerdown", press, { signal });
    canvas.addEventListener("pointermove", move, { signal });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(end, ({ pointerId }) => down.delete(pointerId), { signal });
    const zoom = (event: WheelEvent) => {
      event.preventDefault();
      this.drag.zoom += event.deltaY / 500;
    };
    canvas.addEventListener("wheel", zoom, { signal, passive: false });
  }
}

/** A zone of the screen for one thumb. */
class Thumb {
  readonly zone: HTMLElement;
  /** Way of the thumb from where it was put down, in the size of the zone; null while it is up. */
  x: number | null = null;
  y: number | null = null;

  constructor(page: HTMLElement, side: "left" | "right", signal: AbortSignal) {
    this.zone = document.createElement("div");
    this.zone.className = `thumb ${side}`;
    page.append(this.zone);
    let start = { x: 0, y: 0 };
    const lift = () => {
      this.x = this.y = null;
      this.zone.classList.remove("held");
    };
    this.zone.addEventListener(
      "pointerdown",
      (event) => {
        this.zone.setPointerCapture(event.pointerId);
        this.zone.classList.add("held");
        start = { x: event.clientX, y: event.clientY };
        this.x = this.y = 0;
      },
      { signal },
    );
    this.zone.addEventListener(
      "pointermove",
      (event) => {
        if (this.x === null) return;
        this.x = (event.clientX - start.x) / Math.max(1, this.zone.clientWidth);
        this.y = (start.y - event.clientY) / Math.max(1, this.zone.clientHeight);
      },
      { signal },
    );
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      this.zone.addEventListener(end, lift, { signal });
    }
  }
}

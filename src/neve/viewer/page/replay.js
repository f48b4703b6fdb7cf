// A replay: the same stage, fed from the file itself.

/** @import { Command } from "./commands.js" */
/** @import { ReplayHead } from "./protocol.js" */
/** @import { State } from "./draw/snow_cloud.js" */

import { Bar } from "./controls/bar.js";
import { byId, caption, select } from "./controls/dom.js";
import { capture, dragCamera, listenToWheel } from "./tools/pointer.js";
import { OrbitCamera } from "./draw/camera.js";
import { V } from "./draw/math.js";
import { Stage } from "./draw/stage.js";
import { MOST } from "./protocol.js";
import { unpack } from "./unpack.js";

const FAST = 10; // speed of the last colour [m/s]

class Replay {
  /** @param {ReplayHead} head */
  constructor(head) {
    this.scene = head;
    /** @type {HTMLCanvasElement} */
    this.canvas = byId("view");
    this.stage = new Stage(this.canvas);
    this.camera = new OrbitCamera();
    this.camera.set(head.camera);
    this.stage.setScene(head);
    this.frame = 0;
    this.playing = false;
    this.speed = 1;
    this.mode = "snow";
    this.stale = true; // the stage shows another moment
    this.dirty = true; // the picture is older than the stage
    this.drawn = 0;
    this.last = performance.now();
    /** @type {Uint16Array[]} positions of each key: x of all, then y, then z */
    this.keys = [];
    this.q = new Uint16Array(4 * head.n);
    this.bar = new Bar(this);
    this.bar.frame.hidden = this.bar.record.hidden = true;
    const onchange = () => {
      this.mode = mode.value;
      this.stale = true;
    };
    const mode = select(
      { id: "mode", onchange },
      head.modes.map((m) => [m.name, m.label]),
    );
    this.bar.root.insertBefore(mode, this.bar.timeline);
    this.showPlayer();
    this.listenToPointer();
    this.listenToKeys();
    document.title = `${head.name} · Neve replay`;
    caption(head.caption);
  }

  showPlayer() {
    const { frames } = this.scene;
    const state = {
      playing: this.playing,
      speed: this.speed,
      frames,
      recording: false,
      recorded: frames,
      undo: "",
      redo: "",
    };
    this.bar.show(state, false);
  }

  /**
   * Obey the bar.
   * @param {Command} command
   */
  send(command) {
    if (command.do === "play" || command.do === "pause") this.playing = command.do === "play";
    else if (command.do === "restart") this.frame = 0;
    else if (command.do === "seek") this.frame = command.frame ?? 0;
    else if (command.do === "speed") this.speed = command.factor;
    this.stale = true;
    this.showPlayer();
  }

  /** @param {string} text the packed positions in base64 */
  async load(text) {
    const bytes = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const raw = new Uint8Array(await new Response(stream).arrayBuffer());
    this.keys = unpack(raw, this.scene.n, this.scene.keys);
    this.playing = true;
    this.showPlayer();
    byId("cover").classList.add("gone");
    this.last = performance.now();
    requestAnimationFrame(() => this.loop());
  }

  loop() {
    const now = performance.now();
    const seconds = Math.min(0.25, (now - this.last) / 1000);
    this.last = now;
    if (this.playing) this.goOn(seconds);
    if (this.stale) this.show(Math.min(this.frame, this.scene.frames - 1));
    if (this.camera.fly(seconds)) this.dirty = true;
    if (this.stage.resize()) this.dirty = true;
    if (this.dirty || this.stale) {
      this.dirty = this.stale = false;
      this.camera.update(this.canvas.width, this.canvas.height);
      this.stage.draw(this.camera);
      this.bar.pictures.add();
      this.drawn += 1;
      document.body.dataset.drawn = String(this.drawn);
    }
    requestAnimationFrame(() => this.loop());
  }

  /**
   * Play in a circle, with a second's rest at the end.
   * @param {number} seconds
   */
  goOn(seconds) {
    const { fps, frames } = this.scene;
    this.frame += seconds * fps * this.speed;
    if (this.frame > frames + fps) this.frame = 0;
    this.stale = true;
  }

  /**
   * Show a moment.
   * @param {number} frame also between two frames
   */
  show(frame) {
    const { n, low, step, times, frames } = this.scene;
    this.place(frame);
    const whole = Math.min(Math.floor(frame), frames - 1);
    const next = Math.min(whole + 1, frames - 1);
    const share = frame - whole;
    const poses = this.scene.poses[share < 0.5 ? whole : next].map((pose, i) => {
      const [from, to] = [this.scene.poses[whole][i], this.scene.poses[next][i]];
      return [...V.mix([from[0], from[1], from[2]], [to[0], to[1], to[2]], share), ...pose.slice(3)];
    });
    /** @type {State} */
    const state = {
      kind: "state",
      version: 0,
      scene: 0,
      n,
      low,
      step,
      q: this.q,
      mode: this.mode,
      limits: [0, FAST],
      log: false,
      classes: false,
      time: times[whole] + share * (times[next] - times[whole]),
      frame: Math.round(frame),
      poses,
      facts: {},
    };
    this.stage.show(state);
    this.bar.showState(state);
    document.body.dataset.time = String(state.time);
  }

  /**
   * Put the particles on the lines between two keys; their value is the speed, and none where snow is drawn: it is dry.
   * @param {number} frame
   */
  place(frame) {
    const { keys, n, step, fps } = this.scene;
    let k = 0;
    while (k + 2 < keys.length && keys[k + 1] <= frame) k++;
    const last = Math.min(k + 1, keys.length - 1);
    const [a, b] = [this.keys[k], this.keys[last]];
    const span = Math.max(1, keys[last] - keys[k]);
    const t = Math.min(1, Math.max(0, (frame - keys[k]) / span));
    const value = this.mode === "snow" ? 0 : (MOST * step[0] * fps) / (FAST * span);
    const { q } = this;
    for (let i = 0; i < n; i++) {
      const [x, y, z] = [a[i], a[n + i], a[2 * n + i]];
      if (x + y + z === 3 * MOST) {
        q[4 * i] = q[4 * i + 1] = q[4 * i + 2] = MOST;
        continue;
      }
      const gone = b[i] + b[n + i] + b[2 * n + i] === 3 * MOST;
      const [dx, dy, dz] = gone ? [0, 0, 0] : [b[i] - x, b[n + i] - y, b[2 * n + i] - z];
      q[4 * i] = x + t * dx;
      q[4 * i + 1] = y + t * dy;
      q[4 * i + 2] = z + t * dz;
      q[4 * i + 3] = Math.min(MOST, value * Math.hypot(dx, dy, dz));
    }
  }

  listenToPointer() {
    const { canvas, camera } = this;
    /** @type {{ x: number, y: number, kind: "turn" | "pan" } | null} */
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      held = {
        x: event.clientX,
        y: event.clientY,
        kind: event.button !== 0 || event.shiftKey ? "pan" : "turn",
      };
      capture(canvas, event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      dragCamera(camera, held.kind, event.clientX - held.x, event.clientY - held.y, canvas.clientHeight);
      held.x = event.clientX;
      held.y = event.clientY;
      this.dirty = true;
    });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, () => (held = null));
    listenToWheel(canvas, camera, () => (this.dirty = true));
  }

  listenToKeys() {
    window.addEventListener("keydown", (event) => {
      const key = event.key.toLowerCase();
      if (key === " ") {
        event.preventDefault();
        this.bar.toggle();
      } else if (key === "r") this.send({ do: "restart" });
      else if (key === "h") {
        this.camera.set(this.scene.camera);
        this.dirty = true;
      }
      this.camera.keys.add(key);
    });
    window.addEventListener("keyup", (event) => this.camera.keys.delete(event.key.toLowerCase()));
  }
}

try {
  const replay = new Replay(JSON.parse(byId("head").textContent ?? ""));
  Object.assign(window, { neve: replay }); // for the browser's console and the tests
  await replay.load(byId("data").textContent ?? "");
} catch (error) {
  byId("cover").textContent =
    `this browser cannot play the replay: ${error instanceof Error ? error.message : error}`;
  throw error;
}

"use strict";
// A replay: the same stage, fed from the file itself. src/neve/viewer/replay.py says how the data are packed.

class Replay {
  constructor(head) {
    this.scene = head, this.head = head;
    this.canvas = document.getElementById("view");
    this.stage = new Stage(this.canvas);
    this.camera = new Camera();
    this.camera.set(head.camera);
    head.live = false;
    head.modes = [{ name: "snow", label: "snow", palette: "ice" }, { name: "speed", label: "speed", unit: "m/s", palette: "ice", classes: false }];
    this.stage.stage(head);
    this.frame = 0, this.playing = false, this.pace = 1, this.mode = "snow";
    this.keys = [];
    this.bar = new Bar(this);
    this.bar.frame.hidden = this.bar.record.hidden = true;
    const mode = make("select", { id: "mode", onchange: () => ((this.mode = mode.value), (this.stale = true)) },
      make("option", { value: "snow" }, "snow"), make("option", { value: "speed" }, "speed"));
    this.bar.root.insertBefore(mode, this.bar.timeline);
    this.bar.show(this.state(), false);
    this.pointer();
    document.title = `${head.name} · Neve replay`;
  }

  state() {
    return { playing: this.playing, speed: this.pace, frames: this.head.frames, recording: false };
  }

  // What the bar asks for.
  send(wish) {
    if (wish.do === "play" || wish.do === "pause") this.playing = wish.do === "play";
    else if (wish.do === "restart") this.frame = 0;
    else if (wish.do === "seek") this.frame = wish.frame;
    else if (wish.do === "speed") this.pace = wish.factor;
    this.stale = true;
    this.bar.show(this.state(), false);
  }

  async load(text) {
    const bytes = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const raw = new Uint8Array(await new Response(stream).arrayBuffer());
    this.keys = unpack(raw, this.head.n, this.head.keys);
    this.q = new Uint16Array(4 * this.head.n);
    this.stale = true;
    this.playing = true;
    this.bar.show(this.state(), false);
    document.getElementById("cover").classList.add("gone");
    this.last = performance.now();
    requestAnimationFrame(() => this.loop());
  }

  loop() {
    const now = performance.now(), seconds = Math.min(0.25, (now - this.last) / 1000);
    this.last = now;
    if (this.playing) {
      this.frame += seconds * this.head.fps * this.pace;
      if (this.frame >= this.head.frames - 1) this.frame = this.frame > this.head.frames + this.head.fps ? 0 : this.frame;
      this.stale = true;
    }
    if (this.stale) this.show(Math.min(this.frame, this.head.frames - 1));
    if (this.camera.fly(seconds)) this.dirty = true;
    const width = Math.round(this.canvas.clientWidth * (this.stage.software ? 0.7 : Math.min(devicePixelRatio, 2)));
    const height = Math.round(this.canvas.clientHeight * (this.stage.software ? 0.7 : Math.min(devicePixelRatio, 2)));
    if (this.canvas.width !== width || this.canvas.height !== height) (this.canvas.width = width), (this.canvas.height = height), (this.dirty = true);
    if (this.dirty || this.stale) {
      this.dirty = this.stale = false;
      this.camera.update(width, height);
      this.stage.draw(this.camera);
      this.bar.drawn.push(now);
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn || 0) + 1);
    }
    this.bar.tick();
    requestAnimationFrame(() => this.loop());
  }

  // Show a moment between two keys.
  show(frame) {
    const { keys, times, n, step } = this.head;
    let k = 0;
    while (k + 2 < keys.length && keys[k + 1] <= frame) k++;
    const a = this.keys[k], b = this.keys[Math.min(k + 1, keys.length - 1)], span = Math.max(1, keys[Math.min(k + 1, keys.length - 1)] - keys[k]);
    const t = Math.min(1, Math.max(0, (frame - keys[k]) / span)), q = this.q, fast = 10, speed = (fast * span) / this.head.fps;
    for (let i = 0; i < n; i++) {
      const ax = a[i], ay = a[n + i], az = a[2 * n + i];
      if (ax + ay + az === 196605) {
        q[4 * i] = q[4 * i + 1] = q[4 * i + 2] = 65535;
        continue;
      }
      const dx = b[i] - ax, dy = b[n + i] - ay, dz = b[2 * n + i] - az;
      q[4 * i] = ax + t * dx, q[4 * i + 1] = ay + t * dy, q[4 * i + 2] = az + t * dz;
      q[4 * i + 3] = Math.min(65535, (65535 * step[0] * Math.hypot(dx, dy, dz)) / speed);
    }
    const whole = Math.min(Math.floor(frame), this.head.frames - 1), next = Math.min(whole + 1, this.head.frames - 1), s = frame - whole;
    const moment = {
      n, q, low: this.head.low, step, mode: this.mode, classes: false, limits: [0, fast], frame: Math.round(frame), facts: {},
      time: times[whole] + s * (times[next] - times[whole]), bodies: this.head.bodies[s < 0.5 ? whole : next],
    };
    if (s > 0 && next > whole) moment.bodies = moment.bodies.map((pose, i) => {
      const from = this.head.bodies[whole][i], to = this.head.bodies[next][i];
      return [...V.mix(from, to, s), ...pose.slice(3)];
    });
    this.stage.show(moment);
    this.bar.tell(moment);
    document.body.dataset.time = moment.time;
  }

  pointer() {
    const canvas = this.canvas;
    let held = null;
    canvas.addEventListener("pointerdown", (e) => {
      held = { x: e.clientX, y: e.clientY, pan: e.button !== 0 || e.shiftKey };
      try { canvas.setPointerCapture(e.pointerId); } catch { /* the pointer has gone already */ }
    });
    canvas.addEventListener("pointermove", (e) => {
      if (!held) return;
      const height = canvas.clientHeight, dx = e.clientX - held.x, dy = e.clientY - held.y;
      if (held.pan) this.camera.pan((2 * dx) / height, (2 * dy) / height);
      else this.camera.turn((4 * dx) / height, (4 * dy) / height);
      held.x = e.clientX, held.y = e.clientY, this.dirty = true;
    });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, () => (held = null));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.camera.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, e.deltaY))));
      this.dirty = true;
    }, { passive: false });
    window.addEventListener("keydown", (e) => {
      const key = e.key.toLowerCase();
      if (key === " ") e.preventDefault(), this.bar.toggle();
      if (key === "r") this.send({ do: "restart" });
      if (key === "h") this.camera.set(this.head.camera), (this.dirty = true);
      this.camera.keys.add(key);
    });
    window.addEventListener("keyup", (e) => this.camera.keys.delete(e.key.toLowerCase()));
  }
}

// The keys' places, x of all, then y, then z.
function unpack(raw, n, keys) {
  const out = [], size = 3 * n;
  for (let k = 0; k < keys.length; k++) {
    const place = new Uint16Array(size), first = 2 * size * k, a = out[k - 1], b = out[k - 2];
    const now = k > 1 ? keys[k] - keys[k - 1] : 0, then = k > 1 ? keys[k - 1] - keys[k - 2] : 1;
    for (let i = 0; i < size; i++) {
      const folded = raw[first + i] | (raw[first + size + i] << 8), away = (folded >>> 1) ^ -(folded & 1);
      let guess = 0;
      if (k === 1) guess = a[i];
      else if (k > 1) {
        const way = ((a[i] - b[i]) << 16) >> 16;
        guess = a[i] + Math.floor((2 * way * now + then) / (2 * then));
      }
      place[i] = guess + away;
    }
    out.push(place);
  }
  return out;
}

(async () => {
  const cover = document.getElementById("cover");
  try {
    const replay = new Replay(JSON.parse(document.getElementById("head").textContent));
    window.neve = replay;
    await replay.load(document.getElementById("data").textContent);
  } catch (error) {
    cover.textContent = `this browser cannot play the replay: ${error.message}`;
    throw error;
  }
})();

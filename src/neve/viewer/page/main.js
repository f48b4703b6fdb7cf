"use strict";
// Put the page together.

class App {
  constructor() {
    this.canvas = document.getElementById("view");
    this.stage = new Stage(this.canvas);
    this.camera = new Camera();
    this.mode = "snow";
    this.selected = "";
    this.scene = null, this.moment = null;
    this.dirty = true;
    this.panel = new Panel(document.getElementById("panel"), this);
    this.gizmo = new Gizmo(this);
    this.tools = new Tools(this, this.canvas);
    this.bar = new Bar(this);
    this.keys();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
    this.canvas.addEventListener("webglcontextlost", (e) => {
      e.preventDefault();
      say("the graphics card has let go of the page: reload it", true, 60);
    });
    this.link = new Link((moment) => this.take(moment), (word) => this.hear(word), (open) => this.line(open));
    this.last = performance.now();
    this.rest = 0;  // clock from which to draw again
    requestAnimationFrame(() => this.loop());
  }

  send(wish) {
    this.link.send(wish);
  }

  redraw() {
    this.dirty = true;
  }

  resize() {
    const scale = this.stage.software ? 0.7 : Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale)), height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    if (this.canvas.width !== width || this.canvas.height !== height) (this.canvas.width = width), (this.canvas.height = height);
    this.dirty = true;
  }

  loop() {
    const now = performance.now(), seconds = Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    if (now >= this.rest && this.link.take()) this.dirty = true;
    if (this.camera.fly(seconds)) this.dirty = true;
    this.tools.tick();
    this.bar.tick();
    if (this.dirty && now >= this.rest && this.scene && this.moment) {
      this.dirty = false;
      this.camera.update(this.canvas.width, this.canvas.height, this.covered());
      this.stage.draw(this.camera);
      if (this.selected) this.stage.drawLines(this.camera, this.gizmo.strips());
      this.rest = performance.now() + 0.5 * this.stage.finish();
      this.bar.drawn.push(now);
      document.body.dataset.drawn = String(Number(document.body.dataset.drawn || 0) + 1);
    }
    requestAnimationFrame(() => this.loop());
  }

  take(moment) {
    this.moment = moment;
    if (!this.scene) return;
    this.stage.show(moment);
    this.bar.tell(moment);
    document.body.dataset.time = moment.time;
    document.body.dataset.particles = moment.n;
    document.getElementById("cover").classList.add("gone");
  }

  hear(word) {
    if (word.kind === "scene") this.setScene(word);
    else if (word.kind === "player") this.bar.show(word, this.scene ? this.scene.live : true);
    else if (word.kind === "refused") word.path ? this.panel.refuse(word.path, word.sentence) : say(word.sentence, true, 9);
    else if (word.kind === "say") say(word.sentence);
    else if (word.kind === "progress") this.progress(word);
    else if (word.kind === "file") {
      if (this.progressLine) this.progressLine.remove();
      this.panel.addFile(word);
      say(make("div", {}, "saved ", make("a", { href: word.url, target: "_blank" }, word.name)), false, 12);
    }
  }

  progress(word) {
    const text = `${word.what}: ${word.done} of ${word.of}`;
    if (this.progressLine && this.progressLine.isConnected) this.progressLine.textContent = text;
    else this.progressLine = say(text, false, 600);
  }

  setScene(scene) {
    const other = !this.scene || this.scene.name !== scene.name;
    this.scene = scene;
    if (other) this.goHome();
    this.stage.stage(scene);
    this.panel.show(scene);
    this.tools.shown(scene.live);
    this.bar.show(scene.player, scene.live);
    document.title = `${scene.name} · Neve`;
    if (this.moment) {
      const moment = this.moment;
      this.take(moment);
    }
    this.dirty = true;
  }

  line(open) {
    if (open) {
      if (this.lost) this.lost.remove();
      this.lost = null;
      this.send({ do: "look", mode: this.mode });
    } else if (!this.lost) this.lost = say("the line to Neve is lost; trying again …", true, 1e6);
  }

  setMode(mode) {
    this.mode = mode;
    this.send({ do: "look", mode });
  }

  setSize(size) {
    this.stage.size = size;
    this.redraw();
  }

  setQuality(quality) {
    this.stage.quality = quality;
    this.stage.light.ready = this.stage.light.ready && quality > 0;
    this.stage.stale = true;
    this.redraw();
  }

  goHome() {
    this.camera.set(this.scene.camera);
    this.redraw();
  }

  see(name) {
    if (this.stage.snow) this.camera.see(name, this.stage.snow.ball);
    this.redraw();
  }

  select(name) {
    if (this.selected === name) return;
    this.selected = name;
    this.stage.selected = name;
    if (name && this.tools.tool === "move") this.panel.reveal(name);
    this.redraw();
  }

  // Share of the width that the panel covers, where enough is left.
  covered() {
    const panel = document.getElementById("panel"), width = this.canvas.clientWidth;
    return panel.hidden || width < 900 ? 0 : (panel.offsetWidth + 12) / width;
  }

  togglePanel() {
    const panel = document.getElementById("panel");
    panel.hidden = !panel.hidden;
    this.redraw();
  }

  // The point in the middle of the view: of snow, of a solid, or the target.
  middle() {
    return this.tools.hit(0.5 - 0.5 * this.camera.covered, 0.5).point;
  }

  changed(field) {
    if (!field.live) say(`${field.path} acts when the scene begins anew (r)`);
  }

  keys() {
    const names = Object.keys(TOOLS);
    window.addEventListener("keydown", (event) => {
      if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range" && event.target.type !== "checkbox") return;
      if (event.ctrlKey || event.metaKey) return;
      const key = event.key.toLowerCase();
      if (key === " ") event.preventDefault(), event.target.blur(), this.bar.toggle();
      else if (key === "r") this.send({ do: "restart" });
      else if (key === ".") this.send({ do: "frame" });
      else if (key === "h") this.goHome();
      else if (key === "p") this.togglePanel();
      else if (names[Number(key) - 1]) this.tools.choose(names[Number(key) - 1]);
      else if (key.startsWith("arrow")) event.preventDefault();
      if (event.shiftKey) this.camera.keys.add("shift");
      this.camera.keys.add(key);
    });
    window.addEventListener("keyup", (event) => {
      this.camera.keys.delete(event.key.toLowerCase());
      if (!event.shiftKey) this.camera.keys.delete("shift");
    });
    window.addEventListener("blur", () => this.camera.keys.clear());
  }
}

try {
  window.neve = new App();
} catch (error) {
  document.getElementById("cover").textContent = `Neve cannot draw here: ${error.message}`;
  throw error;
}

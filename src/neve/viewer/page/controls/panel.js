"use strict";
// The panel: built from what the server tells of the scene's fields. It checks nothing by itself: a wrong value
// comes back with the sentence of the scene model.

const KIND_NAMES = { sources: "snow", colliders: "collider", bodies: "body" };

class Panel {
  constructor(root, app) {
    this.root = root, this.app = app;
    this.open = new Set(["scene", "look", "snow"]);
    this.rows = new Map();
    this.key = "";
    this.files = make("div", { class: "files" });
  }

  // Build the panel for a scene, or only set the values if the fields are the same.
  show(scene) {
    const key = JSON.stringify([scene.name, scene.live, scene.panel.map((s) => [s.path, s.title, s.can, s.fields.map((f) => f.path)])]);
    if (key === this.key) {
      for (const section of scene.panel) for (const field of section.fields) this.setValue(field);
      return;
    }
    this.key = key;
    this.rows.clear();
    const top = this.root.scrollTop;
    this.root.replaceChildren(
      this.sceneSection(scene), this.lookSection(scene), this.recordSection(scene),
      ...(scene.live ? [this.addSection(scene)] : []),
    );
    const made = new Map();
    for (const section of scene.panel) {  // one that lies in another comes after it
      made.set(section.path, this.section(section, scene.live));
      (made.get(section.parent) || this.root).append(made.get(section.path));
    }
    this.root.scrollTop = top;
  }

  fold(id, title, ...content) {
    const details = make("details", { open: this.open.has(id) }, make("summary", {}, title), ...content);
    details.dataset.section = id;
    details.addEventListener("toggle", () => (details.open ? this.open.add(id) : this.open.delete(id)));
    return details;
  }

  row(label, ...content) {
    return make("div", { class: "row" }, make("label", {}, label), make("div", { class: "value" }, ...content));
  }

  sceneSection(scene) {
    const content = [make("p", { class: "hint" }, scene.about || scene.name)];
    if (Object.keys(scene.presets).length) {
      const choose = make("select", { id: "scene-choice", onchange: () => this.app.send({ do: "open", scene: choose.value }) });
      if (!(scene.name in scene.presets)) choose.append(make("option", { value: "" }, scene.name));
      for (const name in scene.presets) choose.append(make("option", { value: name, title: scene.presets[name] }, name));
      choose.value = scene.name in scene.presets ? scene.name : "";
      content.unshift(this.row("scene", choose));
    }
    const views = Object.keys(VIEWS).map((name) => button(null, `See the snow: ${name}`, () => this.app.see(name), name));
    content.push(make("div", { class: "buttons views" }, button("home", "Camera of the scene (h)", () => this.app.goHome()), ...views));
    content.push(make("div", { class: "buttons" },
      button(null, "Save the scene as TOML, with this camera", () => this.app.send({ do: "save", camera: this.app.camera.told() }), "save scene"),
    ));
    return this.fold("scene", "scene", ...content);
  }

  lookSection(scene) {
    const mode = make("select", { id: "mode", onchange: () => this.app.setMode(mode.value) });
    for (const m of scene.modes) mode.append(make("option", { value: m.name }, m.label));
    mode.value = this.app.mode;
    const size = make("input", { type: "range", min: 0.4, max: 2.5, step: 0.05, value: this.app.stage.size,
      oninput: () => this.app.setSize(Number(size.value)) });
    const quality = make("select", { id: "quality", onchange: () => this.app.setQuality(Number(quality.value)) });
    ["no shadows", "fast", "full"].forEach((text, i) => quality.append(make("option", { value: i }, text)));
    quality.value = this.app.stage.quality;
    return this.fold("look", "look", this.row("colours", mode), this.row("point size", size), this.row("shadows", quality));
  }

  recordSection(scene) {
    const send = (wish) => () => this.app.send(wish());
    const eye = () => this.app.camera.told();
    const hint = scene.live
      ? "Press record in the bar, play, and stop it; then make a film or a replay of it."
      : "Film and replay hold all frames of this run.";
    return this.fold("record", "record", make("p", { class: "hint" }, hint), make("div", { class: "buttons" },
      button("camera", "Picture with this camera (PNG)", send(() => ({ do: "picture", camera: eye() })), " picture"),
      button("film", "Film with this camera (MP4)", send(() => ({ do: "film", camera: eye() })), " film"),
      button(null, "A page that plays by itself (HTML)", send(() => ({ do: "replay" })), "replay"),
    ), this.files);
  }

  addSection(scene) {
    const rows = Object.keys(scene.addable).map((kind) => {
      const shape = make("select", {}, ...scene.addable[kind].map((name) => make("option", { value: name }, name.replace("mesh:", ""))));
      shape.setAttribute("aria-label", `shape to add to ${kind}`);
      const add = button(null, `Add to ${kind}, in the middle of the view`, () =>
        this.app.send({ do: "add", kind, shape: shape.value, at: this.app.middle() }), "add");
      add.dataset.add = kind;
      return this.row(KIND_NAMES[kind] || kind, shape, add);
    });
    return this.fold("add", "add", ...rows);
  }

  section(section, live) {
    const details = this.fold(section.path, section.title, make("p", { class: "hint" }, section.text),
      ...section.fields.map((field) => this.field(field)));
    if (!live) return details;
    const wishes = { add: { do: "enlarge", path: section.path }, delete: { do: "delete", name: section.path } };
    if (section.can) {
      const change = make("button", { class: section.can, type: "button", title: `${section.can} ${section.path}` }, section.can);
      change.addEventListener("click", (event) => {
        event.preventDefault();
        this.open.add(section.path);
        this.app.send(wishes[section.can]);
      });
      details.querySelector("summary").append(change);
    }
    if (!section.parent && section.path.includes("."))
      details.addEventListener("toggle", () => details.open && this.app.select(section.path));
    return details;
  }

  field(field) {
    const inputs = this.inputs(field);
    const unit = field.unit && field.unit !== "1" ? make("span", { class: "unit" }, field.unit) : null;
    const row = this.row(field.name, ...inputs, unit);
    row.dataset.path = field.path;
    row.title = `${field.text}\n${field.allowed}${field.default === null ? "" : `; default ${JSON.stringify(field.default)}`}` +
      (field.live ? "" : "\nActs when the scene is started anew.");
    if (!field.live) row.classList.add("later");
    inputs[0].setAttribute("aria-label", field.path);
    this.rows.set(field.path, { row, inputs, field });
    this.setValue(field);
    return row;
  }

  inputs(field) {
    const send = () => this.send(field.path);
    if (field.control === "choice") {
      const select = make("select", { onchange: send });
      if (field.optional) select.append(make("option", { value: "" }, "–"));
      field.choices.forEach((choice, i) => select.append(make("option", { value: String(i) }, String(choice))));
      return [select];
    }
    if (field.control === "switch") return [make("input", { type: "checkbox", onchange: send })];
    const count = field.control === "vector" ? field.count : 1;
    return Array.from({ length: count }, () => {
      const input = make("input", { type: "text", inputMode: field.control === "text" ? "text" : "decimal", spellcheck: false, onchange: send });
      input.addEventListener("keydown", (event) => this.nudge(event, input, field));
      return input;
    });
  }

  // Arrow keys change a number by a tenth of itself, with shift by a hundredth.
  nudge(event, input, field) {
    event.stopPropagation();
    if (field.control === "text" || field.control === "list" || (event.key !== "ArrowUp" && event.key !== "ArrowDown")) return;
    event.preventDefault();
    const now = Number(input.value) || 0, by = event.shiftKey ? 0.01 : 0.1;
    const step = field.whole ? Math.max(1, Math.round(Math.abs(now) * by)) : Math.abs(now) * by || by;
    const next = now + (event.key === "ArrowUp" ? step : -step);
    input.value = field.whole ? Math.round(next) : Number(next.toPrecision(6));
    this.send(field.path);
  }

  send(path) {
    const { row, inputs, field } = this.rows.get(path);
    row.classList.remove("wrong");
    if (row.nextSibling && row.nextSibling.className === "wrong-text") row.nextSibling.remove();
    let value;
    if (field.control === "choice") value = inputs[0].value === "" ? null : field.choices[Number(inputs[0].value)];
    else if (field.control === "switch") value = inputs[0].checked;
    else {
      const texts = field.control === "list" ? inputs[0].value.split(/[\s,;]+/).filter(Boolean) : inputs.map((input) => input.value);
      const numbers = texts.map((text) => this.number(text, field));
      if (field.control === "list" && numbers.some((n) => typeof n !== "number")) return this.refuse(path, `${path} needs numbers`);
      value = field.control === "list" ? numbers : field.control === "vector" ? (numbers.every((n) => n === null) ? null : numbers) : numbers[0];
      if (field.control === "vector" && value && value.some((n) => typeof n !== "number"))
        return this.refuse(path, `${path} needs ${field.count} numbers`);
    }
    this.app.send({ do: "set", path, value });
    this.app.changed(field);
  }

  // A number if it is one; else the text, which the scene model will refuse.
  number(text, field) {
    const trimmed = text.trim();
    if (trimmed === "") return null;
    const value = Number(trimmed);
    return Number.isFinite(value) && (field.control !== "text" || trimmed !== "") ? value : trimmed;
  }

  setValue(field) {
    const known = this.rows.get(field.path);
    if (!known) return;
    known.field = field;
    const { row, inputs } = known, value = field.value;
    if (row.contains(document.activeElement) && document.activeElement.type === "text" && row.classList.contains("wrong")) return;
    if (field.control === "choice") inputs[0].value = value === null ? "" : String(field.choices.indexOf(value));
    else if (field.control === "switch") inputs[0].checked = Boolean(value);
    else if (field.control === "list") inputs[0].value = (value || []).map((n) => Number(n.toPrecision(7))).join(", ");
    else inputs.forEach((input, i) => {
      const one = field.control === "vector" ? (value === null ? null : value[i]) : value;
      input.value = one === null ? "" : typeof one === "number" ? Number(one.toPrecision(7)) : one;
    });
  }

  // Show why a value was refused, beside it if its row is there.
  refuse(path, sentence) {
    const known = this.rows.get(path);
    if (!known) return say(sentence, true);
    known.row.classList.add("wrong");
    if (known.row.nextSibling && known.row.nextSibling.className === "wrong-text") known.row.nextSibling.remove();
    known.row.after(make("div", { class: "wrong-text" }, sentence));
    if (!known.row.offsetParent) say(sentence, true);
  }

  // Point at a section, and open it.
  reveal(path) {
    const entry = path.split(".").slice(0, 2).join(".");  // a robot's part lies in the robot
    const details = this.root.querySelector(`details[data-section="${CSS.escape(entry)}"]`);
    if (!details) return;
    details.open = true;
    details.scrollIntoView({ block: "nearest" });
  }

  addFile(file) {
    const size = file.bytes > 1e6 ? `${(file.bytes / 1e6).toFixed(1)} MB` : `${Math.ceil(file.bytes / 1e3)} kB`;
    this.files.prepend(make("a", { href: file.url, target: "_blank", title: file.place }, `${file.name} (${size})`));
  }
}

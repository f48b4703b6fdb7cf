// The fields of the panel, one row each. They check nothing: a wrong value comes back with the scene's sentence.

/** @import { SetCommand } from "../commands.js" */
/** @import { Field } from "../protocol.js" */
/** @import { App } from "../main.js" */
/** @typedef {HTMLInputElement | HTMLSelectElement} Control */
/**
 * @typedef {object} Known
 * @property {HTMLElement} row
 * @property {Control[]} controls
 * @property {Field} field
 * @property {boolean} typed whether what it holds has not been sent yet
 */

import { make, select } from "./dom.js";

export class Fields {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {Map<string, Known>} */
    this.rows = new Map();
  }

  clear() {
    this.rows.clear();
  }

  /** @param {Field} field */
  row(field) {
    const controls = this.controls(field);
    const wide = field.control === "vector"; // its numbers need the whole width
    const unit = field.unit && field.unit !== "1" ? make("span", { class: "unit" }, field.unit) : null;
    const value = make("div", { class: "value" }, ...controls, wide ? null : unit);
    const label = make("label", {}, field.name, wide ? " " : null, wide ? unit : null);
    const row = make("div", { class: "row" }, label, value);
    row.classList.toggle("wide", wide);
    row.dataset.path = field.path;
    row.title = tooltip(field);
    if (!field.live) row.classList.add("later");
    controls[0].setAttribute("aria-label", field.path);
    const known = { row, controls, field, typed: false };
    row.addEventListener("input", () => (known.typed = true));
    row.addEventListener("focusout", () => {
      if (!known.typed) return; // what is typed and then typed back changes nothing, and is not sent
      known.typed = false;
      this.update(known.field);
    });
    this.rows.set(field.path, known);
    this.update(field);
    return row;
  }

  /**
   * @param {Field} field
   * @returns {Control[]}
   */
  controls(field) {
    const onchange = () => this.send(field.path);
    if (field.control === "choice") {
      /** @type {[string | number, string][]} */
      const choices = (field.choices ?? []).map((choice, i) => [i, String(choice)]);
      if (field.optional) choices.unshift(["", "–"]);
      return [select({ onchange }, choices)];
    }
    if (field.control === "switch") return [make("input", { type: "checkbox", onchange })];
    const inputMode = field.control === "text" ? "text" : "decimal";
    const count = field.control === "vector" ? (field.count ?? 1) : 1;
    return Array.from({ length: count }, () => {
      const input = make("input", { type: "text", inputMode, spellcheck: false, onchange });
      input.addEventListener("keydown", (event) => this.nudge(event, input, field));
      return input;
    });
  }

  /**
   * Arrow keys change a number by a tenth of itself, with shift by a hundredth.
   * @param {KeyboardEvent} event
   * @param {HTMLInputElement} input
   * @param {Field} field
   */
  nudge(event, input, field) {
    event.stopPropagation();
    const sign = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!sign || field.control === "text" || field.control === "list") return;
    event.preventDefault();
    const now = Number(input.value) || 0;
    const by = Math.abs(now) * (event.shiftKey ? 0.01 : 0.1);
    const step = field.whole ? Math.max(1, Math.round(by)) : by || (event.shiftKey ? 0.01 : 0.1);
    const next = now + sign * step;
    input.value = String(field.whole ? Math.round(next) : Number(next.toPrecision(6)));
    this.send(field.path);
  }

  /** @param {string} path */
  send(path) {
    const known = this.rows.get(path);
    if (!known) return;
    known.typed = false;
    clearRefusal(known.row);
    const { value, wrong } = read(known);
    if (wrong) {
      this.refuse(path, wrong);
      return;
    }
    this.app.send({ do: "set", path, value });
  }

  /**
   * Show the value of a field.
   * @param {Field} field
   */
  update(field) {
    const known = this.rows.get(field.path);
    if (!known) return;
    known.field = field;
    const { row, controls } = known;
    const focused = document.activeElement;
    const typing = focused instanceof HTMLInputElement && focused.type === "text" && row.contains(focused);
    showPending(row, field);
    // What is being typed stays, whatever comes; and what was refused can still be mended.
    const kept = known.typed || (row.classList.contains("wrong") && !isSame(read(known).value, field.value));
    if (typing && kept) return;
    clearRefusal(row);
    controls.forEach((control, i) => {
      if (control instanceof HTMLInputElement && control.type === "checkbox")
        control.checked = Boolean(field.value);
      else control.value = textOf(field, i);
    });
  }

  /**
   * Show beside a field why its value was refused.
   * @param {string} path
   * @param {string} sentence
   * @returns {boolean} whether its row is there to be seen
   */
  refuse(path, sentence) {
    const known = this.rows.get(path);
    if (!known) return false;
    clearRefusal(known.row);
    known.row.classList.add("wrong");
    known.row.after(make("div", { class: "wrong-text" }, sentence));
    return known.row.offsetParent !== null;
  }
}

/**
 * Say beside a field what the run goes on with until it begins again.
 * @param {HTMLElement} row
 * @param {Field} field
 */
function showPending(row, field) {
  row.querySelector(".pending")?.remove();
  if (field.now === undefined) return;
  const text = `${plain(field.now)} → ${plain(field.value)} at restart (r)`;
  row.append(make("div", { class: "pending" }, text));
}

/** @param {unknown} value */
function plain(value) {
  if (value === null) return "–";
  return Array.isArray(value)
    ? value.map(rounded).join(", ")
    : rounded(/** @type {number | string} */ (value));
}

/**
 * @param {unknown} a
 * @param {unknown} b
 */
function isSame(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}

/** @param {Field} field */
function tooltip(field) {
  const usual = field.default === null ? "" : `; default ${JSON.stringify(field.default)}`;
  const later = field.live ? "" : "\nActs when the scene begins again.";
  return `${field.text}\n${field.allowed}${usual}${later}`;
}

/** @param {HTMLElement} row */
function clearRefusal(row) {
  row.classList.remove("wrong");
  if (row.nextElementSibling?.className === "wrong-text") row.nextElementSibling.remove();
}

/**
 * Return the text of the i-th control of a field.
 * @param {Field} field
 * @param {number} i
 */
function textOf({ control, value, choices }, i) {
  if (value === null) return "";
  if (control === "choice") return String((choices ?? []).indexOf(value));
  if (control === "list") return value.map(rounded).join(", ");
  return rounded(control === "vector" ? value[i] : value);
}

/** @param {number | string} value */
function rounded(value) {
  return String(typeof value === "number" ? Number(value.toPrecision(7)) : value);
}

/**
 * Return the value that a row holds, or what is wrong with it.
 * @param {Known} known
 * @returns {{ value: SetCommand["value"], wrong?: string }}
 */
function read({ controls, field }) {
  const [first] = controls;
  if (field.control === "choice")
    return { value: first.value === "" ? null : field.choices?.[Number(first.value)] };
  if (field.control === "switch") return { value: first instanceof HTMLInputElement && first.checked };
  if (field.control === "list") {
    const numbers = first.value
      .split(/[\s,;]+/)
      .filter(Boolean)
      .map(Number);
    return numbers.every(Number.isFinite)
      ? { value: numbers }
      : { value: null, wrong: `${field.path} needs numbers` };
  }
  if (field.control === "vector") {
    const texts = controls.map((control) => control.value.trim());
    if (texts.every((text) => text === "")) return { value: null };
    const numbers = texts.map(Number);
    const good = numbers.every(Number.isFinite) && !texts.includes("");
    return good ? { value: numbers } : { value: null, wrong: `${field.path} needs ${field.count} numbers` };
  }
  return { value: numberOrText(first.value.trim()) };
}

/**
 * Return a number if the text is one; else the text, which the scene model may refuse.
 * @param {string} text
 */
function numberOrText(text) {
  if (text === "") return null;
  const value = Number(text);
  return Number.isFinite(value) ? value : text;
}

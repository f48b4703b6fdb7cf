// Small parts of the page: elements, icons, numbers as text.

/** @typedef {Node | string | null | undefined} Child */

/**
 * Return the element of the page with this id.
 * @template {HTMLElement} [T=HTMLElement]
 * @param {string} id
 * @returns {T}
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element ${id}`);
  return /** @type {T} */ (element);
}

/**
 * Say what is to be said of a scene; nothing if it is empty.
 * @param {string} text
 */
export function caption(text) {
  const shown = byId("caption");
  shown.textContent = text;
  shown.hidden = !text;
}

/**
 * Make an element. A key of `more` is a class, an event ("onclick"), a property, or else an attribute.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, unknown>} more
 * @param {Child[]} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function make(tag, more = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(more)) {
    if (key === "class") element.className = String(value);
    else if (typeof value === "function")
      element.addEventListener(key.slice(2), /** @type {EventListener} */ (value));
    else if (key in element) Object.assign(element, { [key]: value });
    else element.setAttribute(key, String(value));
  }
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

// prettier-ignore
const ICONS = {
  play: '<path class="full" d="M6 4l11 6-11 6z"/>',
  pause: '<path class="full" d="M5 4h4v12H5zM11 4h4v12h-4z"/>',
  frame: '<path class="full" d="M4 4l8 6-8 6z"/><path d="M15 4v12"/>',
  restart: '<path d="M4 10a6 6 0 1 0 2-4.5"/><path d="M6 2v4h4"/>',
  record: '<circle class="full" cx="10" cy="10" r="5"/>',
  look: '<ellipse cx="10" cy="10" rx="7.5" ry="3.2"/><circle class="full" cx="10" cy="10" r="1.6"/><path d="M10 2.500a9 9 0 0 1 0 15M13 15.500l-3 2 2 2.500"/>',
  throw: '<circle class="full" cx="13.5" cy="6.5" r="3.6"/><path d="M2 17c2-4 4-6 6-7.5M6 18c1-3 2.5-4.5 4-6"/>',
  push: '<path d="M3 10h10M9 6l4 4-4 4M16.5 4v12"/>',
  grab: '<path d="M6 10V5.5a1.3 1.3 0 0 1 2.6 0V9M8.600 8.5V4a1.3 1.3 0 0 1 2.6 0v4.5M11.200 9V5a1.3 1.3 0 0 1 2.6 0v6c0 4-1.5 6-4.5 6S5 15 3.5 11.5c-.6-1.400 1.200-2.300 2-.9L6 11.5"/>',
  move: '<path d="M10 3v14M3 10h14M10 3l-2 2M10 3l2 2M10 17l-2-2M10 17l2-2M3 10l2-2M3 10l2 2M17 10l-2-2M17 10l-2 2"/>',
  measure: '<path d="M3 14L14 3l3 3L6 17zM6 11l2 2M8.500 8.500l1.500 1.500M11 6l2 2"/>',
  undo: '<path d="M4 8h8a4.500 4.500 0 0 1 0 9H8M4 8l4-4M4 8l4 4"/>',
  redo: '<path d="M16 8H8a4.500 4.500 0 0 0 0 9h4M16 8l-4-4M16 8l-4 4"/>',
  camera: '<rect x="2.5" y="6" width="15" height="10" rx="2"/><circle cx="10" cy="11" r="3"/><path d="M7 6l1.5-2h3L13 6"/>',
  film: '<rect x="2.5" y="5" width="10.5" height="10" rx="2"/><path d="M13 9l4.5-2.5v7L13 11"/>',
  home: '<path d="M3 10l7-6 7 6M5.5 8.5V16h9V8.5"/>',
};

/** @typedef {keyof typeof ICONS} Icon */

/** @param {Icon} name */
export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 20 20");
  svg.setAttribute("aria-hidden", "true");
  svg.innerHTML = ICONS[name]; // our own constants
  return svg;
}

/**
 * @param {Icon | null} name of its icon
 * @param {string} title
 * @param {() => void} action
 * @param {string} text
 */
export function button(name, title, action, text = "") {
  const element = make("button", { type: "button", title, onclick: action });
  element.setAttribute("aria-label", title);
  if (name) element.append(icon(name));
  if (text) element.append(text);
  return element;
}

/**
 * Make a choice; `choices` are values with their texts.
 * @param {Record<string, unknown>} more
 * @param {[string | number, string][]} choices
 */
export function select(more, choices) {
  return make("select", more, ...choices.map(([value, text]) => make("option", { value }, text)));
}

/**
 * Return a number with three digits and no needless zeros.
 * @param {number | null | undefined} value
 */
export function short(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(1).replace("e+", "e");
  return String(Number(value.toPrecision(3)));
}

/**
 * Show a line to the user for some seconds.
 * @param {string | HTMLElement} text
 * @param {boolean} bad
 * @param {number} seconds
 */
export function say(text, bad = false, seconds = 6) {
  const notes = byId("notes");
  if (notes.lastElementChild?.textContent === text) notes.lastElementChild.remove(); // again: only once, for longer
  const line = typeof text === "string" ? make("div", { class: bad ? "bad" : "" }, text) : text;
  notes.append(line);
  while (notes.children.length > 4) notes.firstChild?.remove();
  setTimeout(() => line.remove(), 1000 * seconds);
  return line;
}

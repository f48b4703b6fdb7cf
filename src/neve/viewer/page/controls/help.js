// What keys and pointer do, in a list that the question mark shows.

import { byId, make } from "./dom.js";

/** @type {[string, string][]} */
const KEYS = [
  ["space", "play, pause"],
  [".", "one frame"],
  ["r", "begin again"],
  ["Ctrl Z, Ctrl Y", "take back, do again"],
  ["1 … 6", "tools: look, throw, push, grab, move, measure"],
  ["drag; right button or shift", "turn; pan (two fingers: pinch)"],
  ["wheel", "zoom; with shift: size of brush or ball; with alt: speed of a throw"],
  ["W A S D Q E, arrows", "fly; with shift faster"],
  ["T G, U J, I K, O L", "more and less of the first four controls of motors and robots"],
  ["h", "camera of the scene"],
  ["p", "panel"],
  ["Delete", "delete the chosen solid"],
  ["Enter, Esc", "set down what is new; let go of it, of a solid, of a tool"],
  ["?", "this list"],
];

export function toggleHelp() {
  const box = byId("help");
  if (!box.firstChild)
    box.append(...KEYS.flatMap(([key, text]) => [make("kbd", {}, key), make("span", {}, text)]));
  box.hidden = !box.hidden;
}

export function hideHelp() {
  const box = byId("help");
  const was = !box.hidden;
  box.hidden = true;
  return was;
}

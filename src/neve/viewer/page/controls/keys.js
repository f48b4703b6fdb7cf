// The keyboard of the page; controls/help.js lists it.

/** @import { App } from "../main.js" */

import { hideHelp, toggleHelp } from "./help.js";
import { TOOLS } from "../tools/tools.js";

/** @param {App} app */
export function listenToKeys(app) {
  const { keys } = app.camera;
  window.addEventListener("keydown", (event) => {
    if (isTyping(event.target) || isSliding(event)) return;
    if (event.ctrlKey || event.metaKey) {
      edit(app, event);
      return;
    }
    press(app, event);
    if (event.shiftKey) keys.add("shift");
    keys.add(event.key.toLowerCase());
  });
  window.addEventListener("keyup", (event) => {
    keys.delete(event.key.toLowerCase());
    if (!event.shiftKey) keys.delete("shift");
  });
  window.addEventListener("blur", () => keys.clear());
}

/**
 * @param {App} app
 * @param {KeyboardEvent} event
 */
function edit(app, event) {
  const key = event.key.toLowerCase();
  if ((key !== "z" && key !== "y") || !app.scene?.live) return;
  event.preventDefault();
  app.send({ do: key === "y" || event.shiftKey ? "redo" : "undo" });
}

/**
 * @param {App} app
 * @param {KeyboardEvent} event
 */
function press(app, event) {
  const key = event.key.toLowerCase();
  const tool = Object.keys(TOOLS)[Number(key) - 1];
  if (key === " ") {
    event.preventDefault();
    if (event.target instanceof HTMLElement) event.target.blur();
    app.bar.toggle();
  } else if (key === "r") app.send({ do: "restart" });
  else if (key === ".") app.send({ do: "frame" });
  else if (key === "h") app.goHome();
  else if (key === "p") app.togglePanel();
  else if (key === "?") toggleHelp();
  else if (key === "enter") app.placing.finish();
  else if (key === "escape") letGo(app);
  else if (key === "delete" || key === "backspace") app.deleteSelected();
  else if (tool) app.tools.choose(tool);
  else if (key.startsWith("arrow")) event.preventDefault();
}

/**
 * Let go of the help, of what is new, of a solid, of a tool: of the first that there is.
 * @param {App} app
 */
function letGo(app) {
  if (hideHelp()) return;
  if (app.placing.ghost) app.placing.cancel();
  else if (app.measure.ends.length) app.measure.cancel();
  else if (app.selected) app.select("");
  else app.tools.choose("look");
  app.redraw();
}

/** @param {EventTarget | null} target */
function isTyping(target) {
  if (target instanceof HTMLInputElement) return target.type !== "range" && target.type !== "checkbox";
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}

/**
 * Whether a key moves the slider that has the focus, and not the camera.
 * @param {KeyboardEvent} event
 */
function isSliding({ target, key }) {
  return target instanceof HTMLInputElement && target.type === "range" && key.startsWith("Arrow");
}

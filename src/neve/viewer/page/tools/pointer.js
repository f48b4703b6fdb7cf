// What the pointer does to the camera, on a page and in a replay.

/** @import { OrbitCamera } from "../draw/camera.js" */

/**
 * Turn or pan by so many pixels.
 * @param {OrbitCamera} camera
 * @param {"turn" | "pan"} kind
 * @param {number} right [px]
 * @param {number} down
 * @param {number} height of the picture [px]
 */
export function dragCamera(camera, kind, right, down, height) {
  if (kind === "turn") camera.turn((4 * right) / height, (4 * down) / height);
  else camera.pan((2 * right) / height, (2 * down) / height);
}

/**
 * Let the wheel zoom, and keep the browser's own menu away.
 * @param {HTMLCanvasElement} canvas
 * @param {OrbitCamera} camera
 * @param {() => void} redraw
 */
export function listenToWheel(canvas, camera, redraw) {
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  const zoom = (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    const by = event.deltaY * (event.deltaMode ? 30 : 1); // lines, or pixels
    camera.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, by))));
    redraw();
  };
  canvas.addEventListener("wheel", zoom, { passive: false });
}

/**
 * Keep the pointer's events on the canvas while a button is held.
 * @param {HTMLCanvasElement} canvas
 * @param {number} id
 */
export function capture(canvas, id) {
  try {
    canvas.setPointerCapture(id);
  } catch {
    // the pointer has gone already
  }
}

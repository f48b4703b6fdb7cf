/** The element of the page with this id; index.html has it. */
export function element(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (!found) throw new Error(`The page has no element ${id}.`);
  return found;
}

let gone = 0;

/** Show a sentence for some seconds; without `seconds` it stays. */
export function say(sentence: string, seconds?: number): void {
  const place = element("message");
  place.textContent = sentence;
  place.hidden = false;
  window.clearTimeout(gone);
  if (seconds !== undefined) gone = window.setTimeout(() => (place.hidden = true), seconds * 1e3);
}

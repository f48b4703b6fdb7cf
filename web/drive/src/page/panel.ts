import GUI from "lil-gui";
import type { Controller } from "lil-gui";
import { CHOICES, QUANTITIES, defaults } from "../settings";
import type { ChoiceName, QuantityName, Settings } from "../settings";

/** What the panel can ask for besides a changed number. */
export interface PanelActions {
  /** A setting has a new value; it may be one of many while a slider is drawn. */
  changed(name: QuantityName | ChoiceName): void;
  /** The visitor has let go: the settings are as they are meant. */
  settled(): void;
  /** Put the address with these settings where it can be pasted. */
  copyLink(): void;
  /** Put the car upright where it stands. */
  resetCar(): void;
  /** Take the next camera. */
  nextCamera(): void;
  /** Switch the headlights. */
  switchLights(): void;
  /** Switch the sound. */
  switchSound(): void;
  /** Put the car before the start of the course. */
  toCourse(): void;
  /** Begin or end photo mode. */
  togglePhoto(): void;
}

const TITLES = { snow: "Snow", weather: "Weather", car: "Car", picture: "Picture" } as const;

/** Make the panel of all settings, in the groups of the table; it changes `settings` in place. */
export function makePanel(settings: Settings, actions: PanelActions): GUI {
  const gui = new GUI({ title: "Snow and car" });
  for (const group of Object.keys(TITLES) as (keyof typeof TITLES)[]) {
    const folder = gui.addFolder(TITLES[group]);
    for (const name of names(QUANTITIES)) {
      const { min, max, step, unit, meaning, group: own } = QUANTITIES[name];
      if (own === group) explain(folder.add(settings, name, min, max, step), unit, meaning, actions, name);
    }
    for (const name of names(CHOICES)) {
      const { among, meaning, group: own } = CHOICES[name];
      if (own === group) explain(folder.add(settings, name, [...among]), "", meaning, actions, name);
    }
    if (group !== "snow") folder.close();
  }
  const button = (name: string, action: () => void) => gui.add({ action }, "action").name(name);
  button("next camera (C)", actions.nextCamera);
  button("headlights (L)", actions.switchLights);
  button("sound on or off (N)", actions.switchSound);
  button("to the start of the course (T)", actions.toCourse);
  button("photo mode (P)", actions.togglePhoto);
  button("put the car upright (R)", actions.resetCar);
  button("copy link with these settings", actions.copyLink);
  button("settings as they were", () => usual(gui, settings, actions));
  freeKeys(gui.domElement);
  gui.close(); // open it hides a third of the picture
  return gui;
}

function names<T extends object>(table: T): (keyof T & string)[] {
  return Object.keys(table) as (keyof T & string)[];
}

function explain(
  row: Controller,
  unit: string,
  meaning: string,
  actions: PanelActions,
  name: QuantityName | ChoiceName,
): void {
  row.name(unit ? `${spaced(name)} [${unit}]` : spaced(name));
  row.domElement.title = meaning;
  row.onChange(() => actions.changed(name));
  row.onFinishChange(() => actions.settled());
}

/** Give the keys back to the car once a choice is made or a button pressed; only what is being typed keeps them. */
function freeKeys(panel: HTMLElement): void {
  const letGo = () => (document.activeElement as HTMLElement | null)?.blur();
  panel.addEventListener("click", ({ target }) => {
    if (!(target instanceof HTMLInputElement || target instanceof HTMLSelectElement)) letGo();
  });
  panel.addEventListener("change", ({ target }) => {
    if (target instanceof HTMLSelectElement) letGo();
  });
}

/** `tyreWidth` as `tyre width`. */
function spaced(name: string): string {
  return name.replace(/[A-Z]/g, (letter) => ` ${letter.toLowerCase()}`);
}

function usual(gui: GUI, settings: Settings, actions: PanelActions): void {
  const before = { ...settings };
  Object.assign(settings, defaults());
  for (const row of gui.controllersRecursive()) row.updateDisplay();
  for (const name of [...names(QUANTITIES), ...names(CHOICES)]) {
    if (before[name] !== settings[name]) actions.changed(name);
  }
  actions.settled();
}

import GUI from "lil-gui";
import type { Controller } from "lil-gui";
import { CHOICES, QUANTITIES, defaults } from "../settings";
import type { ChoiceName, QuantityName, Settings } from "../settings";

/** What the panel can ask for besides a changed number. */
export interface PanelActions {
  /** A setting has a new value. */
  changed(name: QuantityName | ChoiceName): void;
  /** Put the address with these settings where it can be pasted. */
  copyLink(): void;
  /** Put the car upright where it stands. */
  resetCar(): void;
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
  gui.add({ copyLink: actions.copyLink }, "copyLink").name("copy link with these settings");
  gui.add({ resetCar: actions.resetCar }, "resetCar").name("put the car upright (R)");
  gui.add({ usual: () => usual(gui, settings, actions) }, "usual").name("settings as they were");
  if (window.innerWidth < 700) gui.close();
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
}

import { CHOICES, QUANTITIES, defaults } from "../settings";
import type { ChoiceName, QuantityName, Settings } from "../settings";

/**
 * The settings in an address: what differs from the defaults, as `#depth=0.6&type=powder`.
 * What an address holds is checked: an unknown name, a word that is no number or a value out of range is left out
 * and gives one sentence each.
 */
export interface Read extends Named {
  readonly settings: Settings;
  readonly errors: readonly string[];
}

/** What an address may name beside the settings; null: nothing. */
export interface Named {
  /** The recording of a run that is to be played. */
  readonly recording: string | null;
  /** The snowed ground to begin on. */
  readonly ground: string | null;
}
const NAMES = ["recording", "ground"] as const;
const NOTHING: Named = { recording: null, ground: null };

/** Read settings from the part of an address after `#`. */
export function readAddress(hash: string): Read {
  const settings: Record<string, number | string> = defaults();
  const errors: string[] = [];
  const named: Record<keyof Named, string | null> = { ...NOTHING };
  for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    const key = NAMES.find((one) => one === name);
    if (key) {
      named[key] = text || null;
      continue;
    }
    const error = take(settings, name, text);
    if (error) errors.push(error);
  }
  return { settings: settings as Settings, ...named, errors };
}

/** Write settings and names into the part of an address after `#`: empty if all is as it is by default. */
export function writeAddress(settings: Settings, named: Named = NOTHING): string {
  const usual = defaults();
  const names = [...Object.keys(QUANTITIES), ...Object.keys(CHOICES)] as (QuantityName | ChoiceName)[];
  const changed = names.filter((name) => settings[name] !== usual[name]);
  const said = NAMES.filter((name) => named[name] !== null);
  return [
    ...said.map((name) => `${name}=${encodeURIComponent(named[name]!)}`),
    ...changed.map((name) => `${name}=${encodeURIComponent(settings[name])}`),
  ].join("&");
}

function take(settings: Record<string, number | string>, name: string, text: string): string | undefined {
  if (Object.hasOwn(QUANTITIES, name)) {
    const { min, max, unit } = QUANTITIES[name as QuantityName];
    const value = text.trim() === "" ? Number.NaN : Number(text);
    if (!(value >= min && value <= max)) {
      return `${name}: ${text || "nothing"} is not a number from ${min} to ${max}${unit && ` ${unit}`}.`;
    }
    settings[name] = value;
  } else if (Object.hasOwn(CHOICES, name)) {
    const { among } = CHOICES[name as ChoiceName];
    if (!(among as readonly string[]).includes(text))
      return `${name}: ${text || "nothing"} is not one of ${among.join(", ")}.`;
    settings[name] = text;
  } else {
    return `There is no setting ${name}.`;
  }
  return undefined;
}

/** The best drive of the course, kept by the browser. */
import { driveOf, type Drive } from "../course/run";

const KEY = "neve-drive-course";

/** The best drive of a course; null if there is none, or none that can be read. */
export function loadBest(seed: number): Drive | null {
  try {
    return driveOf(JSON.parse(localStorage.getItem(`${KEY}-${seed}`) ?? "null"));
  } catch {
    return null; // what another version wrote, or storage that is closed to the page
  }
}

/** Keep a drive. False if the browser keeps nothing. */
export function keepBest(seed: number, drive: Drive): boolean {
  try {
    localStorage.setItem(`${KEY}-${seed}`, JSON.stringify(drive));
    return true;
  } catch {
    return false;
  }
}

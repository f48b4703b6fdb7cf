/** The snow of a run of Neve about a wheel, as `neve drive --fit` has recorded it (src/neve/drive/recording.py). */

import { inflated } from "./unpack";

/** Depth, mass and particles above the snow at one moment. */
export interface Moment {
  readonly depth: Float32Array; // m, of each cell, rows along the track
  readonly mass: Float32Array; // m, as depth at the density of the start
  readonly loose: Float32Array; // m, along, across, up of each particle
}

export interface Recording {
  readonly name: string;
  readonly snow: { strain: number; pressure: number; compaction: number; density: number; depth: number };
  /** Root mean square of what the law's sinkage differs by [m]. */
  readonly residual: number;
  readonly wheel: { radius: number; width: number };
  readonly times: readonly number[]; // s
  /** Axle along and across the track and above the least ground [m], and how far it has rolled [rad]. */
  readonly path: readonly (readonly [number, number, number])[];
  readonly spin: readonly number[];
  /** Upward force of the snow on the wheel [N], mean since the moment before. */
  readonly force: readonly number[];
  /** Cells along and across, their side, and the corner of the first [m]. */
  readonly patch: { nx: number; ny: number; cell: number; along: number; across: number };
  readonly ground: Float32Array; // m, of each cell
  readonly moments: readonly Moment[];
}

const FORMAT = 1;

/** Read a recording. Errors: Error with a sentence, if it is damaged or of another version. */
export async function readRecording(text: string): Promise<Recording> {
  try {
    const given = JSON.parse(text) as Given;
    if (given.format !== FORMAT) throw new Error(`format ${String(given.format)}`);
    return await unpacked(given);
  } catch (error) {
    const why = error instanceof Error ? error.message : String(error);
    throw new Error(`The recording is damaged or of another version of Neve (${why}).`, { cause: error });
  }
}

/** Get a recording of this name from the server. Errors: Error with a sentence. */
export async function fetchRecording(name: string): Promise<Recording> {
  const answer = await fetch(`recordings/${encodeURIComponent(name)}.json`);
  if (!answer.ok) throw new Error(`There is no recording ${name}; neve drive --fit RUN makes one of a run.`);
  return readRecording(await answer.text());
}

interface Given extends Omit<Recording, "ground" | "moments" | "force"> {
  readonly format: number;
  readonly force: readonly (number | null)[];
  readonly step: number;
  readonly ground: string;
  readonly depth: string;
  readonly mass: string;
  readonly loose: string;
  readonly counts: readonly number[];
}

async function unpacked(given: Given): Promise<Recording> {
  const { step, counts, times, path, spin, force, patch } = given;
  const cells = patch.nx * patch.ny;
  const [ground, depth, mass, loose] = await Promise.all(
    [given.ground, given.depth, given.mass, given.loose].map(inflated),
  );
  const n = times.length;
  const places = counts.reduce((sum, count) => sum + count, 0);
  const lengths = [path.length, spin.length, force.length, counts.length, depth!.length / cells];
  if (!(n > 1) || lengths.some((length) => length !== n)) throw new Error("lengths differ");
  if (mass!.length !== n * cells || ground!.length !== cells || loose!.length !== 3 * places)
    throw new Error("lengths differ");
  const [depths, masses] = [summed(depth!, cells, step), summed(mass!, cells, step)];
  let from = 0;
  const moments = counts.map((count, k) => {
    const own = Float32Array.from(loose!.subarray(from, (from += 3 * count)), (steps) => steps * step);
    return { depth: depths[k]!, mass: masses[k]!, loose: own };
  });
  const { name, snow, residual, wheel } = given;
  const forces = force.map((one) => one ?? 0);
  const heights = Float32Array.from(ground!, (steps) => steps * step);
  return { name, snow, residual, wheel, times, path, spin, force: forces, patch, ground: heights, moments };
}

/** The frames of differences as lengths [m]. */
function summed(differences: Uint16Array, cells: number, step: number): Float32Array[] {
  const now = new Uint16Array(cells);
  return Array.from({ length: differences.length / cells }, (_, k) => {
    for (let i = 0; i < cells; i++) now[i] = now[i]! + differences[k * cells + i]!;
    return Float32Array.from(now, (steps) => steps * step);
  });
}

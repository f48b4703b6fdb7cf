/** Ground and snow of a fall that Neve has counted, as `neve drive --snow` has written it (src/neve/drive/ground.py). */
import { inflated } from "./unpack";

/** Square cells, y of cell (i, j) north of those of (i, j - 1): that of number i * ny + j. */
export interface Snowed {
  readonly name: string;
  readonly nx: number;
  readonly ny: number;
  readonly cell: number; // m
  readonly ground: Float32Array; // m above the least
  readonly depth: Float32Array; // m, of the snow
}

const FORMAT = 1;

/** Read ground and snow. Errors: Error with a sentence, if they are damaged or of another version. */
export async function readGround(text: string): Promise<Snowed> {
  try {
    const given = JSON.parse(text) as Given;
    if (given.format !== FORMAT) throw new Error(`format ${String(given.format)}`);
    const { name, nx, ny, cell, step, depth_step } = given;
    const [ground, depth] = await Promise.all([given.ground, given.depth].map(inflated));
    if (!(nx >= 1 && ny >= 1) || ground!.length !== nx * ny || depth!.length !== nx * ny)
      throw new Error("lengths differ");
    if (!(cell > 0 && step > 0 && depth_step > 0)) throw new Error("a length is not above 0");
    const lengths = (numbers: Uint16Array, unit: number) => Float32Array.from(numbers, (n) => n * unit);
    return { name, nx, ny, cell, ground: lengths(ground!, step), depth: lengths(depth!, depth_step) };
  } catch (error) {
    const why = error instanceof Error ? error.message : String(error);
    throw new Error(`The snowed ground is damaged or of another version of Neve (${why}).`, { cause: error });
  }
}

/** Get the ground of this name from the server. Errors: Error with a sentence. */
export async function fetchGround(name: string): Promise<Snowed> {
  const answer = await fetch(`grounds/${encodeURIComponent(name)}.json`);
  if (!answer.ok)
    throw new Error(`There is no ground ${name}; neve drive --snow FOLDER makes one of a fall.`);
  return readGround(await answer.text());
}

interface Given {
  readonly format: number;
  readonly name: string;
  readonly nx: number;
  readonly ny: number;
  readonly cell: number;
  readonly step: number;
  readonly depth_step: number;
  readonly ground: string;
  readonly depth: string;
}

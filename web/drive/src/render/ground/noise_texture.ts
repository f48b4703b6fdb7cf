/** Noise that tiles, made once: a smooth fractal, its slopes, and white grains. */
import { DataTexture, LinearFilter, LinearMipmapLinearFilter, RepeatWrapping, RGBAFormat } from "three";
import { random } from "../../world/noise";

/** Smooth noise of a period of `period` lattice steps, 0..1, at (x, y) in steps. */
export function tiled(x: number, y: number, period: number, salt: number): number {
  const [i, j] = [Math.floor(x), Math.floor(y)];
  const [u, v] = [x - i, y - j];
  const [s, t] = [u * u * (3 - 2 * u), v * v * (3 - 2 * v)];
  const wrap = (k: number) => ((k % period) + period) % period;
  const at = (k: number, l: number) => random(wrap(k), wrap(l), salt);
  const near = at(i, j) * (1 - s) + at(i + 1, j) * s;
  const far = at(i, j + 1) * (1 - s) + at(i + 1, j + 1) * s;
  return near * (1 - t) + far * t;
}

/** Red, green: slope of a fractal with most of its power in fine detail; blue: a fractal of soft clouds; alpha: grains. */
export function noiseTexture(size = 256): DataTexture {
  const soft = new Float32Array(size * size);
  const crisp = new Float32Array(size * size);
  for (let j = 0; j < size; j++) {
    for (let i = 0; i < size; i++) {
      let [a, b] = [0, 0];
      for (let octave = 0; octave < 6; octave++) {
        const period = 4 << octave;
        const value = tiled((i / size) * period, (j / size) * period, period, octave) - 0.5;
        a += value / 2 ** octave;
        b += value / 2 ** (0.72 * octave);
      }
      soft[j * size + i] = a;
      crisp[j * size + i] = b;
    }
  }
  const data = new Uint8Array(4 * size * size);
  const at = (i: number, j: number) => crisp[(j & (size - 1)) * size + (i & (size - 1))]!;
  const byte = (v: number) => Math.min(255, Math.max(0, Math.round(255 * v)));
  for (let j = 0; j < size; j++) {
    for (let i = 0; i < size; i++) {
      const k = 4 * (j * size + i);
      data[k] = byte(0.5 + 3 * (at(i + 1, j) - at(i - 1, j)));
      data[k + 1] = byte(0.5 + 3 * (at(i, j + 1) - at(i, j - 1)));
      data[k + 2] = byte(0.5 + 0.62 * soft[j * size + i]!);
      data[k + 3] = byte(random(i, j, 77));
    }
  }
  const texture = new DataTexture(data, size, size, RGBAFormat);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

/** Bytes of the noise with its smaller copies. */
export const NOISE_BYTES = Math.round((4 / 3) * 4 * 256 ** 2);

/** What a frame costs, as the corner of the page shows it. */
export interface Cost {
  readonly frame: number; // s, from one frame to the next
  readonly drawCalls: number; // of the picture and the snow together
  readonly triangles: number;
  readonly textureBytes: number; // as asked of WebGL: widths x heights x bytes of a texel
  readonly snowBytes: number; // read and written by the last update of the snow
  readonly storedTiles: number; // tiles of tracks that are kept outside the window
  readonly window: number; // m, side of the snow window
}

/** What integrated graphics are allowed at 60 frames/s; docs/drive.md says why. */
export const BUDGET = { drawCalls: 150, triangles: 500_000, textureBytes: 128e6, snowBytes: 8e6 } as const;

/** Say the cost in lines of text; what exceeds the budget is marked. */
export function lines(cost: Cost): string[] {
  const over = (value: number, most: number): string => (value > most ? "  over budget" : "");
  const mega = (bytes: number): string => `${(bytes / 1e6).toFixed(bytes < 10e6 ? 2 : 0)} MB`;
  return [
    `${(cost.frame * 1e3).toFixed(1)} ms a frame, ${(1 / Math.max(cost.frame, 1e-6)).toFixed(0)} frames/s`,
    `${cost.drawCalls} draw calls${over(cost.drawCalls, BUDGET.drawCalls)}`,
    `${cost.triangles.toLocaleString("en")} triangles${over(cost.triangles, BUDGET.triangles)}`,
    `${mega(cost.textureBytes)} of textures${over(cost.textureBytes, BUDGET.textureBytes)}`,
    `${mega(cost.snowBytes)} moved by the snow${over(cost.snowBytes, BUDGET.snowBytes)}`,
    `window of ${cost.window.toFixed(0)} m, ${cost.storedTiles} tiles kept outside`,
  ];
}

/** A mean over about half a second, so that figures can be read. */
export class Smooth {
  private value = 0;
  private weight = 0;

  /** Take in a value that held for dt [s], and return the mean. */
  take(value: number, dt: number): number {
    const keep = Math.exp(-dt / 0.5);
    this.value = this.value * keep + value * (1 - keep);
    this.weight = this.weight * keep + (1 - keep);
    return this.weight > 0 ? this.value / this.weight : value;
  }
}

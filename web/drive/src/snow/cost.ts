import type { SnowField } from "./field";

/** What a field costs, in counts that hold on any machine. */
export interface SnowCost {
  /** Bytes of all its textures. */
  readonly textureBytes: number;
  /** Bytes that its last update read and wrote. */
  readonly updateBytes: number;
  /** Draws of its last update. */
  readonly draws: number;
  /** Tiles that are kept on the processor, 32 KB each. */
  readonly storedTiles: number;
}

/** Return what a field costs; the time of an update is about `updateBytes` over the bandwidth of the memory. */
export function costOf(field: SnowField): SnowCost {
  const { textureBytes, bytesPerUpdate, drawCalls, storedTiles } = field;
  return { textureBytes, updateBytes: bytesPerUpdate, draws: drawCalls, storedTiles };
}

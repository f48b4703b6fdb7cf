/** What the visitor can change about the snow. */
export interface SnowSettings {
  /** Depth of fresh snow where the cover is 1 [m]. */
  depth: number;
  /** Share of what is pressed that is compacted, 0..1; the rest goes to the rims. */
  compaction: number;
  /** Share of the rims beside the wheel, 0..1; the rest lies behind it. */
  rimShare: number;
  /** Angle of repose of loose snow [degrees]. */
  repose: number;
  /** Time constant by which tracks fade [s]; Infinity: they stay. */
  recovery: number;
  /** Rate at which falling snow fills tracks [m/s]. */
  snowfall: number;
}

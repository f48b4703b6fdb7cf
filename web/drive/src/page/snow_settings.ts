import type { Settings } from "../settings";
import type { SnowSettings } from "../snow/settings";

/** What the snow needs of the settings, in its units: snowfall comes in mm/min and goes in m/s. */
export function snowSettings(settings: Settings): SnowSettings {
  const { depth, compaction, rimShare, repose, recovery, snowfall } = settings;
  return { depth, compaction, rimShare, repose, recovery, snowfall: snowfall / 60e3 };
}

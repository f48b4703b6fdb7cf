/** A page that renders the sound of a mix without speakers: `hear` gives its loudness and its crossings of zero. */
import { tune, voices, type Mix } from "../../src/page/sound";

const page = {
  /** Root mean square of half a second, and changes of sign in a second. */
  async hear(mix: Mix): Promise<{ loud: number; crossings: number }> {
    const context = new OfflineAudioContext(1, 12_000, 24_000);
    tune(voices(context), mix, true);
    const data = (await context.startRendering()).getChannelData(0);
    let [sum, crossings] = [0, 0];
    for (let k = 1; k < data.length; k++) {
      sum += data[k]! ** 2;
      if (data[k]! * data[k - 1]! < 0) crossings++;
    }
    return { loud: Math.sqrt(sum / data.length), crossings: 2 * crossings };
  },
};

declare global {
  interface Window {
    sound: typeof page;
  }
}
window.sound = page;

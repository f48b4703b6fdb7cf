/** The demo in a browser that draws by the processor: it stands still until a test moves it, whatever the clock says. */
import type { Page } from "playwright-core";
import type { Demo } from "../../src/demo";
import { visit, type Visit } from "./browser";

declare global {
  interface Window {
    neveDrive?: Demo;
  }
}

/** Controls that ask for nothing. */
export const STILL = { steer: 0, throttle: 0, brake: 0, handbrake: 0, reset: false };

/**
 * Open the demo with these settings in its address. It is held, and when it is let go its frames pass without a
 * picture: `demo.stage.render` draws one where it is looked at.
 */
export async function openDemo(settings: string, size = {}): Promise<Visit> {
  const visitor = await visit("", { search: `?held#${settings}`, ...size });
  const { page } = visitor;
  await page.waitForFunction(() => window.neveDrive, null, { polling: 100 });
  await page.evaluate(() => (window.neveDrive!.draw = () => undefined));
  return visitor;
}

/** Let the page go until the words of an element contain a part, and hold it again; the words. */
export function hear(page: Page, id: string, part: string): Promise<string> {
  return page.evaluate(
    async ([of, wanted]) => {
      const demo = window.neveDrive!;
      const words = () => document.getElementById(of)!.textContent!;
      demo.held = false;
      while (!words().includes(wanted)) await new Promise((next) => requestAnimationFrame(next));
      demo.held = true;
      return words();
    },
    [id, part] as const,
  );
}

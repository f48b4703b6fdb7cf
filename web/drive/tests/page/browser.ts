import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { delimiter, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium, type Browser, type Page } from "playwright-core";
import { build, preview } from "vite";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));

/** The browser for tests: what NEVE_BROWSER names, else the first Chromium or Chrome on the path, else null. */
export function findBrowser(): string | null {
  const named = process.env["NEVE_BROWSER"];
  if (named) return named;
  const folders = (process.env["PATH"] ?? "").split(delimiter);
  for (const name of ["chromium", "chromium-browser", "google-chrome"])
    for (const folder of folders) if (existsSync(join(folder, name))) return join(folder, name);
  return null;
}

export const BROWSER = findBrowser();

/** How long a page is waited for [ms]: on a busy machine the processor draws a picture in many seconds. */
const PATIENCE = 280_000;

/** Whether to skip tests that need a page; says so once. */
export const NO_BROWSER = BROWSER === null;
if (NO_BROWSER)
  console.warn("No Chromium was found (name one by NEVE_BROWSER): the tests of the page are skipped.");

/** A page of this folder in a browser that draws with the processor, and what it complained about. */
export interface Visit {
  readonly page: Page;
  /** Address of the server, ending in a slash. */
  readonly address: string;
  /** Uncaught errors and lines of console.error, in order. */
  readonly errors: string[];
  close(): Promise<void>;
}

/** Build one page of this folder, or the demo with all its pages (""), into a folder of its own. */
async function built(path: string): Promise<string> {
  const outDir = mkdtempSync(join(tmpdir(), "neve-page-"));
  const quiet = { root: ROOT, base: "./", logLevel: "error" } as const;
  if (path === "") await build({ ...quiet, build: { outDir, emptyOutDir: true } });
  else {
    const options = { outDir, emptyOutDir: true, rolldownOptions: { input: join(ROOT, path) } };
    // Without the settings of the demo, whose pages are not wanted here.
    await build({ ...quiet, configFile: false, build: options });
  }
  return outDir;
}

async function launch(): Promise<Browser> {
  if (BROWSER === null) throw new Error("no browser");
  return chromium.launch({
    executablePath: BROWSER,
    args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--mute-audio"],
  });
}

/**
 * Open a page of this folder: "tests/page/snow.html", or "" for the demo itself; it is built for this. A query or a
 * hash goes into `search`.
 */
export async function visit(
  path: string,
  options: { width?: number; height?: number; touch?: boolean; search?: string } = {},
): Promise<Visit> {
  const outDir = await built(path);
  const server = await preview({
    root: ROOT,
    logLevel: "error",
    preview: { host: "127.0.0.1", port: 0 },
    build: { outDir },
  });
  const port = server.httpServer.address();
  if (!port || typeof port === "string") throw new Error("the server of the page has no port");
  const address = `http://127.0.0.1:${port.port}/`;
  const browser = await launch();
  const context = await browser.newContext({
    viewport: { width: options.width ?? 320, height: options.height ?? 200 },
    deviceScaleFactor: 0.5, // a quarter of the pixels: the processor draws them
    hasTouch: options.touch ?? false,
  });
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  const errors: string[] = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (line) => {
    if (line.type() === "error") errors.push(line.text());
  });
  await page.goto(address + path + (options.search ?? ""));
  return {
    page,
    address,
    errors,
    async close() {
      await browser.close();
      await server.close();
      rmSync(outDir, { recursive: true });
    },
  };
}

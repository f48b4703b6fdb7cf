import { defineConfig } from "vitest/config";

// The built page goes into the Python package, from where `neve drive` serves it. Paths are relative, so that any
// folder of any server (or a docs site) can carry it.
export default defineConfig({
  base: "./",
  build: {
    outDir: "../../src/neve/drive/page",
    emptyOutDir: true,
    chunkSizeWarningLimit: 3000,
    rolldownOptions: { input: ["index.html", "lab.html", "walk.html"] },
  },
  test: {
    include: ["tests/**/*.test.ts"],
    testTimeout: 300_000, // a page that is drawn by a busy processor takes its time
    hookTimeout: 300_000,
    fileParallelism: false,
  },
});

import { defineConfig } from "vite";

export default defineConfig({
  base: "./",
  build: {
    outDir: "node_modules/.page",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 2000,
    // Of what the page contains; it is a part of the wheel.
    license: { fileName: "licenses.md" },
  },
});

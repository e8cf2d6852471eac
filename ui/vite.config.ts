import { defineConfig } from "vite";
import type { HtmlTagDescriptor, Plugin } from "vite";

/** The part of the page that starts the layout's worker. */
const EARLY = "early";

/** `early` runs before all else; what the page imports first of all is fetched at once, not when the entry has begun. */
const preload: Plugin = {
  name: "preload",
  transformIndexHtml: {
    order: "post",
    handler: (_, { bundle = {} }) => {
      const chunks = Object.values(bundle).flatMap((each) => (each.type === "chunk" ? [each] : []));
      const withImports = (names: readonly string[]): string[] => names.flatMap((name) => [name, ...withImports(chunks.find((each) => each.fileName === name)!.imports)]);
      const entries = chunks.filter((each) => each.isEntry);
      const early = entries.find((each) => each.name === EARLY)?.fileName;
      const begun = withImports(entries.map((each) => each.fileName));
      const next = new Set(withImports(entries.flatMap((each) => each.dynamicImports)).filter((each) => !begun.includes(each)));
      const first: HtmlTagDescriptor[] = early ? [{ tag: "script", attrs: { type: "module", async: true, crossorigin: true, src: `./${early}` }, injectTo: "head-prepend" }] : [];
      return [...first, ...[...next].map((each): HtmlTagDescriptor => ({ tag: "link", attrs: { rel: "modulepreload", crossorigin: true, href: `./${each}` }, injectTo: "head" }))];
    },
  },
};

export default defineConfig({
  base: "./",
  plugins: [preload],
  build: {
    rollupOptions: { input: { index: "index.html", [EARLY]: "src/early.ts" } },
    outDir: "node_modules/.page",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 2000,
    // Of what the page contains; it is a part of the wheel.
    license: { fileName: "licenses.md" },
  },
});

/** Workaround: uPlot fails to load if the browser's language is not a BCP 47 tag (`en-US@posix`). */

try {
  new Intl.NumberFormat(navigator.language);
} catch {
  Object.defineProperty(navigator, "language", { value: "en" });
}

export {};

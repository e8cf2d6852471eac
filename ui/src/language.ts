/** Some browsers have a language that is no tag of BCP 47, `en-US@posix`, at which uPlot fails when it is loaded. */

try {
  new Intl.NumberFormat(navigator.language);
} catch {
  Object.defineProperty(navigator, "language", { value: "en" });
}

export {};

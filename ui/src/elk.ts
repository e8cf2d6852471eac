/** The layout's worker: small, so that it has started, and takes messages, before the page draws; it then loads ELK. */

import program from "elkjs/lib/elk-worker.min.js?url";

declare function importScripts(url: string): void;

self.onmessage = (first) => {
  importScripts(program);
  // ELK has put its own in this place.
  self.onmessage?.call(self, first);
};

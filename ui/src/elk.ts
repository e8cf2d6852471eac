/** The layout's worker: small, so that it takes messages before the page draws; the first one makes it load ELK. */

import program from "elkjs/lib/elk-worker.min.js?url";

declare function importScripts(url: string): void;

// ELK puts its own handler in this place.
self.onmessage = () => importScripts(program);

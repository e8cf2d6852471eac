/** Starts the layout's worker before the rest of the page is read: it takes longest to load. */

const start = (): Worker => new Worker(new URL("./elk.ts", import.meta.url));

let first: Worker | undefined = start();
// Nobody listens to it yet: the next one fails before those who do.
first.onerror = () => (first = undefined);

/** A worker that nobody uses. */
export function layoutWorker(): Worker {
  const worker = first ?? start();
  first = undefined;
  return worker;
}

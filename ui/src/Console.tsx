/** What this page has asked for, what was refused and why, and what the run has said. */

import { useState } from "react";
import type { Said } from "./store.ts";

export function Console({ said }: { said: readonly Said[] }) {
  const [filter, setFilter] = useState("");
  const words = filter.toLowerCase().split(/\s+/);
  const shown = said.filter(({ kind, text }) => words.every((word) => `${kind} ${text}`.toLowerCase().includes(word)));
  return (
    <>
      <input type="search" aria-label="Filter of the console" placeholder="Words, refused, error" value={filter} onChange={(e) => setFilter(e.target.value)} />
      {!shown.length && <p className="empty">{said.length ? `No line has “${filter}”.` : "Nothing has been said yet. Commands of this page and what the run says appear here."}</p>}
      <ol className="console" aria-label="Console">
        {[...shown].reverse().map(({ number, when, kind, text }) => (
          <li key={number} className={kind}>
            <time>{when}</time> <strong>{kind}</strong> <bdi>{text}</bdi>
          </li>
        ))}
      </ol>
    </>
  );
}

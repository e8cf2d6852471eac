/** What this page has asked for, what was refused and why, and what the run has said. */

import { useState } from "react";
import type { Said } from "./store.ts";
import { kindOf } from "./store.ts";
import { t } from "./texts.ts";

export function Console({ said }: { said: readonly Said[] }) {
  const [filter, setFilter] = useState("");
  const words = filter.toLowerCase().split(/\s+/);
  const shown = said.filter(({ kind, text }) => words.every((word) => `${kind} ${kindOf(kind)} ${text}`.toLowerCase().includes(word)));
  return (
    <>
      <input type="search" aria-label={t("Filter of the console")} placeholder={t("Words, refused, error")} value={filter} onChange={(e) => setFilter(e.target.value)} />
      {!shown.length && <p className="empty">{said.length ? t("No line has “{filter}”.", { filter }) : t("Nothing has been said yet. Commands of this page and what the run says appear here.")}</p>}
      <ol className="console" aria-label={t("Console")}>
        {[...shown].reverse().map(({ number, when, kind, text }) => (
          <li key={number} className={kind}>
            <time>{when}</time> <strong>{kindOf(kind)}</strong> <bdi>{text}</bdi>
          </li>
        ))}
      </ol>
    </>
  );
}

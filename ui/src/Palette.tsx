/** The types of components that can be added, by category, and the trees of naming services. */

import { GripVertical, X } from "lucide-react";
import { useState } from "react";
import { IconButton } from "./kit/Button.tsx";
import { Naming } from "./Naming.tsx";
import type { PaletteEntry, SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";

/** The kind of the data of a drag of a component's type. */
export const DRAGGED = "application/x-rtgen-component";

/** The entries by category, both by name. */
function grouped(entries: readonly PaletteEntry[]): [string, PaletteEntry[]][] {
  const groups = new Map<string, PaletteEntry[]>();
  for (const each of entries) groups.set(each.category || t("other"), [...(groups.get(each.category || t("other")) ?? []), each]);
  return [...groups].sort(([one], [other]) => one.localeCompare(other));
}

/** Whether each word of a filter is in the name, the category, the description or a port of a type. */
function isFound(entry: PaletteEntry, filter: string): boolean {
  const text = [entry.type, entry.category, entry.doc, ...entry.ports.flatMap((each) => [each.name, each.type])].join(" ").toLowerCase();
  return filter
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

export function Palette(props: { system: SystemState; full: boolean; selected: string; select: (instance: string) => void; close: () => void }) {
  const { system, full, selected, select, close } = props;
  const [filter, setFilter] = useState("");
  const found = system.palette.filter((each) => isFound(each, filter));
  return (
    <nav className="palette" aria-label={t("Palette")} data-view="Palette" tabIndex={-1}>
      <Naming system={system} full={full} selected={selected} select={select} />
      {system.palette.length > 0 && (
        <section aria-label={t("Components to add")}>
          <div className="title">
            <h2>{t("Components")}</h2>
            <IconButton icon={X} look="plain" label={t("Close the palette")} onClick={close} />
          </div>
          <input type="search" aria-label={t("Filter of components")} placeholder={t("Name, category, port, type")} value={filter} onChange={(e) => setFilter(e.target.value)} />
          {!found.length && <p className="empty">{t("No component has “{filter}”.", { filter })}</p>}
          {grouped(found).map(([category, entries]) => (
            <details key={category} open>
              <summary>
                <bdi>{category}</bdi> <small>{entries.length}</small>
              </summary>
              <ul>
                {entries.map((entry) => (
                  <li key={entry.type}>
                    <button
                      type="button"
                      className="plain"
                      disabled={!full}
                      draggable={full}
                      title={[entry.type, entry.doc].filter(Boolean).join("\n")}
                      aria-label={t("Add {type}", { type: entry.type })}
                      onDragStart={(e) => {
                        e.dataTransfer.setData(DRAGGED, entry.type);
                        e.dataTransfer.effectAllowed = "copy";
                      }}
                      onClick={() => store.order({ case: "added", value: { type: entry.type, instance: "", placed: false, where: { x: 0, y: 0 } } })}
                    >
                      <GripVertical size={14} aria-hidden />
                      <span>{entry.type}</span>
                    </button>
                  </li>
                ))}
              </ul>
            </details>
          ))}
        </section>
      )}
    </nav>
  );
}

/** Components that can be added, and what is done to all at once. */

import { Naming } from "./Naming.tsx";
import type { SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";

/** What a system is chosen by: its name first, which is not cut then. */
function named(file: string): string {
  const [, folder, name] = /^(?:(.*)\/)?([^/]*?)(?:\.xml)?$/.exec(file)!;
  return folder ? `${name} (${folder})` : name!;
}

export function Palette(props: { system: SystemState; full: boolean; selected: string; select: (instance: string) => void }) {
  const { system, full, selected, select } = props;
  const { edits } = system;
  return (
    <nav className="palette" aria-label="Palette">
      <section className="buttons" aria-label="All components">
        <button type="button" disabled={!full} onClick={() => store.order({ case: "activated", value: [] })}>
          Activate all
        </button>
        <button type="button" disabled={!full} onClick={() => store.order({ case: "deactivated", value: [] })}>
          Deactivate all
        </button>
        <button type="button" disabled={!full} onClick={() => store.order({ case: "restored", value: [] })}>
          Reset all
        </button>
        <button type="button" title={edits.undo} disabled={!full || !edits.undo} onClick={() => store.order({ case: "undone", value: true })}>
          Undo
        </button>
        <button type="button" title={edits.redo} disabled={!full || !edits.redo} onClick={() => store.order({ case: "redone", value: true })}>
          Redo
        </button>
        <button type="button" disabled={!full || edits.saved} onClick={() => store.order({ case: "file", value: "" })}>
          Save
        </button>
      </section>
      {system.systems.length > 1 && (
        <label>
          System
          <select disabled={!full} value={system.edits.file} onChange={(e) => store.order({ case: "system", value: e.target.value })}>
            {!system.systems.includes(system.edits.file) && <option value={system.edits.file}>{system.name}</option>}
            {system.systems.map((file) => (
              <option key={file} value={file}>
                {named(file)}
              </option>
            ))}
          </select>
        </label>
      )}
      <Naming services={system.naming} components={system.components} selected={selected} select={select} />
      {system.palette.length > 0 && <h2>Components</h2>}
      <ul>
        {system.palette.map((entry) => (
          <li key={entry.type}>
            <button
              type="button"
              disabled={!full}
              title={entry.doc}
              aria-label={`Add ${entry.type}`}
              onClick={() =>
                store.order({
                  case: "added",
                  value: { type: entry.type, instance: "", placed: false, where: { x: 0, y: 0 } },
                })
              }
            >
              {entry.type}
            </button>
          </li>
        ))}
      </ul>
    </nav>
  );
}

/** The types of components that can be added, and commands for all components. */

import { useEffect, useState } from "react";
import { Naming } from "./Naming.tsx";
import type { Command, EditState, SystemState } from "./protocol/Ui.ts";
import { Question } from "./Question.tsx";
import { store } from "./store.ts";

/** The names of systems by their files, with the folder where a name alone is ambiguous. */
function namesOf(files: readonly string[]): ReadonlyMap<string, string> {
  const parts = files.map((file) => /^(?:(.*)\/)?([^/]*?)(?:\.xml)?$/.exec(file)!);
  const isAmbiguous = (name: string) => parts.filter((each) => each[2] === name).length > 1;
  return new Map(parts.map(([file, folder, name]) => [file, folder && isAmbiguous(name!) ? `${name} (${folder})` : name!]));
}

/** A button that keeps the focus when it is disabled. */
function Edit({ name, title, enabled, act }: { name: string; title?: string; enabled: boolean; act: Command }) {
  return (
    <button type="button" title={title} aria-disabled={!enabled} onClick={() => enabled && store.order(act)}>
      {name}
    </button>
  );
}

/** The code of a result that the user must decide about. */
const QUESTION = "UIS0011";
const SAID_FOR = 3000;

/** Saves the system, optionally under a new name; other files are replaced only when the user says so. */
function Save({ edits, full }: { edits: EditState; full: boolean }) {
  const [edited, edit] = useState<string>();
  const [question, ask] = useState<string>();
  const [said, say] = useState("");
  const name = edited ?? edits.file;
  const enabled = full && name.trim() !== "" && (!edits.saved || name !== edits.file);
  useEffect(() => {
    const silence = said ? setTimeout(() => say(""), SAID_FOR) : undefined;
    return () => clearTimeout(silence);
  }, [said]);
  const save = async (asked: "file" | "replaced") => {
    const result = await store.ask({ case: asked, value: name.trim() });
    const message = [result.message, result.hint].filter(Boolean).join(": ");
    if (result.code === QUESTION) {
      ask(message);
      return;
    }
    store.notify(result.done ? "" : message);
    if (!result.done) return;
    edit((now) => (now === name ? undefined : now));
    say([`Saved ${name.trim()}`, result.text].filter(Boolean).join("; "));
  };
  return (
    <>
    <form
      className="save"
      onSubmit={(e) => {
        e.preventDefault();
        if (enabled) void save("file");
      }}
    >
      <textarea
        aria-label="File of the system"
        placeholder="system.xml"
        rows={1}
        title={name}
        disabled={!full}
        value={name}
        onChange={(e) => edit(e.target.value.replace(/[\r\n]/g, ""))}
        onKeyDown={(e) => {
          if (e.key !== "Enter") return;
          e.preventDefault();
          e.currentTarget.form!.requestSubmit();
        }}
      />
      <button type="submit" aria-disabled={!enabled}>
        Save
      </button>
      <output>{said || (edits.saved ? "" : "unsaved edits")}</output>
    </form>
    {question !== undefined && <Question text={question} name="Replace" yes={() => void save("replaced")} close={() => ask(undefined)} />}
    </>
  );
}

/** Opens another system; edits that are not saved are lost only when the user says so. */
function Systems({ system, full }: { system: SystemState; full: boolean }) {
  const { edits } = system;
  const [wanted, want] = useState<string>();
  const open = (file: string) => void store.order({ case: "system", value: file });
  return (
    <>
    <label>
      System
      <select title={edits.file} disabled={!full} value={edits.file} onChange={({ target: { value } }) => (edits.saved ? open(value) : want(value))}>
        {!system.systems.includes(edits.file) && <option value={edits.file}>{system.name}</option>}
        {[...namesOf(system.systems)].map(([file, name]) => (
          <option key={file} value={file}>
            {name}
          </option>
        ))}
      </select>
    </label>
    {wanted !== undefined && (
      <Question text={`The edits of ${edits.file} are not saved. Open ${wanted} without them?`} name="Discard edits" yes={() => open(wanted)} close={() => want(undefined)} />
    )}
    </>
  );
}

export function Palette(props: { system: SystemState; full: boolean; selected: string; select: (instance: string) => void }) {
  const { system, full, selected, select } = props;
  const { edits } = system;
  // Afterwards the user controls it.
  const [roomy] = useState(() => matchMedia("(min-width: 1001px)").matches);
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
        <Edit name="Undo" title={edits.undo} enabled={full && edits.undo !== ""} act={{ case: "undone", value: true }} />
        <Edit name="Redo" title={edits.redo} enabled={full && edits.redo !== ""} act={{ case: "redone", value: true }} />
      </section>
      <Save edits={edits} full={full} />
      {system.systems.length > 1 && <Systems system={system} full={full} />}
      <Naming system={system} full={full} selected={selected} select={select} />
      {system.palette.length > 0 && (
        <details open={roomy}>
          <summary>Components</summary>
          <ul>
            {system.palette.map((entry) => (
              <li key={entry.type}>
                <button
                  type="button"
                  disabled={!full}
                  title={[entry.type, entry.doc].filter(Boolean).join("\n")}
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
        </details>
      )}
    </nav>
  );
}

/** The head of the page: what runs, its file and edits, all components at once, and the way to everything else. */

import { CircleHelp, Command as CommandIcon, Languages as LanguagesIcon, LayoutPanelLeft, Play, Plus, Redo2, RotateCcw, Square, Undo2 } from "lucide-react";
import { useEffect, useState } from "react";
import { Button, IconButton } from "./kit/Button.tsx";
import { Question } from "./kit/Dialog.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import { Menu } from "./Menu.tsx";
import type { Place } from "./Menu.tsx";
import type { EditState, SystemState } from "./protocol/Ui.ts";
import type { Page } from "./store.ts";
import { obstacleToAll, reasonOf, store } from "./store.ts";
import { LANGUAGES, language, languages, t } from "./texts.ts";
import type { View } from "./views.ts";
import { LAYOUTS, PRESETS, obstacleToPreset } from "./views.ts";

/** The names of systems by their files, with the folder where a name alone is ambiguous. */
function namesOf(files: readonly string[]): ReadonlyMap<string, string> {
  const parts = files.map((file) => /^(?:(.*)\/)?([^/]*?)(?:\.xml)?$/.exec(file)!);
  const isAmbiguous = (name: string) => parts.filter((each) => each[2] === name).length > 1;
  return new Map(parts.map(([file, folder, name]) => [file, folder && isAmbiguous(name!) ? `${name} (${folder})` : name!]));
}

/** What the page shows, in words. */
const LINKS = {
  connecting: t("connecting"),
  live: t("live"),
  lost: t("lost"),
  refused: t("refused"),
  recording: t("recording"),
  past: t("looking back"),
} as const;

/** The code of a result that the user must decide about. */
const QUESTION = "UIS0011";
const SAID_FOR = 3000;

/** Saves the system, optionally under a new name; other files are replaced only when the user says so. */
function Save({ edits, full }: { edits: EditState; full: boolean }) {
  const [edited, edit] = useState<string>();
  const [question, ask] = useState<string>();
  const [said, say] = useState("");
  const [refused, refuse] = useState("");
  const name = edited ?? edits.file;
  const enabled = full && name.trim() !== "" && (!edits.saved || name !== edits.file);
  useEffect(() => {
    const silence = said ? setTimeout(() => say(""), SAID_FOR) : undefined;
    return () => clearTimeout(silence);
  }, [said]);
  const save = async (asked: "file" | "replaced") => {
    const result = await store.ask({ case: asked, value: name.trim() });
    if (result.code === QUESTION) {
      ask(reasonOf(result));
      return;
    }
    refuse(reasonOf(result));
    store.refuse(reasonOf(result));
    if (!result.done) return;
    edit((now) => (now === name ? undefined : now));
    say([t("Saved {file}", { file: name.trim() }), result.text].filter(Boolean).join("; "));
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
        <Refusable reason={refused}>
          {(said) => (
            <textarea
              {...said}
              aria-label={t("File of the system")}
              placeholder={t("system.xml")}
              rows={1}
              title={name}
              disabled={!full}
              value={name}
              onChange={(e) => {
                edit(e.target.value.replace(/[\r\n]/g, ""));
                refuse("");
              }}
              onKeyDown={(e) => {
                if (e.key !== "Enter") return;
                e.preventDefault();
                e.currentTarget.form!.requestSubmit();
              }}
            />
          )}
        </Refusable>
        <Button type="submit" look={enabled && !edits.saved ? "primary" : "quiet"} aria-disabled={!enabled}>
          {t("Save")}
        </Button>
        <output>{said || (edits.saved ? "" : t("unsaved edits"))}</output>
      </form>
      {question !== undefined && <Question text={question} name={t("Replace")} yes={() => void save("replaced")} close={() => ask(undefined)} />}
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
        <span className="announced">{t("System")}</span>
        <select aria-label={t("System")} title={edits.file} disabled={!full} value={edits.file} onChange={({ target: { value } }) => (edits.saved ? open(value) : want(value))}>
          {!system.systems.includes(edits.file) && <option value={edits.file}>{system.name}</option>}
          {[...namesOf(system.systems)].map(([file, name]) => (
            <option key={file} value={file}>
              {name}
            </option>
          ))}
        </select>
      </label>
      {wanted !== undefined && (
        <Question text={t("The edits of {file} are not saved. Open {wanted} without them?", { file: edits.file, wanted })} name={t("Discard edits")} yes={() => open(wanted)} close={() => want(undefined)} />
      )}
    </>
  );
}

/** The mark of rtgen: two ports and the wire between them. */
function Mark() {
  return (
    <svg className="mark" viewBox="0 0 32 32" width="26" height="26" aria-hidden>
      <rect x="1" y="1" width="30" height="30" rx="8" fill="var(--accent)" />
      <path d="M9 11h6c4 0 2 10 6 10h2" fill="none" stroke="var(--on-accent)" strokeWidth="2.6" strokeLinecap="round" />
      <path d="M5 7l6 4-6 4z M21 17l6 4-6 4z" fill="var(--on-accent)" />
    </svg>
  );
}

interface Shown {
  page: Page;
  full: boolean;
  /** Whether the palette is open. */
  adding: boolean;
  add: (shown: boolean) => void;
}

/** The system's file, the palette, and all components at once: in the head, or behind `More` on a phone. */
export function Tools({ page: { system }, full, adding, add }: Shown) {
  if (!system) return null;
  const obstacle = obstacleToAll(system);
  const enabled = full && !obstacle;
  const tip = (name: string) => [name, obstacle].filter(Boolean).join(": ");
  return (
    <>
      {system.systems.length > 1 && <Systems system={system} full={full} />}
      <Save edits={system.edits} full={full} />
      {system.palette.length > 0 && (
        <Button icon={Plus} aria-pressed={adding} onClick={() => add(!adding)}>
          {t("Components")}
        </Button>
      )}
      <div className="group" role="group" aria-label={t("All components")}>
        <Button icon={Play} disabled={!enabled} aria-label={t("Activate all")} title={tip(t("Activate all components"))} onClick={() => store.order({ case: "activated", value: [] })}>
          {t("All")}
        </Button>
        <IconButton icon={Square} label={t("Deactivate all")} tip={tip(t("Deactivate all"))} disabled={!enabled} onClick={() => store.order({ case: "deactivated", value: [] })} />
        <IconButton icon={RotateCcw} label={t("Reset all")} tip={tip(t("Reset all"))} disabled={!enabled} onClick={() => store.order({ case: "restored", value: [] })} />
      </div>
    </>
  );
}

interface Arranging {
  arrange: (name: string) => void;
  /** Why a view has nothing to show. */
  emptiness: (view: View) => string;
}

/** Panes for a purpose. */
function Layouts({ arrange, emptiness }: Arranging) {
  const [menu, show] = useState<Place>();
  return (
    <>
      <Button
        icon={LayoutPanelLeft}
        aria-haspopup="menu"
        onClick={(e) => {
          const box = e.currentTarget.getBoundingClientRect();
          show({ label: t("Layouts"), x: box.left, y: box.bottom });
        }}
      >
        {t("Layout")}
      </Button>
      {menu && <Menu place={menu} items={Object.keys(PRESETS).map((name) => ({ name: LAYOUTS[name] ?? name, act: () => arrange(name), obstacle: obstacleToPreset(name, emptiness) }))} close={() => show(undefined)} />}
    </>
  );
}

/** The languages of the page; the one that is chosen is remembered. */
export function LanguageMenu() {
  const [menu, show] = useState<Place>();
  return (
    <>
      <IconButton
        icon={LanguagesIcon}
        look="plain"
        label={t("Language: {name}", { name: LANGUAGES[language] })}
        aria-haspopup="menu"
        onClick={(e) => {
          const box = e.currentTarget.getBoundingClientRect();
          show({ label: t("Languages"), x: box.left, y: box.bottom });
        }}
      />
      {menu && <Menu place={menu} items={languages()} close={() => show(undefined)} />}
    </>
  );
}

export function Head(props: Shown & Arranging & { isPhone: boolean; isWide: boolean; ask: (what: "commands" | "keys") => void }) {
  const { page, full, isPhone, isWide, arrange, emptiness, ask } = props;
  const { system } = page;
  const past = system?.time.past ?? false;
  const { undo = "", redo = "" } = system?.edits ?? {};
  const link = page.link === "live" && past ? (system?.time.kind === "CLOCK_RECORDING" ? "recording" : "past") : page.link;
  return (
    <header>
      <Mark />
      <div className="name">
        <h1 title={system?.name}>{system?.name || "rtgen"}</h1>
        {system?.doc && !isPhone && <p title={system.doc}>{system.doc}</p>}
      </div>
      {system && (
        <>
          {!isPhone && <Tools {...props} />}
          <div className="toolbar" role="group" aria-label={t("Edits")}>
            <IconButton icon={Undo2} label={t("Undo")} tip={undo ? t("Undo: {undo}", { undo }) : t("Undo")} keys="Ctrl Z" disabled={!full || undo === ""} onClick={() => store.order({ case: "undone", value: true })} />
            <IconButton icon={Redo2} label={t("Redo")} tip={redo ? t("Redo: {redo}", { redo }) : t("Redo")} keys="Ctrl Y" disabled={!full || redo === ""} onClick={() => store.order({ case: "redone", value: true })} />
          </div>
          {isWide && <Layouts arrange={arrange} emptiness={emptiness} />}
        </>
      )}
      <span className={`link ${page.link}`} role="status">
        {LINKS[link]}
        {page.link === "live" && !page.full && t(", read only")}
      </span>
      <div className="toolbar">
        <IconButton icon={CommandIcon} look="plain" label={t("Commands")} keys="Ctrl K" onClick={() => ask("commands")} />
        {!isPhone && <LanguageMenu />}
        {!isPhone && <IconButton icon={CircleHelp} look="plain" label={t("Keys")} keys="?" onClick={() => ask("keys")} />}
      </div>
    </header>
  );
}

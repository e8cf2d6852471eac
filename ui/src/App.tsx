/** The page: palette, wiring, panel of the selected component, time. */

import { useCallback, useEffect, useState, useSyncExternalStore } from "react";
import { Palette } from "./Palette.tsx";
import type { Tab } from "./Panel.tsx";
import { Panel, VIEW } from "./Panel.tsx";
import { openPicker } from "./picker.ts";
import { TimeBar } from "./TimeBar.tsx";
import { Wiring } from "./Wiring.tsx";
import { store } from "./store.ts";

export function App() {
  const page = useSyncExternalStore(store.subscribe, store.snapshot);
  const [selected, select] = useState("");
  const [tab, open] = useState<Tab>("Values");
  const openFromWiring = useCallback((view: Tab) => {
    open(view);
    document.getElementById(VIEW)?.focus();
  }, []);
  const { system } = page;
  const past = system?.time.past ?? false;
  const full = page.full && !past;
  useEffect(() => {
    if (!full) return undefined;
    const onKeyDown = (e: KeyboardEvent) => {
      // Text fields have their own undo.
      if (!(e.ctrlKey || e.metaKey) || e.altKey || (e.target as HTMLElement).matches("input, textarea, select")) return;
      const key = e.key.toLowerCase();
      const undo = key === "z" && !e.shiftKey;
      if (!undo && key !== "y" && key !== "z") return;
      e.preventDefault();
      void store.order(undo ? { case: "undone", value: true } : { case: "redone", value: true });
    };
    window.addEventListener("keydown", onKeyDown);
    return () => window.removeEventListener("keydown", onKeyDown);
  }, [full]);
  const component = system?.components.find((each) => each.instance === selected);
  return (
    <div className="app" onKeyDown={openPicker}>
      <header>
        <h1 title={system?.name}>{system?.name || "rtgen"}</h1>
        {system && <TimeBar system={system} full={full} />}
        <span className={`link ${page.link}`} role="status">
          {page.link === "live" && past ? (system?.time.kind === "CLOCK_RECORDING" ? "recording" : "looking back") : page.link}
          {page.link === "live" && !page.full && ", read only"}
        </span>
      </header>
      <p className="announced" role="log" aria-label="Changes of the wiring">
        {page.announced}
      </p>
      {system?.time.reason && (
        <p className="notice ended" role="alert">
          <span>{`The run has ended at ${system.time.now.toFixed(3)} s: ${system.time.reason}`}</span>
          {system.time.kind === "CLOCK_SIMULATED" && (
            <button type="button" disabled={!full} onClick={() => store.order({ case: "time", value: 0 })}>
              Go to 0
            </button>
          )}
        </p>
      )}
      {page.notice && (
        <p className="notice" role="alert">
          <span>{page.notice}</span>
          <button type="button" aria-label="Dismiss notice" onClick={() => store.notify("")}>
            ×
          </button>
        </p>
      )}
      {system ? (
        <main>
          <Palette system={system} full={full} selected={selected} select={select} />
          <Wiring
            file={system.edits.file}
            components={system.components}
            connections={system.connections}
            buses={system.buses}
            full={full}
            statistics={page.statistics}
            selected={selected}
            select={select}
            open={openFromWiring}
          />
          <Panel
            system={system}
            component={component}
            statistics={page.statistics.get(selected)}
            lines={page.lines}
            full={full}
            select={select}
            tab={tab}
            open={open}
          />
        </main>
      ) : (
        <p className="empty">Waiting for the system.</p>
      )}
    </div>
  );
}

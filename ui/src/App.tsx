/** The page: what is running, the palette, the wiring, the panel of what is selected, and the time. */

import * as Tooltip from "@radix-ui/react-tooltip";
import { X } from "lucide-react";
import { useCallback, useMemo, useState, useSyncExternalStore } from "react";
import { Commands } from "./Commands.tsx";
import { Head } from "./Head.tsx";
import { Button, IconButton } from "./kit/Button.tsx";
import { Split } from "./kit/Split.tsx";
import type { Pane } from "./kit/Split.tsx";
import { Keys, useKeys } from "./keys.tsx";
import { Palette } from "./Palette.tsx";
import type { Tab } from "./Panel.tsx";
import { Panel, focusView } from "./Panel.tsx";
import { openPicker } from "./picker.ts";
import { Rename } from "./Rename.tsx";
import { TimeBar } from "./TimeBar.tsx";
import { Wiring } from "./Wiring.tsx";
import type { PlannedEvent } from "./protocol/Ui.ts";
import { store } from "./store.ts";

const NOTHING: readonly PlannedEvent[] = [];
/** Whether the palette is open; kept when the page is reloaded. */
const PALETTE = "rtgen palette";

export function App() {
  const page = useSyncExternalStore(store.subscribe, store.snapshot);
  const [selected, select] = useState("");
  const [tab, open] = useState<Tab>("Values");
  const [adding, setAdding] = useState(() => sessionStorage.getItem(PALETTE) === "open");
  const [asked, ask] = useState<"commands" | "keys">();
  const [wire, inspect] = useState("");
  const [renaming, rename] = useState<string>();
  const openFromWiring = useCallback((view: Tab) => {
    open(view);
    focusView();
  }, []);
  const add = useCallback((shown: boolean) => {
    setAdding(shown);
    sessionStorage.setItem(PALETTE, shown ? "open" : "closed");
  }, []);
  const { system } = page;
  const past = system?.time.past ?? false;
  const full = page.full && !past;
  const component = system?.components.find((each) => each.instance === selected);
  const bindings = useMemo(
    () => ({
      keys: () => ask("keys"),
      commands: () => ask("commands"),
      rename: () => selected && rename(selected),
    }),
    [selected],
  );
  useKeys(system, full, bindings);

  const { plan = NOTHING } = system ?? {};
  const passed = plan.filter((each) => each.time <= (system?.time.now ?? 0)).length;
  const planned = useMemo(() => plan.slice(passed).filter((each) => each.kind === "connect"), [plan, passed]);
  const addFromWiring = useCallback(() => add(true), [add]);

  const panes: Pane[] = [];
  if (system) {
    if (adding || system.naming.length > 0)
      panes.push({
        id: "palette",
        size: "260px",
        least: "180px",
        content: <Palette system={system} full={full} selected={selected} select={select} adding={adding} close={() => add(false)} />,
      });
    panes.push({
      id: "wiring",
      least: "260px",
      content: (
        <Wiring
          file={system.edits.file}
          components={system.components}
          connections={system.connections}
          buses={system.buses}
          planned={planned}
          flows={page.flows}
          full={full}
          statistics={page.statistics}
          selected={selected}
          select={select}
          open={openFromWiring}
          rename={rename}
          inspect={inspect}
          add={addFromWiring}
        />
      ),
    });
    panes.push({
      id: "panel",
      size: "400px",
      least: "300px",
      content: (
        <Panel
          system={system}
          component={component}
          statistics={page.statistics.get(selected)}
          lines={page.lines}
          full={full}
          select={select}
          tab={tab}
          open={open}
          rename={rename}
          connection={system.connections.find((each) => each.name === wire)}
          inspect={inspect}
        />
      ),
    });
  }
  return (
    <Tooltip.Provider delayDuration={400}>
      <div className="app" onKeyDown={openPicker}>
        <Head page={page} full={full} adding={adding} add={add} ask={ask} />
        <p className="announced" role="log" aria-label="Changes of the wiring">
          {page.announced}
        </p>
        {page.notice && (
          <div className="toasts">
            <div className="notice" role="alert">
              <span>{page.notice}</span>
              <IconButton icon={X} look="plain" label="Dismiss notice" onClick={() => store.notify("")} />
            </div>
          </div>
        )}
        {system ? (
          <main>
            <Split key={panes.map((each) => each.id).join()} id="rtgen panes" panes={panes} className="panes" />
          </main>
        ) : (
          <main className="empty">
            <strong>Waiting for the system.</strong>
          </main>
        )}
        {system?.time.reason && (
          <p className="notice ended" role="alert">
            <span>{`The run has ended at ${system.time.now.toFixed(3)} s: ${system.time.reason}`}</span>
            {system.time.kind === "CLOCK_SIMULATED" && (
              <Button disabled={!full} onClick={() => store.order({ case: "time", value: 0 })}>
                Go to 0
              </Button>
            )}
          </p>
        )}
        {system && <TimeBar system={system} full={full} lines={page.lines} live={page.link === "live"} />}
      </div>
      {asked === "keys" && <Keys close={() => ask(undefined)} />}
      {asked === "commands" && system && (
        <Commands
          system={system}
          full={full}
          component={component}
          close={() => ask(undefined)}
          select={select}
          open={openFromWiring}
          add={() => add(true)}
          help={() => ask("keys")}
          rename={rename}
        />
      )}
      {renaming && system && <Rename key={renaming} system={system} instance={renaming} close={() => rename(undefined)} select={select} />}
    </Tooltip.Provider>
  );
}


/** The page: what is running, its views, and the time. */

import * as Tooltip from "@radix-ui/react-tooltip";
import { X } from "lucide-react";
import type { ReactNode } from "react";
import { useCallback, useEffect, useMemo, useRef, useState, useSyncExternalStore } from "react";
import type { WorkspaceImperativeHandle } from "react-resizable-panels";
import { state, stated } from "./address.ts";
import { Bar } from "./Bar.tsx";
import { Board } from "./Board.tsx";
import { BusView } from "./Bus.tsx";
import { Compare, useNext } from "./Compare.tsx";
import { Commands } from "./Commands.tsx";
import { Console } from "./Console.tsx";
import { Drive } from "./Drive.tsx";
import { Head, Tools } from "./Head.tsx";
import { exists, named } from "./Inspector.tsx";
import type { Subject } from "./Inspector.tsx";
import { Button, IconButton } from "./kit/Button.tsx";
import { Tabs } from "./kit/Tabs.tsx";
import { Keys, useKeys } from "./keys.tsx";
import { MapView } from "./MapView.tsx";
import { Palette } from "./Palette.tsx";
import { Panel } from "./Panel.tsx";
import { Plots } from "./Plots.tsx";
import { openPicker } from "./picker.ts";
import { Rename } from "./Rename.tsx";
import { PHONE, ROOM, useWidth } from "./width.ts";
import { TimeBar } from "./TimeBar.tsx";
import { Timeline } from "./Timeline.tsx";
import { COMPONENT, PRESETS, emptiness, isOfComponent, isSeen, isView, read, titleOf } from "./views.ts";
import type { View } from "./views.ts";
import { Wiring } from "./Wiring.tsx";
import { Arranger, Workspace } from "./Workspace.tsx";
import type { PlannedEvent } from "./protocol/Ui.ts";
import { stateClass, stateOf, store } from "./store.ts";
import { t } from "./texts.ts";

const NOTHING: readonly PlannedEvent[] = [];
/** The panes of the last page. */
const PANES = "rtgen panes";

const remembered = (): string => stated("panes") || (localStorage.getItem(PANES) ?? "");
/** Moves the focus to a view that was opened. */
const focusView = (view: View): void => void requestAnimationFrame(() => document.querySelector<HTMLElement>(`[data-view=${view}]`)?.focus());

export function App() {
  const page = useSyncExternalStore(store.subscribe, store.snapshot);
  const [isWide, isPhone] = [useWidth(ROOM), useWidth(PHONE)];
  const [selected, choose] = useState(() => stated("component"));
  const [panes, setPanes] = useState(remembered);
  const [shown, setShown] = useState<View>(() => (isView(stated("view")) ? (stated("view") as View) : "Wiring"));
  const [asked, ask] = useState<"commands" | "keys">();
  const [wanted, setSubject] = useState<Subject>();
  const [port, choosePort] = useState("");
  const [renaming, rename] = useState<string>();
  const handle = useRef<WorkspaceImperativeHandle<View>>(null);
  const arranger = useMemo(() => new Arranger(handle), []);
  const latest = useRef(selected);
  const select = useCallback((instance: string) => {
    choose(instance);
    if (instance !== latest.current) choosePort("");
    latest.current = instance;
    state("component", instance);
  }, []);
  const open = useCallback(
    (view: View) => {
      arranger.open(view);
      setShown(view);
      state("view", view === "Wiring" ? "" : view);
      focusView(view);
    },
    [arranger],
  );
  const plot = useCallback(() => open("Plots"), [open]);
  const inspect = useCallback(
    (subject: Subject | undefined) => {
      setSubject(subject);
      if (subject && !arranger.showsComponent) arranger.open("Values");
    },
    [arranger],
  );
  const changed = useCallback((text: string) => {
    setPanes(text);
    state("panes", text);
    localStorage.setItem(PANES, text);
  }, []);
  const add = useCallback(
    (adding: boolean) => {
      if (adding) open("Palette");
      else arranger.close("Palette");
      if (!adding) setShown((now) => (now === "Palette" ? "Wiring" : now));
    },
    [arranger, open],
  );
  const { system } = page;
  const past = system?.time.past ?? false;
  const full = page.full && !past;
  const component = system?.components.find((each) => each.instance === selected);
  const next = useNext(system, selected, full, plot);
  const subject = system && wanted && exists(system, wanted) ? wanted : undefined;
  const bindings = useMemo(
    () => ({
      keys: () => ask("keys"),
      commands: () => ask("commands"),
      rename: () => selected && rename(selected),
    }),
    [selected],
  );
  useKeys(system, full, bindings);

  useEffect(() => {
    const follow = () => {
      const tree = read(stated("panes"));
      if (tree) arranger.arrange(tree);
      choose(stated("component"));
      if (isView(stated("view"))) setShown(stated("view") as View);
    };
    window.addEventListener("hashchange", follow);
    return () => window.removeEventListener("hashchange", follow);
  }, [arranger]);

  const calls = store.traffic.calls.length;
  const emptinessOf = (view: View): string => (system ? emptiness(view, system, calls) : "");
  const [noBus, noBoard, names] = [emptinessOf("Buses"), emptinessOf("Boards"), system !== undefined && system.naming.length > 0];
  const isReady = system !== undefined && isWide;
  const trim = useCallback(() => {
    for (const [view, empty] of [["Buses", noBus], ["Boards", noBoard]] as const)
      if (!empty) arranger.add(view);
      else if (!arranger.isAlone(view)) arranger.close(view);
  }, [arranger, noBus, noBoard]);
  const arrange = useCallback(
    (name: string) => {
      arranger.arrange(PRESETS[name]!());
      trim();
    },
    [arranger, trim],
  );
  // Views that have got something to show come, those that have lost it go.
  useEffect(() => {
    if (isReady) trim();
  }, [isReady, trim]);
  useEffect(() => {
    if (isReady && names) arranger.add("Palette");
  }, [arranger, isReady, names]);

  const { plan = NOTHING } = system ?? {};
  const passed = plan.filter((each) => each.time <= (system?.time.now ?? 0)).length;
  const planned = useMemo(() => plan.slice(passed).filter((each) => each.kind === "connect"), [plan, passed]);
  const addFromWiring = useCallback(() => add(true), [add]);

  const content = (view: View): ReactNode => {
    if (!system) return null;
    if (view === "Wiring")
      return (
        <Wiring
          file={system.edits.file}
          components={system.components}
          connections={system.connections}
          buses={system.buses}
          planned={planned}
          lost={page.lost}
          full={full}
          selected={selected}
          select={select}
          open={open}
          rename={rename}
          inspect={inspect}
          add={addFromWiring}
        />
      );
    if (view === "Palette") return <Palette system={system} full={full} selected={selected} select={select} close={() => add(false)} />;
    if (isOfComponent(view))
      return (
        <Panel
          view={view}
          system={system}
          component={component}
          statistics={page.statistics.get(selected)}
          full={full}
          select={select}
          rename={rename}
          subject={subject}
          inspect={inspect}
          open={open}
          port={port}
          choosePort={choosePort}
        />
      );
    return (
      <div className="panel" data-view={view} tabIndex={-1}>
        {view === "Plots" ? (
          <Plots system={system} />
        ) : view === "Map" ? (
          <MapView system={system} plot={plot} />
        ) : view === "Drive" ? (
          <Drive system={system} full={full} map={!isWide || !isSeen(panes, "Map")} plot={plot} />
        ) : view === "Buses" ? (
          <BusView system={system} full={full} />
        ) : view === "Boards" ? (
          <Board />
        ) : view === "Console" ? (
          <Console said={page.said} />
        ) : (
          <Timeline lines={page.lines} system={system} />
        )}
      </div>
    );
  };
  const head = { page, full, adding: isWide ? panes.includes("Palette") : shown === "Palette", add, arrange, emptiness: emptinessOf };
  return (
    <Tooltip.Provider delayDuration={400}>
      <div className={`app ${isWide ? "wide" : "narrow"}`} onKeyDown={openPicker}>
        <Head {...head} isPhone={isPhone} isWide={isWide} ask={ask} />
        <p className="announced" role="log" aria-label={t("Changes of the wiring")}>
          {page.announced}
        </p>
        {page.notice && (
          <div className="toasts">
            <div className="notice" role="alert">
              <span>{page.notice}</span>
              <IconButton icon={X} look="plain" label={t("Dismiss notice")} onClick={() => store.notify("")} />
            </div>
          </div>
        )}
        {!system ? (
          <main className="empty">
            <strong>{t("Waiting for the system.")}</strong>
          </main>
        ) : isWide ? (
          <main>
            <Workspace handle={handle} first={read(remembered()) ?? PRESETS["Wire"]!()} changed={changed} content={content} emptiness={emptinessOf} />
          </main>
        ) : (
          <main>
            {/* The wiring keeps its layout while another view is shown. */}
            <div className="screen" hidden={shown !== "Wiring"}>
              {content("Wiring")}
            </div>
            {isOfComponent(shown) ? (
              <div className="screen">
                <Tabs label={t("Views of the component")} names={COMPONENT} title={titleOf} shown={shown as (typeof COMPONENT)[number]} show={open}>
                  {content(shown)}
                </Tabs>
              </div>
            ) : (
              shown !== "Wiring" && <div className="screen">{content(shown)}</div>
            )}
            {shown === "Wiring" && (component || subject) && (
              <div className="peek card">
                {subject ? (
                  <bdi>{named(system, subject)}</bdi>
                ) : (
                  component && (
                    <span>
                      <bdi>{component.instance}</bdi> <span className={`state ${stateClass(component)}`}>{stateOf(component)}</span>
                    </span>
                  )
                )}
                <Button look="primary" onClick={() => open("Values")}>
                  {t("Details")}
                </Button>
              </div>
            )}
          </main>
        )}
        {system?.time.reason && (
          <p className="notice ended" role="alert">
            <span>{t("The run has ended at {now} s: {reason}", { now: system.time.now.toFixed(3), reason: system.time.reason })}</span>
            {system.time.kind === "CLOCK_SIMULATED" && (
              <Button disabled={!full} onClick={() => store.order({ case: "time", value: 0 })}>
                {t("Go to 0")}
              </Button>
            )}
          </p>
        )}
        {next && <Compare {...next} />}
        {system && <TimeBar system={system} full={full} lines={page.lines} live={page.link === "live"} playing={page.playing} brief={isPhone && shown !== "Timeline"} />}
        {system && !isWide && (
          <Bar shown={shown} show={open} emptiness={emptinessOf}>
            {isPhone && <Tools {...head} />}
          </Bar>
        )}
      </div>
      {asked === "keys" && <Keys close={() => ask(undefined)} />}
      {asked === "commands" && system && (
        <Commands
          system={system}
          full={full}
          component={component}
          next={next}
          close={() => ask(undefined)}
          select={select}
          open={open}
          arrange={isWide ? arrange : undefined}
          emptiness={emptinessOf}
          help={() => ask("keys")}
          rename={rename}
        />
      )}
      {renaming && system && <Rename key={renaming} system={system} instance={renaming} close={() => rename(undefined)} select={select} />}
    </Tooltip.Provider>
  );
}

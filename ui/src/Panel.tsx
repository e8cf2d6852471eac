/** The selected component: its values, configuration and history. */

import { Fragment } from "react";
import { Board } from "./Board.tsx";
import { BusView } from "./Bus.tsx";
import { Configuration } from "./Configuration.tsx";
import { Connections } from "./Connections.tsx";
import { Drive } from "./Drive.tsx";
import { MapView } from "./MapView.tsx";
import { Plots } from "./Plots.tsx";
import type { Component, Connection, SystemState } from "./protocol/Ui.ts";
import { Services } from "./Services.tsx";
import { Pencil } from "lucide-react";
import { IconButton } from "./kit/Button.tsx";
import { Tabs } from "./kit/Tabs.tsx";
import { Inspector } from "./Inspector.tsx";
import { Overview } from "./Overview.tsx";
import type { Line, Statistics } from "./store.ts";
import { Values } from "./Values.tsx";
import { stateClass, stateOf, store } from "./store.ts";

export const TABS = ["Values", "Connections", "Plots", "Map", "Drive", "Configuration", "Services", "Buses", "Boards", "Timeline"] as const;

/** Moves the focus to the open view. */
export const focusView = (): void => document.querySelector<HTMLElement>(".panel [role=tabpanel]")?.focus();

export type Tab = (typeof TABS)[number];

function Timeline({ lines }: { lines: readonly Line[] }) {
  // Changes of the compared run arrive slightly later than they happened.
  const sorted = [...lines].sort((a, b) => a.time - b.time).reverse();
  return (
    <ol className="timeline">
      {sorted.map((line, i) => (
        <li key={lines.length - i} className={`line-${line.kind}`}>
          <time>{line.time.toFixed(3)} s</time> <bdi>{line.instance}</bdi> <bdi>{line.text}</bdi>
        </li>
      ))}
    </ol>
  );
}

export function Panel(props: {
  system: SystemState;
  component: Component | undefined;
  statistics: Statistics | undefined;
  lines: readonly Line[];
  full: boolean;
  select: (instance: string) => void;
  tab: Tab;
  open: (tab: Tab) => void;
  rename: (instance: string) => void;
  connection: Connection | undefined;
  inspect: (connection: string) => void;
}) {
  const { system, component, statistics, lines, full, select, tab, open, rename, connection, inspect } = props;
  return (
    <aside className="panel" aria-label="Component">
      {connection && <Inspector system={system} connection={connection} full={full} close={() => inspect("")} select={select} />}
      <label>
        Component
        <select value={component?.instance ?? ""} onChange={(e) => select(e.target.value)}>
          <option value="">Overview</option>
          {system.components.map((each) => (
            <option key={each.instance} value={each.instance}>{each.instance}</option>
          ))}
        </select>
      </label>
      {component && (
        <>
          <p>
            <span className={`state ${stateClass(component)}`}>{stateOf(component)}</span> <bdi>{component.type}</bdi>
            {component.contexts.map((each) => (
              <Fragment key={each.handle}>
                , {each.rate} Hz <bdi>{each.kind.toLowerCase()}</bdi>
                {!each.running && ", stopped"}
              </Fragment>
            ))}
            {statistics && `, ${statistics.ticks} ticks, ${statistics.overruns} overruns, ${statistics.lost} lost`}
          </p>
          {system.beside && store.page.beside.has(component.instance) && <p>beside: {store.page.beside.get(component.instance)}</p>}
          {component.silent && <p className="reason">{component.silent}</p>}
          {(component.reason || statistics?.impaired) && <p className={stateOf(component) === "FINISHED" ? "" : "reason"}>{component.reason || statistics?.impaired}</p>}
          <div className="buttons">
            {!component.place && (
              <IconButton icon={Pencil} label={`Rename ${component.instance}`} keys="F2" disabled={!full} onClick={() => rename(component.instance)} />
            )}
            {(
              [
                ["Activate", "activated"],
                ["Deactivate", "deactivated"],
                ["Reset", "restored"],
              ] as const
            ).map(([name, kind]) => (
              <button key={kind} type="button" disabled={!full} aria-label={`${name} ${component.instance}`} onClick={() => store.order({ case: kind, value: [component.instance] })}>
                {name}
              </button>
            ))}
          </div>
        </>
      )}
      <Tabs label="Views" names={TABS} shown={tab} show={open}>
        {tab === "Timeline" ? (
          <Timeline lines={lines} />
        ) : tab === "Plots" ? (
          <Plots system={system} />
        ) : tab === "Map" ? (
          <MapView system={system} />
        ) : tab === "Drive" ? (
          <Drive system={system} full={full} />
        ) : tab === "Buses" ? (
          <BusView system={system} full={full} />
        ) : tab === "Boards" ? (
          <Board />
        ) : !component ? (
          <Overview system={system} select={select} inspect={inspect} />
        ) : tab === "Values" ? (
          <Values key={component.instance} system={system} component={component} />
        ) : tab === "Connections" ? (
          <Connections key={component.instance} system={system} component={component} full={full} />
        ) : tab === "Services" ? (
          <Services key={component.instance} component={component} full={full} />
        ) : (
          <Configuration key={component.instance} component={component} full={full} />
        )}
      </Tabs>
    </aside>
  );
}

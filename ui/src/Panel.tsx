/** The selected component: its values, configuration and history. */

import { Fragment, useEffect, useMemo } from "react";
import { Board } from "./Board.tsx";
import { BusView } from "./Bus.tsx";
import { Configuration } from "./Configuration.tsx";
import { Connections } from "./Connections.tsx";
import { Drive } from "./Drive.tsx";
import { MapView } from "./MapView.tsx";
import { Plot, Span, curvesOf, inPlots, ofUnits, overlaid } from "./Plot.tsx";
import type { Channel, Component, Connection, SystemState } from "./protocol/Ui.ts";
import { Services } from "./Services.tsx";
import { Pencil } from "lucide-react";
import { IconButton } from "./kit/Button.tsx";
import { Tabs } from "./kit/Tabs.tsx";
import { Inspector } from "./Inspector.tsx";
import { Overview } from "./Overview.tsx";
import type { Line, Statistics } from "./store.ts";
import { leaves, stateClass, stateOf, store } from "./store.ts";

export const TABS = ["Values", "Connections", "Map", "Drive", "Configuration", "Services", "Buses", "Boards", "Timeline"] as const;

/** Moves the focus to the open view. */
export const focusView = (): void => document.querySelector<HTMLElement>(".panel [role=tabpanel]")?.focus();

export type Tab = (typeof TABS)[number];

interface Selection {
  system: SystemState;
  component: Component;
  full: boolean;
}

/** The samples of the component's OutPorts and of the OutPorts connected to its InPorts. */
function Values({ system, component }: Selection) {
  const shown = useMemo(() => {
    const near = new Set(
      system.connections
        .filter((each) => each.target.instance === component.instance)
        .map((each) => `${each.source.instance}.${each.source.port}`),
    );
    return system.channels.filter(
      ({ port }) => port.instance === component.instance || near.has(`${port.instance}.${port.port}`),
    );
  }, [system.connections, system.channels, component.instance]);
  const partner = (channel: Channel) =>
    shown.find((each) => each.beside && each.port.instance === channel.port.instance && each.port.port === channel.port.port);
  const wanted = shown.map((each) => each.id).join();
  useEffect(() => store.watch(wanted ? wanted.split(",").map(Number) : []), [wanted]);
  const unknown = component.ports.filter((each) => component.place && each.kind === "PORT_OUT" && each.type_number < 0);
  if (!shown.length && !unknown.length) return <p>No port of this component has values.</p>;
  const sections = shown.filter((each) => !each.beside).map((channel) => {
    const name = `${channel.port.instance}.${channel.port.port}`;
    const owner = system.components.find((each) => each.instance === channel.port.instance);
    const port = owner?.ports.find((each) => each.name === channel.port.port && each.kind === "PORT_OUT");
    const units = new Map(port?.units.map((each) => [each.name, each.text]));
    const unitOf = (path: string) => units.get(path.replace(/\[[^\]]*\]/g, "")) ?? "";
    const track = store.tracks.get(channel.id);
    const other = partner(channel);
    const beside = other && store.tracks.get(other.id);
    const values = new Map(beside && leaves(beside.value));
    const curves = () => overlaid(curvesOf(store.tracks.get(channel.id), unitOf), other && curvesOf(store.tracks.get(other.id), unitOf));
    const rows = track ?? beside;
    return (
      <section key={channel.id} aria-label={name}>
        <h2>{name}</h2>
        {track?.refused && <p className="reason">The last sample could not be read: {track.refused}</p>}
        {rows?.times.length ? (
          <>
            {inPlots(curves()?.units ?? []).map((shown, i) => (
              <Plot key={i} source={`${channel.id} ${shown}`} read={() => ofUnits(curves(), shown)} label={i ? `Values over time in ${shown.filter(Boolean).join(", ")}` : "Values over time"} />
            ))}
            {rows.thinned && <p className="thinned">Of older samples some are left out of the plot.</p>}
            <table>
              {other && (
                <thead>
                  <tr>
                    <th scope="col">value</th>
                    <th scope="col">this run</th>
                    <th scope="col">beside</th>
                    <th scope="col">unit</th>
                  </tr>
                </thead>
              )}
              <tbody>
                {leaves(rows.value).map(([path, value]) => (
                  <tr key={path}>
                    <th scope="row">{path}</th>
                    <td className={cell(value)}>{track ? written(value) : ""}</td>
                    {other && <td className={cell(value)}>{values.has(path) ? written(values.get(path)) : ""}</td>}
                    <td className="text">{unitOf(path)}</td>
                  </tr>
                ))}
              </tbody>
            </table>
          </>
        ) : (
          !track?.refused && <p>No sample yet.</p>
        )}
      </section>
    );
  });
  return (
    <>
      <Span />
      {sections}
      {unknown.map((each) => (
        <p key={each.name}>
          <bdi>{each.name}</bdi>: the project does not define <bdi>{each.type}</bdi>, so its samples cannot be read.
        </p>
      ))}
    </>
  );
}

/** Long texts are wrapped, numbers are not. */
const cell = (value: unknown) => (typeof value === "number" ? undefined : "text");
const written = (value: unknown) => (typeof value === "number" ? String(Number(value.toPrecision(7))) : String(value));

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
          <Values key={component.instance} system={system} component={component} full={full} />
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

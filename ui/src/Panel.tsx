/** The selected component: its values, configuration and history. */

import { useEffect, useMemo, useState } from "react";
import { Board } from "./Board.tsx";
import { BusView } from "./Bus.tsx";
import { Connections } from "./Connections.tsx";
import { Drive } from "./Drive.tsx";
import { MapView } from "./MapView.tsx";
import { Plot, curvesOf, overlaid } from "./Plot.tsx";
import type { Channel, Component, Parameter, SystemState } from "./protocol/Ui.ts";
import { Services } from "./Services.tsx";
import type { Line, Statistics } from "./store.ts";
import { leaves, stateName, store } from "./store.ts";

export const TABS = ["Values", "Connections", "Map", "Drive", "Configuration", "Services", "Buses", "Boards", "Timeline"] as const;

export type Tab = (typeof TABS)[number];

interface Selection {
  system: SystemState;
  component: Component;
  full: boolean;
}

/** The samples of the component's OutPorts and of those that its InPorts are connected to. */
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
  useEffect(() => {
    store.watch(wanted ? wanted.split(",").map(Number) : []);
    return () => store.watch([]);
  }, [wanted]);
  if (!shown.length) return <p>No port of this component has values.</p>;
  return shown.filter((each) => !each.beside).map((channel) => {
    const name = `${channel.port.instance}.${channel.port.port}`;
    const owner = system.components.find((each) => each.instance === channel.port.instance);
    const unit = owner?.ports.find((each) => each.name === channel.port.port)?.unit ?? "";
    const track = store.tracks.get(channel.id);
    const other = partner(channel);
    const beside = other && store.tracks.get(other.id);
    const values = new Map(beside && leaves(beside.value));
    const curves = () => overlaid(curvesOf(store.tracks.get(channel.id)), other && curvesOf(store.tracks.get(other.id)));
    const rows = track ?? beside;
    return (
      <section key={channel.id} aria-label={name}>
        <h3>{name}</h3>
        {rows ? (
          <>
            {rows.numbers.size > 0 && <Plot source={String(channel.id)} read={curves} unit={unit} label="Values over time" />}
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
                    <td>{track ? written(value) : ""}</td>
                    {other && <td>{values.has(path) ? written(values.get(path)) : ""}</td>}
                    <td>{/^tm\b/.test(path) ? "" : unit}</td>
                  </tr>
                ))}
              </tbody>
            </table>
          </>
        ) : (
          <p>No sample yet.</p>
        )}
      </section>
    );
  });
}

const written = (value: unknown) => (typeof value === "number" ? String(Number(value.toPrecision(7))) : String(value));

/** The limits of a constraint `a<=x<=b`, and the choices of `(a,b)`. */
export function limits(constraint: string): { min?: number; max?: number; choices?: string[] } {
  const choices = /^\((.*)\)$/.exec(constraint.trim());
  if (choices) return { choices: choices[1]!.split(",").map((each) => each.trim()) };
  const range = /^(?:([-+.\deE]+)\s*<=?\s*)?x(?:\s*<=?\s*([-+.\deE]+))?$/.exec(constraint.trim());
  const least = /^x\s*>=?\s*([-+.\deE]+)$/.exec(constraint.trim());
  const [min, max] = [range?.[1] ?? least?.[1], range?.[2]];
  return { ...(min && { min: Number(min) }), ...(max && { max: Number(max) }) };
}

function Field(props: { parameter: Parameter; text: string; full: boolean; label: string; set: (text: string) => Promise<unknown> }) {
  const { parameter, text, full, label, set } = props;
  const [edited, edit] = useState<string>();
  const { min, max, choices } = limits(parameter.constraint);
  const commit = () => {
    if (edited !== undefined && edited !== text) void set(edited).then(() => edit(undefined));
    else edit(undefined);
  };
  const common = { "aria-label": label, title: parameter.doc, disabled: !full };
  if (choices && parameter.widget !== "checkbox" && parameter.widget !== "ordered_list")
    return (
      <select {...common} value={text} onChange={(e) => void set(e.target.value)}>
        {[...new Set([text, ...choices])].map((each) => (
          <option key={each}>{each}</option>
        ))}
      </select>
    );
  const range = parameter.widget.startsWith("slider") && min !== undefined && max !== undefined;
  return (
    <>
      <input
        {...common}
        type={range ? "range" : parameter.widget.startsWith("spin") ? "number" : "text"}
        min={min}
        max={max}
        step={range ? (max - min) / 100 : "any"}
        value={edited ?? text}
        onChange={(e) => edit(e.target.value)}
        onBlur={commit}
        onPointerUp={range ? commit : undefined}
        onKeyDown={(e) => {
          if (e.key === "Enter") commit();
          if (e.key === "Escape") edit(undefined);
        }}
      />
      {range && <output>{edited ?? text}</output>}
    </>
  );
}

function Configuration({ component, full }: Selection) {
  const [shown, show] = useState("");
  const name = component.configuration_sets.some((each) => each.name === shown) ? shown : component.active_set;
  const set = component.configuration_sets.find((each) => each.name === name);
  if (!component.parameters.length) return <p>This component has no parameters.</p>;
  return (
    <>
      <div className="sets">
        <label>
          Set
          <select value={name} onChange={(e) => show(e.target.value)}>
            {component.configuration_sets.map((each) => (
              <option key={each.name} value={each.name}>
                {each.name}
                {each.name === component.active_set ? " (active)" : ""}
              </option>
            ))}
          </select>
        </label>
        <button
          type="button"
          disabled={!full || name === component.active_set}
          onClick={() => store.order({ case: "chosen", value: { instance: component.instance, set: name } })}
        >
          Use this set
        </button>
      </div>
      <table className="parameters">
        <tbody>
          {component.parameters.map((parameter) => (
            <tr key={`${name} ${parameter.name}`}>
              <th scope="row" title={parameter.doc}>
                {parameter.name}
              </th>
              <td>
                <Field
                  parameter={parameter}
                  full={full}
                  label={`${component.instance}.${parameter.name}`}
                  text={set?.values.find((each) => each.name === parameter.name)?.text ?? parameter.default_value}
                  set={(text) =>
                    store.order({
                      case: "setting",
                      value: { instance: component.instance, set: name, parameter: parameter.name, text },
                    })
                  }
                />
              </td>
              <td>
                {parameter.unit} <small>{parameter.constraint}</small>
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

function Timeline({ lines }: { lines: readonly Line[] }) {
  return (
    <ol className="timeline">
      {[...lines].reverse().map((line, i) => (
        <li key={lines.length - i}>
          <time>{line.time.toFixed(3)} s</time> {line.instance} {line.text}
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
}) {
  const { system, component, statistics, lines, full, select, tab, open } = props;
  return (
    <aside className="panel" aria-label="Component">
      <label>
        Component
        <select value={component?.instance ?? ""} onChange={(e) => select(e.target.value)}>
          <option value="">none</option>
          {system.components.map((each) => (
            <option key={each.instance}>{each.instance}</option>
          ))}
        </select>
      </label>
      {component && (
        <>
          <p>
            <span className={`state ${component.current}`}>{stateName(component.current)}</span> {component.type}
            {component.contexts.map((each) => `, ${each.rate} Hz`)}
            {statistics && `, ${statistics.ticks} ticks, ${statistics.overruns} overruns, ${statistics.lost} lost`}
          </p>
          {system.beside && store.page.beside.has(component.instance) && <p>beside: {store.page.beside.get(component.instance)}</p>}
          {component.silent && <p className="reason">{component.silent}</p>}
          {(component.reason || statistics?.impaired) && <p className="reason">{component.reason || statistics?.impaired}</p>}
          <div className="buttons">
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
      <div role="tablist" aria-label="Views" className="tabs">
        {TABS.map((each) => (
          <button key={each} type="button" role="tab" aria-selected={tab === each} onClick={() => open(each)}>
            {each}
          </button>
        ))}
      </div>
      <div role="tabpanel" aria-label={tab}>
        {tab === "Timeline" ? (
          <Timeline lines={lines} />
        ) : tab === "Map" ? (
          <MapView system={system} />
        ) : tab === "Drive" ? (
          <Drive system={system} full={full} />
        ) : tab === "Buses" ? (
          <BusView buses={system.buses} full={full} />
        ) : tab === "Boards" ? (
          <Board />
        ) : !component ? (
          <p>Select a component.</p>
        ) : tab === "Values" ? (
          <Values key={component.instance} system={system} component={component} full={full} />
        ) : tab === "Connections" ? (
          <Connections key={component.instance} system={system} component={component} full={full} />
        ) : tab === "Services" ? (
          <Services key={component.instance} component={component} full={full} />
        ) : (
          <Configuration key={component.instance} system={system} component={component} full={full} />
        )}
      </div>
    </aside>
  );
}

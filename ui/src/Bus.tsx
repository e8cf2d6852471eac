/** CAN buses: load, nodes, frames in words, signals over time, emergencies. */

import { useState } from "react";
import { Menu } from "./Menu.tsx";
import type { Place } from "./Menu.tsx";
import { Objects } from "./Objects.tsx";
import type { Curve } from "./curves.ts";
import { Plot, Span } from "./Plot.tsx";
import { Send } from "./Send.tsx";
import type { Line } from "./lines.ts";
import { linesOf } from "./lines.ts";
import type { Bus, Frame, SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { hexadecimal } from "./traffic.ts";

const SHOWN = 100;
const COMMANDS = ["start", "stop", "pre-operational", "reset-node", "reset-communication"];

const identifier = (frame: Frame): string => frame.can_id.toString(16).toUpperCase().padStart(frame.extended ? 8 : 3, "0");

/** A frame in words: names, values and units. */
export function words(frame: Frame): string {
  return frame.text || frame.fields.map((each) => `${each.name} = ${each.text}`).join(", ");
}

function Nodes({ bus, lines, full }: { bus: Bus; lines: readonly Line[]; full: boolean }) {
  const manage = (node_id: number, command: string) => store.order({ case: "managed", value: { bus: bus.name, node_id, command } });
  const [menu, open] = useState<Place & { node_id: number }>();
  const control = (node_id: number, name: string) => (
    <button
      type="button"
      aria-haspopup="menu"
      aria-label={`NMT command to ${name}`}
      disabled={!full}
      onClick={(e) => {
        const { x, bottom } = e.currentTarget.getBoundingClientRect();
        open({ label: name, node_id, x, y: bottom });
      }}
    >
      NMT …
    </button>
  );
  return (
    <>
      <table aria-label="Nodes">
        <thead>
          <tr>
            <th scope="col">id</th>
            <th scope="col">node</th>
            <th scope="col">NMT state</th>
            <th scope="col">components</th>
            <th scope="col">{control(0, "all nodes")}</th>
          </tr>
        </thead>
        <tbody>
          {(lines.find((each) => each.name === bus.name)?.nodes ?? []).map((node) => (
            <tr key={node.id}>
              <td>{node.id}</td>
              <td className="text" title={bus.nodes.find((each) => each.node_id === node.id)?.device}>{node.name}</td>
              <td className="text">{node.nmtState || "unknown"}</td>
              <td className="text">{[...node.proxies, ...node.devices].join(", ")}</td>
              <td>{control(node.id, node.name)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {menu && (
        <Menu
          place={menu}
          items={COMMANDS.map((name) => ({ name, act: () => void manage(menu.node_id, name) }))}
          close={() => open(undefined)}
        />
      )}
    </>
  );
}

function Load({ bus }: { bus: Bus }) {
  const read = (): Curve[] => {
    const loads = store.traffic.loads.get(bus.name) ?? [];
    const times = loads.map((each) => each.time);
    const curve = (key: string, colour: number, value: (load: number) => number): Curve => ({ key, name: key, unit: "%", times, values: loads.map((each) => 100 * value(each.load)), colour });
    return [curve("measured", 0, (load) => load), ...(bus.computed_load < 0 ? [] : [curve("computed", 1, () => bus.computed_load)])];
  };
  const last = store.traffic.loads.get(bus.name)?.at(-1);
  return (
    <>
      <p>
        {bus.bit_rate > 0 && `${bus.bit_rate / 1000} kbit/s, `}
        {last ? `${bus.bit_rate > 0 ? `load ${(last.load * 100).toFixed(1)} %, ` : ""}${last.frames} frames/s` : "load not measured yet"}
        {bus.computed_load >= 0 && `, computed ${(bus.computed_load * 100).toFixed(1)} %`}
      </p>
      {bus.bit_rate > 0 && <Plot id={`load ${bus.name}`} read={read} label={`Load of ${bus.name} over time`} zero />}
    </>
  );
}

function Frames({ frames, caption }: { frames: readonly Frame[]; caption: string }) {
  return (
    <div className="rows" tabIndex={0}>
      <table aria-label={caption}>
        <thead>
          <tr>
            <th scope="col">time [s]</th>
            <th scope="col">id</th>
            <th scope="col">node</th>
            <th scope="col">kind</th>
            <th scope="col">octets</th>
            <th scope="col">meaning</th>
          </tr>
        </thead>
        <tbody>
          {frames.map((frame, i) => (
            <tr key={i}>
              <td>{frame.time.toFixed(4)}</td>
              <td>{identifier(frame)}</td>
              <td>{frame.node_id < 0 ? "" : frame.node_id}</td>
              <td className="text">{frame.kind}</td>
              <td className="octets">{frame.remote ? "remote" : hexadecimal(frame.data)}</td>
              <td className="text">{words(frame)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Signals({ bus }: { bus: string }) {
  const [chosen, choose] = useState<readonly string[]>([]);
  const { signals } = store.traffic;
  const others = [...signals].filter(([key, signal]) => signal.bus === bus && !chosen.includes(key));
  const shown = chosen.flatMap((key) => {
    const signal = signals.get(key);
    return signal ? [{ key, ...signal }] : [];
  });
  const read = (): Curve[] => chosen.flatMap((key, colour) => {
    const signal = signals.get(key);
    return signal ? [{ key, name: signal.name, unit: signal.unit, times: signal.times, values: signal.numbers, colour }] : [];
  });
  return (
    <section aria-label="Signals">
      <h2>Signals</h2>
      <label>
        Plot
        <select value="" onChange={(e) => e.target.value && choose([...chosen, e.target.value].slice(-8))}>
          <option value="">signal …</option>
          {others.map(([key, { name }]) => (
            <option key={key} value={key}>
              {name}
            </option>
          ))}
        </select>
      </label>
      {shown.map(({ key, name }) => (
        <button key={key} type="button" aria-label={`Remove ${name}`} onClick={() => choose(chosen.filter((each) => each !== key))}>
          <bdi>{name}</bdi> ×
        </button>
      ))}
      {shown.length > 0 && <Plot id={`signals ${bus}`} read={read} label="Signals over time" />}
    </section>
  );
}

export function BusView({ system: { buses, components }, full }: { system: SystemState; full: boolean }) {
  const [name, open] = useState("");
  const [filter, setFilter] = useState("");
  const [held, hold] = useState<readonly Frame[]>();
  const bus = buses.find((each) => each.name === name) ?? buses[0];
  if (!bus) return <p>No frame has been seen: components of this system use no CAN bus, or time has not passed yet.</p>;
  const wanted = filter.toLowerCase().split(/\s+/).filter(Boolean);
  const matches = (frame: Frame) => {
    const text = `${identifier(frame)} ${frame.kind} node${frame.node_id} ${words(frame)}`.toLowerCase();
    return frame.bus === bus.name && wanted.every((each) => text.includes(each));
  };
  const frames = (held ?? store.traffic.frames).filter(matches).slice(-SHOWN).reverse();
  const emergencies = store.traffic.emergencies.filter((each) => each.bus === bus.name).reverse();
  return (
    <div className="bus">
      <label>
        Bus
        <select value={bus.name} onChange={(e) => open(e.target.value)}>
          {buses.map((each) => (
            <option key={each.name} value={each.name}>{each.name}</option>
          ))}
        </select>
      </label>
      <Span />
      <Load bus={bus} />
      <Nodes bus={bus} lines={linesOf(components, buses)} full={full} />
      <Send key={`send ${bus.name}`} bus={bus.name} full={full} />
      <Objects key={`objects ${bus.name}`} bus={bus} full={full} />
      <Signals key={`signals ${bus.name}`} bus={bus.name} />
      <section aria-label="Emergencies">
        <h2>Emergencies</h2>
        {emergencies.length ? <Frames frames={emergencies} caption="Emergencies" /> : <p>none</p>}
      </section>
      <section aria-label="Frames">
        <h2>Frames</h2>
        <label>
          Filter
          <input value={filter} placeholder="tpdo1 node1" onChange={(e) => setFilter(e.target.value)} />
        </label>{" "}
        <button type="button" aria-pressed={held !== undefined} onClick={() => hold(held ? undefined : [...store.traffic.frames])}>
          Hold
        </button>
        <Frames frames={frames} caption="Frames" />
      </section>
    </div>
  );
}

/** CAN buses: frames in words, signals, emergencies, nodes, objects, load, sending. */

import { Eraser, Pause, Rows3 } from "lucide-react";
import type { ReactNode } from "react";
import { useState } from "react";
import type { Curve } from "./curves.ts";
import { filterOf } from "./filter.ts";
import { Button, IconButton } from "./kit/Button.tsx";
import { Name } from "./kit/Name.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import type { Line } from "./lines.ts";
import { linesOf } from "./lines.ts";
import { Menu } from "./Menu.tsx";
import type { Place } from "./Menu.tsx";
import { briefly } from "./numbers.ts";
import { Objects } from "./Objects.tsx";
import { Plot, Span } from "./Plot.tsx";
import type { Bus, SystemState } from "./protocol/Ui.ts";
import { Send } from "./Send.tsx";
import { store } from "./store.ts";
import { t } from "./texts.ts";
import type { Seen } from "./traffic.ts";
import { identifierOf, wordsOf } from "./traffic.ts";

const SHOWN = 100;
/** Number of signals that are plotted at the same time. */
const PLOTTED = 8;
const COMMANDS = ["start", "stop", "pre-operational", "reset-node", "reset-communication"];

function Nodes({ bus, lines, full }: { bus: Bus; lines: readonly Line[]; full: boolean }) {
  const manage = (node_id: number, command: string) => store.order({ case: "managed", value: { bus: bus.name, node_id, command } });
  const [menu, open] = useState<Place & { node_id: number }>();
  const control = (node_id: number, name: string) => (
    <button
      type="button"
      aria-haspopup="menu"
      aria-label={t("NMT command to {name}", { name })}
      disabled={!full}
      onClick={(e) => {
        const { x, bottom } = e.currentTarget.getBoundingClientRect();
        open({ label: name, node_id, x, y: bottom });
      }}
    >
      NMT …
    </button>
  );
  const last = new Map(store.traffic.emergencies.filter((each) => each.bus === bus.name).map((each) => [each.node_id, each]));
  return (
    <section aria-label={t("Nodes and NMT")}>
      <h2>{t("Nodes")}</h2>
      <div className="nodes">
      <table aria-label={t("Nodes")}>
        <thead>
          <tr>
            <th scope="col">id</th>
            <th scope="col">{t("node")}</th>
            <th scope="col">{t("NMT state")}</th>
            <th scope="col">{t("last EMCY")}</th>
            <th scope="col">{t("components")}</th>
            <th scope="col">{control(0, t("all nodes"))}</th>
          </tr>
        </thead>
        <tbody>
          {(lines.find((each) => each.name === bus.name)?.nodes ?? []).map((node) => {
            const emergency = last.get(node.id);
            return (
              <tr key={node.id}>
                <td>{node.id}</td>
                <td className="text" title={bus.nodes.find((each) => each.node_id === node.id)?.device}>{node.name}</td>
                <td className="text">{node.nmtState || t("unknown")}</td>
                <td className="text" title={emergency && `${emergency.time.toFixed(3)} s`}>{emergency ? wordsOf(emergency) : ""}</td>
                <td className="text">{[...node.proxies, ...node.devices].join(", ")}</td>
                <td>{control(node.id, node.name)}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
      </div>
      {menu && (
        <Menu
          place={menu}
          items={COMMANDS.map((name) => ({ name, act: () => void manage(menu.node_id, name) }))}
          close={() => open(undefined)}
        />
      )}
    </section>
  );
}

const percent = (load: number): string => `${(100 * load).toFixed(1)} %`;

/** The measured load beside the computed one. */
function Load({ bus }: { bus: Bus }) {
  const last = store.traffic.loads.get(bus.name)?.at(-1);
  return (
    <p className="toolbar load">
      {bus.bit_rate > 0 && <span>{bus.bit_rate / 1000} kbit/s</span>}
      {!last && <span>{t("load not measured yet")}</span>}
      {last && bus.bit_rate > 0 && (
        <>
          <meter aria-label={t("Load of the bus")} min={0} max={1} low={0.4} high={0.7} optimum={0} value={last.load} />
          <span>{t("load {load}", { load: percent(last.load) })}</span>
        </>
      )}
      {bus.computed_load >= 0 && <span>{t("computed {load}", { load: percent(bus.computed_load) })}</span>}
      {last && <span>{t("{count} {count:frame|frames}/s", { count: last.frames })}</span>}
    </p>
  );
}

function LoadPlot({ bus }: { bus: Bus }) {
  const read = (): Curve[] => {
    const loads = store.traffic.loads.get(bus.name) ?? [];
    const times = loads.map((each) => each.time);
    const curve = (key: string, name: string, colour: number, value: (load: number) => number): Curve => ({ key, name, unit: "%", times, values: loads.map((each) => 100 * value(each.load)), colour });
    return [curve("measured", t("measured"), 0, (load) => load), ...(bus.computed_load < 0 ? [] : [curve("computed", t("computed"), 1, () => bus.computed_load)])];
  };
  if (bus.bit_rate <= 0) return null;
  return (
    <section aria-label={t("Load")}>
      <h2>{t("Load")}</h2>
      <Plot id={`load ${bus.name}`} read={read} label={t("Load of {name} over time", { name: bus.name })} zero />
    </section>
  );
}

/** Octets in hexadecimal digits; those that differ from the frame before are marked. */
function Octets({ seen: { frame, changed } }: { seen: Seen }) {
  if (frame.remote) return "remote";
  const digits = [...frame.data].map((octet) => octet.toString(16).padStart(2, "0"));
  return digits.map((each, i) => (
    <span key={i}>
      {i > 0 && " "}
      {changed[i] ? <mark>{each}</mark> : each}
    </span>
  ));
}

function Frames({ frames, caption, counted = false }: { frames: readonly Seen[]; caption: string; counted?: boolean }) {
  return (
    <div className="rows" tabIndex={0}>
      <table aria-label={caption} className={counted ? "frames counted" : "frames"}>
        <thead>
          <tr>
            <th scope="col">{t("time [s]")}</th>
            {counted && <th scope="col">{t("count")}</th>}
            {counted && <th scope="col">ms</th>}
            <th scope="col">id</th>
            <th scope="col">{t("node")}</th>
            <th scope="col">{t("kind")}</th>
            <th scope="col">{t("octets")}</th>
            <th scope="col">{t("meaning")}</th>
          </tr>
        </thead>
        <tbody>
          {frames.map((seen, i) => {
            const { frame } = seen;
            return (
              <tr key={counted ? identifierOf(frame) : i}>
                <td>{frame.time.toFixed(4)}</td>
                {counted && <td>{seen.count}</td>}
                {counted && <td>{Number.isNaN(seen.period) ? "" : (1000 * seen.period).toFixed(1)}</td>}
                <td>{identifierOf(frame)}</td>
                <td>{frame.node_id < 0 ? "" : frame.node_id}</td>
                <td className="text">{frame.kind}</td>
                <td className="octets">
                  <Octets seen={seen} />
                </td>
                <td className="text" title={wordsOf(frame)}>{briefly(wordsOf(frame))}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

const HELP = t(`Words, all of which a frame must have: tpdo1 node2
id:181 id:180-1FF node:2 kind:tpdo* data:0102 len>4 time<3
a field of a name: velocity>0.5
a | b: one of them   !a: not   ( ): groups   "two words"`);

/** The frames of a bus, the newest first, or the newest of each identifier. */
function Traffic({ bus }: { bus: string }) {
  const [filter, setFilter] = useState("");
  const [held, hold] = useState<{ frames: readonly Seen[]; newest: readonly Seen[] }>();
  const [counted, count] = useState(false);
  const [since, clear] = useState(-Infinity);
  const { traffic } = store;
  const test = filterOf(filter);
  const reason = typeof test === "string" ? test : "";
  const now = () => ({ frames: [...traffic.frames], newest: [...traffic.newest.values()] });
  const seen = held ?? { frames: traffic.frames, newest: counted ? [...traffic.newest.values()] : [] };
  const matches = ({ frame }: Seen) => frame.bus === bus && frame.time > since && (typeof test === "string" || test(frame));
  const all = (counted ? seen.newest : seen.frames).filter(matches);
  const frames = counted ? all.sort((a, b) => a.frame.can_id - b.frame.can_id) : all.slice(-SHOWN).reverse();
  return (
    <section aria-label={t("Frames")}>
      <div className="toolbar">
        <Refusable reason={reason}>
          {(said) => (
            <label className="filter">
              <span className="announced">{t("Filter")}</span>
              <input type="search" aria-label={t("Filter")} title={HELP} {...said} value={filter} placeholder={t("Filter: tpdo1 node2, id:180-1FF, velocity>0.5")} onChange={(e) => setFilter(e.target.value)} />
            </label>
          )}
        </Refusable>
        <Button icon={Rows3} title={t("One row for each identifier, with its period and what has changed")} aria-pressed={counted} onClick={() => count(!counted)}>
          {t("By identifier")}
        </Button>
        <Button icon={Pause} title={t("Keep these frames on the page; the bus goes on")} aria-pressed={held !== undefined} onClick={() => hold(held ? undefined : now())}>
          {t("Hold")}
        </Button>
        <IconButton icon={Eraser} look="plain" label={t("Clear frames")} onClick={() => clear(traffic.frames.at(-1)?.frame.time ?? -Infinity)} />
      </div>
      <Frames frames={frames} caption={t("Frames")} counted={counted} />
      {!frames.length && <p className="empty">{filter || since > 0 ? t("No frame matches.") : t("No frame has been seen yet.")}</p>}
    </section>
  );
}

/** A whole number in hexadecimal digits, beside its meaning. */
const hexOf = (value: number | undefined): string => (value !== undefined && Number.isInteger(value) ? `${value < 0 ? "-" : ""}0x${Math.abs(value).toString(16).toUpperCase()}` : "");

function Signals({ bus }: { bus: string }) {
  const [chosen, choose] = useState<readonly string[]>([]);
  const [filter, setFilter] = useState("");
  const { signals } = store.traffic;
  const wanted = filter.toLowerCase().split(/\s+/).filter(Boolean);
  const all = [...signals].filter(([, signal]) => signal.bus === bus);
  const shown = all.filter(([key, { name }]) => chosen.includes(key) || wanted.every((each) => name.toLowerCase().includes(each))).slice(0, SHOWN);
  const read = (): Curve[] =>
    chosen.flatMap((key, colour) => {
      const signal = signals.get(key);
      return signal ? [{ key, name: signal.name, unit: signal.unit, times: signal.times, values: signal.numbers, colour }] : [];
    });
  if (!all.length) return null;
  return (
    <section aria-label={t("Signals")}>
      <h2>{t("Signals")}</h2>
      {chosen.length > 0 && <Plot id={`signals ${bus}`} read={read} label={t("Signals over time")} />}
      <input type="search" aria-label={t("Find a signal")} placeholder={t("Find a signal")} value={filter} onChange={(e) => setFilter(e.target.value)} />
      <div className="rows" tabIndex={0}>
        <table aria-label={t("Values of signals")}>
          <thead>
            <tr>
              <th scope="col">{t("signal, plotted")}</th>
              <th scope="col">hex</th>
              <th scope="col">{t("value")}</th>
            </tr>
          </thead>
          <tbody>
            {shown.map(([key, { name, text, numbers }]) => (
              <tr key={key}>
                <th scope="row">
                  <label>
                    <input type="checkbox" checked={chosen.includes(key)} onChange={(e) => choose(e.target.checked ? [...chosen, key].slice(-PLOTTED) : chosen.filter((each) => each !== key))} />
                    <bdi>
                      <Name text={name} />
                    </bdi>
                  </label>
                </th>
                <td className="octets hex">{hexOf(numbers.at(-1))}</td>
                <td className="text" title={text}>{briefly(text)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

function Folded({ title, children }: { title: string; children: ReactNode }) {
  const [open, setOpen] = useState(false);
  return (
    <details open={open} onToggle={(e) => setOpen(e.currentTarget.open)}>
      <summary>{title}</summary>
      {open && children}
    </details>
  );
}

export function BusView({ system: { buses, components }, full }: { system: SystemState; full: boolean }) {
  const [name, open] = useState("");
  const bus = buses.find((each) => each.name === name) ?? buses[0];
  if (!bus) return <p className="empty">{t("No frame has been seen: components of this system use no CAN bus, or time has not passed yet.")}</p>;
  const emergencies = store.traffic.emergencies.filter((each) => each.bus === bus.name).map((frame): Seen => ({ frame, changed: [], period: NaN, count: 1 }));
  return (
    <div className="bus">
      <div className="toolbar">
        <label>
          {t("Bus")}
          <select value={bus.name} onChange={(e) => open(e.target.value)}>
            {buses.map((each) => (
              <option key={each.name} value={each.name}>{each.name}</option>
            ))}
          </select>
        </label>
        <Load bus={bus} />
      </div>
      <Traffic key={`frames ${bus.name}`} bus={bus.name} />
      <section aria-label={t("Emergencies")}>
        <h2>{t("Emergencies")}</h2>
        {emergencies.length ? <Frames frames={emergencies.reverse()} caption={t("Emergencies")} /> : <p>{t("none")}</p>}
      </section>
      <Nodes bus={bus} lines={linesOf(components, buses)} full={full} />
      <Signals key={`signals ${bus.name}`} bus={bus.name} />
      <Span />
      <LoadPlot bus={bus} />
      <Objects key={`objects ${bus.name}`} bus={bus} full={full} />
      <Folded title={t("Send frames")}>
        <Send key={`send ${bus.name}`} bus={bus.name} full={full} />
      </Folded>
    </div>
  );
}

/** What is selected besides a component: a connection with its properties, a port, a node of a bus. */

import { Scissors, X } from "lucide-react";
import type { FormEvent, ReactNode } from "react";
import { createContext, useEffect, useState } from "react";
import { Changes } from "./Changes.tsx";
import { limits } from "./Configuration.tsx";
import { Button } from "./kit/Button.tsx";
import { Dialog } from "./kit/Dialog.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import { chainsOf, times } from "./Latencies.tsx";
import { linesOf } from "./lines.ts";
import { Loss } from "./Loss.tsx";
import type { Connection, FileChange, Parameter, Port, PortAddress, SystemState } from "./protocol/Ui.ts";
import { reasonOf, store } from "./store.ts";
import { t } from "./texts.ts";
import type { View } from "./views.ts";

export type Subject = { kind: "wire"; name: string } | ({ kind: "port" } & PortAddress) | { kind: "node"; bus: string; id: number };

/** Shows a subject; undefined: none. */
export const Inspecting = createContext<(subject: Subject | undefined) => void>(() => undefined);

/** Whether the system has a subject still. */
export function exists(system: SystemState, subject: Subject): boolean {
  if (subject.kind === "wire") return system.connections.some((each) => each.name === subject.name);
  if (subject.kind === "port") return portAt(system, subject) !== undefined;
  return linesOf(system.components, system.buses).some((line) => line.name === subject.bus && line.nodes.some((node) => node.id === subject.id));
}

/** The ends of a connection in words. */
export const joined = ({ source, target }: Pick<Connection, "source" | "target">): string =>
  t("{source} to {target}", { source: `${source.instance}.${source.port}`, target: `${target.instance}.${target.port}` });

/** A subject in words. */
export function named(system: SystemState, subject: Subject): string {
  if (subject.kind === "port") return `${subject.instance}.${subject.port}`;
  if (subject.kind === "node") return t("node {id} of {bus}", { id: subject.id, bus: subject.bus });
  const found = system.connections.find((each) => each.name === subject.name);
  return found ? joined(found) : "";
}

const portAt = (system: SystemState, { instance, port }: PortAddress): Port | undefined => system.components.find((each) => each.instance === instance)?.ports.find((each) => each.name === port);

/** The names of properties as RT System Editor has them. */
const NAMES: Readonly<Record<string, string>> = {
  "dataport.dataflow_type": t("dataflow type"),
  "dataport.subscription_type": t("subscription type"),
  "dataport.publisher.push_policy": t("push policy"),
  "dataport.publisher.skip_count": t("skip count"),
  "dataport.publisher.push_rate": t("push rate"),
  "dataport.interface_type": t("interface type"),
  "dataport.data_type": t("data type"),
  length: t("length"),
  "write.full_policy": t("full policy"),
  "write.timeout": t("write timeout"),
  "read.empty_policy": t("empty policy"),
  "read.timeout": t("read timeout"),
};
const BUFFER = /^dataport\.(inport|outport)\.buffer\./;

interface Common {
  system: SystemState;
  full: boolean;
  select: (instance: string) => void;
  inspect: (subject: Subject | undefined) => void;
  open: (view: View) => void;
  /** Chooses a port of the selected component. */
  choosePort: (port: string) => void;
}

function Card({ title, close, children }: { title: string; close: () => void; children: ReactNode }) {
  return (
    <section className="card inspector" aria-label={title}>
      <div className="title">
        <h2>{title}</h2>
        <Button look="plain" className="icon" aria-label={t("Close the {title}", { title: title.toLowerCase() })} onClick={close}>
          <X size={16} aria-hidden />
        </Button>
      </div>
      {children}
    </section>
  );
}

function Row({ name, children }: { name: string; children: ReactNode }) {
  return (
    <tr>
      <th scope="row">{name}</th>
      <td className="text">{children}</td>
    </tr>
  );
}

function Instance({ instance, select }: { instance: string; select: (instance: string) => void }) {
  return (
    <button type="button" className="link plain" onClick={() => select(instance)}>
      {instance}
    </button>
  );
}

function Rate({ connection }: { connection: Connection }) {
  const flow = store.page.flows.get(connection.name);
  if (!flow) return null;
  return (
    <>
      {flow.rate >= 0 ? t("{rate} samples/s", { rate: flow.rate.toFixed(1) }) : t("not counted yet")}
      {flow.lost > 0n && <span className="late">{t(", {count} lost", { count: flow.lost })}</span>}
    </>
  );
}

/** A property of a connection, empty where the default applies. */
function Property({ parameter, text, implied, full, refused, set }: { parameter: Parameter; text: string; implied: string; full: boolean; refused: string; set: (text: string | undefined) => void }) {
  const key = parameter.name.replace(BUFFER, "");
  const name = Object.hasOwn(NAMES, key) ? NAMES[key]! : parameter.name;
  const label = parameter.name.replace(/^dataport\.(inport|outport)\.buffer.*/, "$1 ") === parameter.name ? name : BUFFER.exec(parameter.name)![1] === "inport" ? t("inport {name}", { name }) : t("outport {name}", { name });
  const { choices } = limits(parameter.constraint);
  return (
    <Row name={name}>
      <Refusable reason={refused}>
        {(said) => (
          <>
            {choices ? (
              <select {...said} aria-label={label} value={text} disabled={!full} onChange={(e) => set(e.target.value)}>
                <option value="">{t("{implied} (default)", { implied })}</option>
                {[...new Set([...choices, ...(text ? [text] : [])])].map((each) => (
                  <option key={each} value={each}>
                    {each}
                  </option>
                ))}
              </select>
            ) : (
              <input
                {...said}
                aria-label={label}
                value={text}
                disabled={!full}
                placeholder={implied && t("{implied} (default)", { implied })}
                inputMode={parameter.type === "double" ? "decimal" : undefined}
                onChange={(e) => set(e.target.value)}
                onKeyDown={(e) => e.key === "Escape" && set(undefined)}
              />
            )}{" "}
            <small>{parameter.unit}</small>
          </>
        )}
      </Refusable>
    </Row>
  );
}

function Wire({ system, connection, full, select, inspect }: Common & { connection: Connection }) {
  const { name, source, target, properties } = connection;
  const [draft, edit] = useState<ReadonlyMap<string, string>>(new Map());
  const [refused, refuse] = useState("");
  /** The property that the last reason has named, below whose field it is. */
  const [culprit, point] = useState("");
  const [said, say] = useState("");
  const [changes, show] = useState<readonly FileChange[]>();
  const [from, to] = [portAt(system, source), portAt(system, target)];
  const isService = from?.kind === "PORT_SERVICE";
  const flow = store.page.flows.get(name);
  const given = new Map(properties.map((each) => [each.name, each.text]));
  const shape = properties.map((each) => `${each.name}=${each.text}`).join("\n");
  // The buffer of an end is that of all ends unless it has its own.
  const implied = ({ name, default_value }: Parameter) => given.get(name.replace(/\.(inport|outport)\./, ".")) ?? (name === "dataport.data_type" ? (from?.type ?? "") : default_value);
  const isKnown = (key: string) => system.properties.some((each) => each.name === key);
  const ask = async (carried_out: boolean, changed: ReadonlyMap<string, string>) =>
    store.ask({ case: "adjusted", value: { connection: name, properties: [...changed].map(([name, text]) => ({ name, text: text.trim() })), carried_out } });
  // What the judge says of the connection as it is.
  useEffect(() => {
    let current = true;
    edit(new Map());
    if (!isService) void ask(false, new Map()).then((result) => current && say(result.done ? result.text : ""));
    return () => {
      current = false;
    };
  }, [name, shape, isService]);
  const submit = async (carried_out: boolean) => {
    const result = await ask(carried_out, draft);
    if (!result.done) {
      show(undefined);
      const reason = reasonOf(result);
      refuse(reason);
      point(system.properties.map((each) => each.name).find((each) => reason.includes(`'${each}'`)) ?? "");
      return;
    }
    refuse("");
    say(result.text);
    show(carried_out ? undefined : result.renamed);
  };
  const rows = (of: (name: string) => boolean) =>
    system.properties
      .filter((each) => of(each.name))
      .map((each) => (
        <Property
          key={each.name}
          parameter={each}
          text={draft.get(each.name) ?? given.get(each.name) ?? ""}
          implied={implied(each)}
          full={full}
          refused={each.name === culprit ? refused : ""}
          set={(text) => {
            const next = new Map(draft);
            if (text === undefined || text === (given.get(each.name) ?? "")) next.delete(each.name);
            else next.set(each.name, text);
            edit(next);
            refuse("");
          }}
        />
      ));
  const end = (name: string, address: PortAddress, unit = "") => (
    <Row name={name}>
      <Instance instance={address.instance} select={select} />.
      <button type="button" className="link plain" onClick={() => inspect({ kind: "port", ...address })}>
        {address.port}
      </button>{" "}
      <small>{unit && `[${unit}]`}</small>
    </Row>
  );
  return (
    <Card title={t("Connection")} close={() => inspect(undefined)}>
      {flow && flow.lost > 0n && (
        <>
          <p className="late">
            {t("{count} {count:sample|samples} lost: {details}", { count: flow.lost, details: flow.details })}
          </p>
          <Loss system={system} connection={connection} />
        </>
      )}
      {said && (
        <p className="late judged" role="note">
          {said}
        </p>
      )}
      <form
        onSubmit={(e: FormEvent) => {
          e.preventDefault();
          if (draft.size) void submit(false);
        }}
      >
        <table>
          <tbody>
            {end(t("from"), source, from?.unit)}
            {end(t("to"), target, to?.unit)}
            {from?.type && <Row name={t("type")}>{from.type}</Row>}
            {flow && (
              <Row name={t("rate")}>
                <Rate connection={connection} />
              </Row>
            )}
            {chainsOf(store.page.chains, connection).map((each) => (
              <Row key={each.name} name={t("latency")}>
                <bdi>{each.name}</bdi>
                <br />
                {times(each)}
              </Row>
            ))}
            {!isService && rows((each) => !BUFFER.test(each))}
          </tbody>
        </table>
        {!isService &&
          (["outport", "inport"] as const).map((side) => (
            <details key={side} open={(side === "inport" && flow !== undefined && flow.lost > 0n) || culprit.startsWith(`dataport.${side}.buffer.`)}>
              <summary>{side === "inport" ? t("Buffer of the InPort") : t("Buffer of the OutPort")}</summary>
              <table>
                <tbody>{rows((each) => each.startsWith(`dataport.${side}.buffer.`))}</tbody>
              </table>
            </details>
          ))}
        {properties.some((each) => each.text && !isKnown(each.name)) && (
          <details>
            <summary>{t("Other properties")}</summary>
            <table>
              <tbody>
                {properties
                  .filter((each) => each.text && !isKnown(each.name))
                  .map((each) => (
                    <Row key={each.name} name={each.name}>
                      <bdi>{each.text}</bdi>
                    </Row>
                  ))}
              </tbody>
            </table>
          </details>
        )}
        {refused && !culprit && (
          <p className="reason" role="alert">
            {refused}
          </p>
        )}
        <div className="buttons">
          {!isService && (
            <Button type="submit" look="primary" disabled={!full || !draft.size}>
              {t("Show what changes")}
            </Button>
          )}
          {draft.size > 0 && <Button onClick={() => edit(new Map())}>{t("Discard")}</Button>}
          <Button
            icon={Scissors}
            look="danger"
            disabled={!full}
            onClick={() => {
              inspect(undefined);
              void store.order({ case: "connection", value: name });
            }}
          >
            {t("Cut")}
          </Button>
        </div>
      </form>
      {changes && (
        <Dialog title={t("Properties of the connection")} close={() => show(undefined)} className="rename">
          {said && <p className="late judged">{said}</p>}
          <section aria-label={t("What changes")} className="changes" tabIndex={0}>
            <p>{changes.length ? t("The connection is made again with them at once; samples that wait in it are lost. Save writes the file, Undo takes it back.") : t("The file does not have this connection: only the run changes.")}</p>
            <Changes changes={changes} />
          </section>
          <div className="answers">
            <Button onClick={() => show(undefined)}>{t("Cancel")}</Button>
            <Button look="primary" onClick={() => void submit(true)}>
              {t("Apply")}
            </Button>
          </div>
        </Dialog>
      )}
    </Card>
  );
}

function PortCard({ system, address, full, select, inspect, open, choosePort }: Common & { address: PortAddress }) {
  const port = portAt(system, address)!;
  const isHere = ({ instance, port: name }: PortAddress) => instance === address.instance && name === address.port;
  const own = system.connections.filter(({ source, target }) => isHere(source) || isHere(target));
  return (
    <Card title={t("Port")} close={() => inspect(undefined)}>
      <table>
        <tbody>
          <Row name={t("port")}>
            <Instance instance={address.instance} select={select} />.<bdi>{address.port}</bdi>
          </Row>
          <Row name={t("kind")}>{{ PORT_IN: "InPort", PORT_OUT: "OutPort", PORT_SERVICE: t("service port") }[port.kind]}</Row>
          {port.type && <Row name={t("type")}>{port.type}</Row>}
          {port.interfaces.map((each) => (
            <Row key={`${each.provided} ${each.name}`} name={each.provided ? t("provides") : t("uses")}>
              <bdi>{each.name}</bdi>: {each.type}
            </Row>
          ))}
          {port.unit && <Row name={t("unit")}>{port.unit}</Row>}
          {port.units.length > 1 && port.units.map((each) => <Row key={each.name} name={each.name}>{each.text}</Row>)}
        </tbody>
      </table>
      {port.doc && <p>{port.doc}</p>}
      <h3>{own.length ? t("Connections") : t("Not connected")}</h3>
      <ul className="plainlist">
        {own.map((each) => {
          const there = isHere(each.source) ? each.target : each.source;
          return (
            <li key={each.name}>
              <button type="button" className="link plain" onClick={() => inspect({ kind: "wire", name: each.name })}>
                <bdi>{`${there.instance}.${there.port}`}</bdi>
              </button>
              <small>
                <Rate connection={each} />
              </small>
            </li>
          );
        })}
      </ul>
      <div className="buttons">
        <Button
          disabled={!full}
          onClick={() => {
            select(address.instance);
            inspect(undefined);
            choosePort(address.port);
            open("Connections");
          }}
        >
          {t("Which ports fit")}
        </Button>
      </div>
    </Card>
  );
}

function NodeCard({ system, bus, id, select, inspect, open }: Common & { bus: string; id: number }) {
  const line = linesOf(system.components, system.buses).find((each) => each.name === bus)!;
  const node = line.nodes.find((each) => each.id === id)!;
  const device = system.buses.find((each) => each.name === bus)?.nodes.find((each) => each.node_id === id)?.device;
  const frames = store.traffic.frames.map((each) => each.frame).filter((each) => each.bus === bus && each.node_id === id);
  const last = frames.at(-1);
  const list = (name: string, instances: readonly string[]) =>
    instances.length > 0 && (
      <Row name={name}>
        {instances.map((each) => (
          <Instance key={each} instance={each} select={select} />
        ))}
      </Row>
    );
  return (
    <Card title={t("Node")} close={() => inspect(undefined)}>
      <table>
        <tbody>
          <Row name={t("node")}>
            {id} <bdi>{node.name}</bdi>
          </Row>
          <Row name={t("bus")}>
            <bdi>{bus}</bdi>
            {line.bitRate > 0 && ` ${line.bitRate / 1000} kbit/s`}
          </Row>
          <Row name={t("NMT state")}>{node.nmtState || t("unknown")}</Row>
          {device && <Row name={t("device")}>{device}</Row>}
          {list(t("proxies"), node.proxies)}
          {list(t("devices"), node.devices)}
          {last && (
            <Row name={t("last frame")}>
              {last.time.toFixed(3)} s {last.kind} {last.text}
            </Row>
          )}
        </tbody>
      </table>
      <div className="buttons">
        <Button onClick={() => open("Buses")}>{t("Frames and objects")}</Button>
      </div>
    </Card>
  );
}

export function Inspector({ subject, ...rest }: Common & { subject: Subject }) {
  if (subject.kind === "port") return <PortCard address={{ instance: subject.instance, port: subject.port }} {...rest} />;
  if (subject.kind === "node") return <NodeCard bus={subject.bus} id={subject.id} {...rest} />;
  const connection = rest.system.connections.find((each) => each.name === subject.name);
  return connection ? <Wire key={subject.name} connection={connection} {...rest} /> : null;
}

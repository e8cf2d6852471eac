/** The selected connection: its ends, their types and units, its properties, and what becomes of its samples. */

import { Scissors, X } from "lucide-react";
import { Button } from "./kit/Button.tsx";
import type { Connection, PortAddress, SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";

/** Properties by which RT System Editor describes a connection, with their defaults. */
const KNOWN: readonly (readonly [string, string, string])[] = [
  ["dataflow", "dataport.dataflow_type", "push"],
  ["subscription", "dataport.subscription_type", "flush"],
  ["push policy", "dataport.publisher.push_policy", ""],
  ["push rate", "dataport.push_rate", ""],
  ["buffer of the InPort", "dataport.inport.buffer.length", "8"],
  ["if it is full", "dataport.inport.buffer.write.full_policy", "overwrite"],
];

export function Inspector({ system, connection, full, close, select }: { system: SystemState; connection: Connection; full: boolean; close: () => void; select: (instance: string) => void }) {
  const { source, target, properties } = connection;
  const portAt = ({ instance, port }: PortAddress) => system.components.find((each) => each.instance === instance)?.ports.find((each) => each.name === port);
  const flow = store.page.flows.get(connection.name);
  const [from, to] = [portAt(source), portAt(target)];
  const isService = from?.kind === "PORT_SERVICE";
  const given = new Map(properties.map((each) => [each.name, each.text]));
  // The buffer of an end is that of all ends unless it has its own.
  const textOf = (key: string) => given.get(key) ?? given.get(key.replace(".inport", ""));
  const row = (name: string, text: string, more = "") =>
    text && (
      <tr key={name}>
        <th scope="row">{name}</th>
        <td className="text">
          <bdi>{text}</bdi> <small>{more}</small>
        </td>
      </tr>
    );
  const end = (name: string, address: PortAddress, unit = "") => (
    <tr>
      <th scope="row">{name}</th>
      <td className="text">
        <button type="button" className="link plain" onClick={() => select(address.instance)}>
          {address.instance}
        </button>
        .<bdi>{address.port}</bdi> <small>{unit && `[${unit}]`}</small>
      </td>
    </tr>
  );
  return (
    <section className="card inspector" aria-label="Connection">
      <div className="title">
        <h2>Connection</h2>
        <Button look="plain" className="icon" aria-label="Close the connection" onClick={close}>
          <X size={16} aria-hidden />
        </Button>
      </div>
      {flow && flow.lost > 0n && (
        <p className="late">
          {String(flow.lost)} samples lost: {flow.details}
        </p>
      )}
      <table>
        <tbody>
          {end("from", source, from?.unit)}
          {end("to", target, to?.unit)}
          {row("type", from?.type ?? "")}
          {flow && row("rate", flow.rate >= 0 ? `${flow.rate.toFixed(1)} samples/s` : "not counted yet")}
          {!isService && KNOWN.map(([name, key, otherwise]) => row(name, textOf(key) ?? otherwise, textOf(key) === undefined ? "default" : ""))}
          {properties.filter(({ name, text }) => text && !KNOWN.some(([, key]) => key === name || key.replace(".inport", "") === name)).map(({ name, text }) => row(name, text))}
        </tbody>
      </table>
      <div className="buttons">
        <Button
          icon={Scissors}
          look="danger"
          disabled={!full}
          onClick={() => {
            close();
            void store.order({ case: "connection", value: connection.name });
          }}
        >
          Cut
        </Button>
      </div>
    </section>
  );
}

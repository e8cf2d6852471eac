/** Why a connection loses samples, and what can be done about it. */

import type { Component, Connection, SystemState } from "./protocol/Ui.ts";
import { stateOf, store } from "./store.ts";
import { t } from "./texts.ts";

/** A property of a connection as it holds: its own, that of both ends, or the default. */
function property({ properties: defaults }: SystemState, { properties }: Connection, name: string): string {
  const own = new Map(properties.map((each) => [each.name, each.text]));
  return own.get(name) || own.get(name.replace(/\.(inport|outport)\./, ".")) || (defaults.find((each) => each.name === name)?.default_value ?? "");
}

/** How often a component runs [Hz]. */
const rateOf = (component: Component | undefined): number => (component?.contexts ?? []).reduce((sum, each) => sum + (each.running ? each.rate : 0), 0);

/** The cause of lost samples and the way out, in sentences; nothing if the page cannot tell. */
export function explained(system: SystemState, connection: Connection): { cause: string; remedy: string } | undefined {
  const { source, target } = connection;
  const flow = store.page.flows.get(connection.name);
  const reader = system.components.find((each) => each.instance === target.instance);
  if (!flow || flow.lost <= 0n || !reader) return undefined;
  const state = stateOf(reader);
  if (state !== "ACTIVE") return { cause: t("{reader} is {state} and reads nothing.", { reader: target.instance, state }), remedy: t("Activate {reader}.", { reader: target.instance }) };
  if (property(system, connection, "dataport.publisher.push_policy") === "skip")
    return { cause: t("The push policy skips samples on purpose."), remedy: t("The push policy all sends each of them.") };
  const side = property(system, connection, "dataport.dataflow_type") === "pull" ? "outport" : "inport";
  const length = Number(property(system, connection, `dataport.${side}.buffer.length`));
  const rate = rateOf(reader);
  const nominal = rateOf(system.components.find((each) => each.instance === source.instance));
  // Counts of a second vary; most components write once in each tick.
  const written = Math.abs(flow.rate - nominal) < 0.2 * nominal ? nominal : flow.rate;
  if (!(length > 0 && rate > 0 && written > 0)) return undefined;
  const arriving = Math.ceil(written / rate - 1e-3);
  const often = Number(written.toFixed(1));
  const newest = t("If only the newest sample counts, nothing needs to be changed.");
  return arriving > length
    ? { cause: t("{writer} writes {written} samples/s, {reader} runs at {rate} Hz: {arriving} samples arrive between two ticks, and the buffer holds {length}.", { writer: source.instance, written: often, reader: target.instance, rate, arriving, length }), remedy: `${t("A buffer length of {arriving} holds all of them.", { arriving })} ${newest}` }
    : { cause: t("{writer} writes {written} samples/s, {reader} runs at {rate} Hz, but does not read all that has arrived: the buffer of {length} is full.", { writer: source.instance, written: often, reader: target.instance, rate, length }), remedy: `${t("Read until nothing is new in each tick.")} ${newest}` };
}

export function Loss({ system, connection }: { system: SystemState; connection: Connection }) {
  const found = explained(system, connection);
  if (!found) return null;
  return (
    <p className="cause">
      <bdi>{found.cause}</bdi> <bdi>{found.remedy}</bdi>
    </p>
  );
}

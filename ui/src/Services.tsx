/** Operations of the interfaces that a component provides, called from forms. */

import { useEffect, useState } from "react";
import { CallTable, Histogram } from "./Board.tsx";
import { Elsewhere } from "./Elsewhere.tsx";
import { Form, Refusal } from "./Form.tsx";
import type { Draft } from "./draft.ts";
import { DraftError, draft, finish } from "./draft.ts";
import type { BoardCall, Component, Operation, PortAddress, Result, SystemState } from "./protocol/Ui.ts";
import { CdrError, deserialize, serialize } from "./protocol/_cdr.ts";
import { rich } from "./rich.tsx";
import { leaves, reasonOf, store } from "./store.ts";
import { t } from "./texts.ts";

/** Maximum number of repeated calls of a form. */
const MAX_CALLS = 500;
/** Maximum number of calls that wait for their results. */
const AT_ONCE = 100;
const SHOWN = 20;

interface Outcome {
  error: string;
  values: [string, unknown][];
  calls: readonly BoardCall[];
}

/** The draft of a request, or the reason why there is none. */
function begin(operation: Operation): { value: Draft; refused: string } {
  if (operation.refused || operation.request < 0) return { value: {}, refused: operation.refused };
  try {
    return { value: draft(store.types, operation.request), refused: "" };
  } catch (error) {
    if (error instanceof DraftError) return { value: {}, refused: error.message };
    throw error;
  }
}

/** What forms contain, by operation, for the time when another view is shown; of the newest ones. */
const kept = new Map<string, { value: Draft; times: number; outcome?: Outcome | undefined }>();
const MAX_KEPT = 200;

function OperationForm(props: { port: PortAddress; interfaceName: string; operation: Operation; full: boolean }) {
  const { port, interfaceName, operation, full } = props;
  const [first] = useState(() => begin(operation));
  const name = `${port.instance}.${port.port} ${operation.name}`;
  const key = JSON.stringify([port.instance, port.port, interfaceName, operation.name, operation.request]);
  const before = kept.get(key);
  const [value, change] = useState(before?.value ?? first.value);
  const [times, setTimes] = useState(before?.times ?? 1);
  const [outcome, show] = useState(before?.outcome);
  const [refused, refuse] = useState<DraftError>();
  useEffect(() => {
    kept.delete(key);
    kept.set(key, { value, times, outcome });
    if (kept.size > MAX_KEPT) kept.delete(kept.keys().next().value!);
  }, [key, value, times, outcome]);
  const call = async () => {
    const failed = (error: string) => show({ error, values: [], calls: [] });
    let octets = new Uint8Array();
    refuse(undefined);
    try {
      if (operation.request >= 0)
        octets = serialize(store.types.codec(operation.request), finish(store.types, operation.request, value)) as Uint8Array<ArrayBuffer>;
    } catch (error) {
      if (error instanceof DraftError) {
        show(undefined);
        return refuse(error);
      }
      if (error instanceof CdrError) return failed(error.message);
      throw error;
    }
    const before = store.traffic.callCount;
    const one = () => store.ask({ case: "called", value: { port, interface_name: interfaceName, operation: operation.name, arguments: octets } });
    let result: Result | undefined;
    for (let left = times; left > 0 && (result?.done ?? true); left -= AT_ONCE) {
      const results = await Promise.all(Array.from({ length: Math.min(left, AT_ONCE) }, one));
      result = results.find((each) => !each.done) ?? results.at(-1)!;
    }
    if (!result) return undefined;
    if (!result.done) return failed(reasonOf(result));
    let reply: unknown = {};
    try {
      if (operation.reply >= 0) reply = deserialize(store.types.codec(operation.reply), result.reply);
    } catch (error) {
      if (error instanceof CdrError) return failed(t("the result cannot be read: {reason}", { reason: error.message }));
      throw error;
    }
    const calls = store.traffic.callsSince(before);
    const own = calls.filter((each) => each.function.endsWith(`.${operation.name}`));
    return show({ error: "", values: leaves(reply), calls: own.length ? own : calls.slice(-times) });
  };
  return (
    <form
      className="operation"
      aria-label={name}
      onSubmit={(e) => {
        e.preventDefault();
        void call();
      }}
    >
      <h3 title={operation.doc}>{operation.name}</h3>
      {operation.doc && <p>{operation.doc}</p>}
      {first.refused ? (
        <p>{first.refused}</p>
      ) : (
        <>
          {operation.request >= 0 && (
            <Refusal value={refused}>
              <Form
                type={operation.request}
                value={value}
                label=""
                change={(next) => {
                  change(next);
                  refuse(undefined);
                }}
              />
            </Refusal>
          )}
          <button type="submit" disabled={!full} aria-label={t("Call {name} of {instance}.{port}", { name: operation.name, instance: port.instance, port: port.port })}>
            {t("Call")}
          </button>{" "}
          <label>
            <input type="number" className="times" min={1} max={MAX_CALLS} disabled={!full} value={times} aria-label={t("Times {name} is called", { name: operation.name })} onChange={(e) => setTimes(Math.min(Math.max(Math.trunc(e.target.valueAsNumber) || 1, 1), MAX_CALLS))} />
            {t("times")}
          </label>
        </>
      )}
      {outcome && (
        <div role="status" aria-label={t("Result of {name}", { name: operation.name })}>
          {outcome.error ? (
            <p className="reason">{outcome.error}</p>
          ) : outcome.values.length ? (
            <table>
              <tbody>
                {outcome.values.map(([path, each]) => (
                  <tr key={path}>
                    <th scope="row">{path.replace(/^_result/, "result")}</th>
                    <td className="text">{String(each)}</td>
                  </tr>
                ))}
              </tbody>
            </table>
          ) : (
            <p>{t("done")}</p>
          )}
          {outcome.calls.length > 1 && <Histogram calls={outcome.calls} />}
          {outcome.calls.length > 0 && <CallTable calls={outcome.calls.slice(-SHOWN).reverse()} />}
        </div>
      )}
    </form>
  );
}

const servicesOf = (component: Component) => component.ports.flatMap((port) => port.interfaces.filter((each) => each.provided).map((each) => ({ port, each })));

export function Services({ system, component, full, select }: { system: SystemState; component: Component; full: boolean; select: (instance: string) => void }) {
  const provided = servicesOf(component);
  if (!provided.length) return <Elsewhere reason={t("This component provides no service.")} system={system} has={(each) => servicesOf(each).length > 0} select={select} />;
  return provided.map(({ port, each }) => (
    <section key={`${port.name} ${each.name}`} aria-label={`${port.name} ${each.type}`}>
      <h2>
        <bdi>{port.name}</bdi>: <bdi>{each.type}</bdi>
      </h2>
      {component.place && !each.operations.length && <p>{rich("The project does not define {type}, so its operations are unknown.", { type: <bdi>{each.type}</bdi> })}</p>}
      {each.operations.map((operation) => (
        <OperationForm key={operation.name} port={{ instance: component.instance, port: port.name }} interfaceName={each.name} operation={operation} full={full} />
      ))}
    </section>
  ));
}

/** What is seen when nothing is selected: how the system does, and what can be done. */

import { Activity, CircleAlert, MousePointerClick, Plus, Spline } from "lucide-react";
import { joined } from "./Inspector.tsx";
import type { Subject } from "./Inspector.tsx";
import { Latencies } from "./Latencies.tsx";
import { Loss } from "./Loss.tsx";
import type { SystemState } from "./protocol/Ui.ts";
import { rich } from "./rich.tsx";
import { stateClass, stateOf, store } from "./store.ts";
import { t } from "./texts.ts";

/** Wires that lose samples are listed up to this number. */
const MOST = 12;

export function Overview({ system, select, inspect }: { system: SystemState; select: (instance: string) => void; inspect: (subject: Subject) => void }) {
  const { components, connections, time, plan } = system;
  const { flows, chains, statistics, traffic } = { ...store.page, traffic: store.traffic };
  const states = new Map<string, { of: string; instances: string[] }>();
  for (const each of components) {
    const name = stateOf(each);
    states.set(name, { of: stateClass(each), instances: [...(states.get(name)?.instances ?? []), each.instance] });
  }
  const failed = components.filter((each) => stateOf(each) === "ERROR" || each.silent);
  const losing = connections.filter((each) => (flows.get(each.name)?.lost ?? 0n) > 0n).sort((a, b) => Number(flows.get(b.name)!.lost - flows.get(a.name)!.lost));
  const late = components.filter((each) => (statistics.get(each.instance)?.overruns ?? 0n) > 0n);
  const next = plan.find((each) => each.time > time.now);
  const chosen = (instance: string) => (
    <button type="button" className="link plain" onClick={() => select(instance)}>
      {instance}
    </button>
  );
  return (
    <div className="overview">
      {system.doc && <p>{system.doc}</p>}
      <section aria-label={t("Components by state")} className="card">
        <h2>
          {t("{components} {components:component|components}, {connections} {connections:connection|connections}", { components: components.length, connections: connections.length })}
        </h2>
        {!components.length && <p>{t("The system has no components yet.")}</p>}
        <p className="toolbar">
          {[...states].map(([name, { of, instances }]) => (
            <span key={name} className={`state ${of}`} title={instances.join("\n")}>
              {instances.length} {name}
            </span>
          ))}
        </p>
        {failed.map((each) => (
          <p key={each.instance} className="reason">
            <CircleAlert size={14} aria-hidden /> {chosen(each.instance)} {each.silent || each.reason}
          </p>
        ))}
        {late.length > 0 && (
          <p>
            {t("Late:")}{" "}
            {late.map((each) => (
              <span key={each.instance}>
                {chosen(each.instance)} {t("{count} {count:overrun|overruns}", { count: statistics.get(each.instance)!.overruns })}{" "}
              </span>
            ))}
          </p>
        )}
      </section>
      <section aria-label={t("Lost samples")} className="card">
        <h2>{losing.length ? t("{count} {count:connection loses|connections lose} samples", { count: losing.length }) : t("No connection loses samples")}</h2>
        <ul className="plainlist">
          {losing.slice(0, MOST).map((each) => (
            <li key={each.name}>
              <button type="button" className="link plain" onClick={() => inspect({ kind: "wire", name: each.name })}>
                <bdi>{joined(each)}</bdi>
              </button>
              <small className="late">{flows.get(each.name)!.details}</small>
              <Loss system={system} connection={each} />
            </li>
          ))}
        </ul>
      </section>
      <Latencies chains={chains} select={inspect} system={system} />
      {system.buses.length > 0 && (
        <section aria-label={t("Buses")} className="card">
          <h2>{t("Buses")}</h2>
          {system.buses.map((bus) => {
            const load = traffic.loads.get(bus.name)?.at(-1)?.load;
            return (
              <p key={bus.name}>
                <bdi>{bus.name}</bdi>: {t("{count} {count:node|nodes}", { count: bus.nodes.length })}{load !== undefined && t(", load {value} %", { value: (100 * load).toFixed(1) })}
                {bus.computed_load >= 0 && t(", computed {value} %", { value: (100 * bus.computed_load).toFixed(1) })}
              </p>
            );
          })}
        </section>
      )}
      {next && (
        <section aria-label={t("Next event")} className="card">
          <h2>{t("Next on the timeline")}</h2>
          <p>
            <time>{next.time.toFixed(3)} s</time> {next.kind} <bdi>{next.text}</bdi>
          </p>
        </section>
      )}
      <section aria-label={t("What can be done")} className="card hints">
        <h2>{t("What can be done")}</h2>
        <p>
          <MousePointerClick size={14} aria-hidden /> <span>{t("Press a box for its values, parameters and services.")}</span>
        </p>
        <p>
          <Spline size={14} aria-hidden /> <span>{t("Drag from port to port to connect; press a wire and Delete to cut it.")}</span>
        </p>
        <p>
          <Plus size={14} aria-hidden /> <span>{t("Components adds one: press it, or drag it to its place.")}</span>
        </p>
        <p>
          <Activity size={14} aria-hidden /> <span>{rich("{space} plays, {step} steps, {find} finds everything, {keys} shows all keys.", { space: <kbd>Space</kbd>, step: <kbd>.</kbd>, find: <kbd>Ctrl K</kbd>, keys: <kbd>?</kbd> })}</span>
        </p>
      </section>
    </div>
  );
}

/** The views of the selected component, below what it is and how it does. */

import { Fragment } from "react";
import { Configuration } from "./Configuration.tsx";
import { Connections } from "./Connections.tsx";
import type { Component, SystemState } from "./protocol/Ui.ts";
import { Services } from "./Services.tsx";
import { Pencil, Trash2 } from "lucide-react";
import { IconButton } from "./kit/Button.tsx";
import { Inspector } from "./Inspector.tsx";
import type { Subject } from "./Inspector.tsx";
import { duration } from "./numbers.ts";
import { Overview } from "./Overview.tsx";
import type { Statistics } from "./store.ts";
import { Values } from "./Values.tsx";
import { stateClass, stateOf, store } from "./store.ts";
import { t } from "./texts.ts";
import type { View } from "./views.ts";
import { titleOf } from "./views.ts";

/** What is known of the board that a component calls. */
function BoardOf({ instance, open }: { instance: string; open: (view: View) => void }) {
  const calls = store.traffic.calls.filter((each) => each.instance === instance);
  const last = calls.at(-1);
  if (!last) return null;
  const trips = calls.map((each) => each.round_trip).filter((each) => each >= 0);
  const failed = calls.filter((each) => each.error);
  return (
    <section className="card" aria-label={t("Board")}>
      <h2>{t("Board")}</h2>
      <p>
        {t("{count} {count:call|calls}", { count: calls.length })}
        {trips.length > 0 && t(", {mean} each", { mean: duration(trips.reduce((sum, each) => sum + each, 0) / trips.length) })}
        {t(", the last {name} at {time} s", { name: last.function || t("of unknown function"), time: last.time.toFixed(3) })}
      </p>
      {failed.length > 0 && (
        <p className="reason">
          {t("{count} failed: {error}", { count: failed.length, error: failed.at(-1)!.error })}
        </p>
      )}
      <div className="buttons">
        <button type="button" onClick={() => open("Boards")}>
          {t("Octets and round trips")}
        </button>
      </div>
    </section>
  );
}

/** A text in which no line ends between a number and what is counted. */
const together = (text: string): string => text.replaceAll(/(?<=\d) /g, "\u00a0");

export function Panel(props: {
  view: View;
  system: SystemState;
  component: Component | undefined;
  statistics: Statistics | undefined;
  full: boolean;
  select: (instance: string) => void;
  rename: (instance: string) => void;
  subject: Subject | undefined;
  inspect: (subject: Subject | undefined) => void;
  open: (view: View) => void;
  /** The port of which the connections are shown. */
  port: string;
  choosePort: (port: string) => void;
}) {
  const { view, system, component, statistics, full, select, rename, subject, inspect, open, port, choosePort } = props;
  return (
    <aside className="panel" aria-label={t("Component: {view}", { view: titleOf(view) })} data-view={view} tabIndex={-1}>
      {subject && <Inspector subject={subject} {...{ system, full, select, inspect, open, choosePort }} />}
      <label>
        {t("Component")}
        <select value={component?.instance ?? ""} onChange={(e) => select(e.target.value)}>
          <option value="">{t("Overview")}</option>
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
                , {each.rate}{"\u00a0"}Hz <bdi>{each.kind.toLowerCase()}</bdi>
                {!each.running && t(", stopped")}
              </Fragment>
            ))}
            {statistics && together(t(", {ticks} {ticks:tick|ticks}, {overruns} {overruns:overrun|overruns}, {lost} lost", { ticks: statistics.ticks, overruns: statistics.overruns, lost: statistics.lost }))}
          </p>
          {system.beside && store.page.beside.has(component.instance) && <p>{t("beside: {state}", { state: store.page.beside.get(component.instance)! })}</p>}
          {component.silent && <p className="reason">{component.silent}</p>}
          {(component.reason || statistics?.impaired) && <p className={stateOf(component) === "FINISHED" ? "" : "reason"}>{component.reason || statistics?.impaired}</p>}
          <div className="buttons">
            {!component.place && (
              <IconButton icon={Pencil} label={t("Rename {instance}", { instance: component.instance })} keys="F2" disabled={!full} onClick={() => rename(component.instance)} />
            )}
            {(
              [
                [t("Activate"), t("Activate {instance}", { instance: component.instance }), "activated"],
                [t("Deactivate"), t("Deactivate {instance}", { instance: component.instance }), "deactivated"],
                [t("Reset"), t("Reset {instance}", { instance: component.instance }), "restored"],
              ] as const
            ).map(([name, label, kind]) => (
              <button key={kind} type="button" disabled={!full} aria-label={label} onClick={() => store.order({ case: kind, value: [component.instance] })}>
                {name}
              </button>
            ))}
            <IconButton icon={Trash2} label={t("Remove {name}", { name: component.instance })} disabled={!full} onClick={() => store.order({ case: "removed", value: component.instance })} />
          </div>
        </>
      )}
      {component && <BoardOf instance={component.instance} open={open} />}
      {!component ? (
        <>
          {view !== "Values" && <p>{t("{view}: choose a component, above or by its box.", { view: titleOf(view) })}</p>}
          <Overview system={system} select={select} inspect={inspect} />
        </>
      ) : view === "Values" ? (
        <Values key={component.instance} {...{ system, component, select }} />
      ) : view === "Connections" ? (
        <Connections key={component.instance} system={system} component={component} full={full} chosen={port} choose={choosePort} />
      ) : view === "Services" ? (
        <Services key={component.instance} {...{ system, component, full, select }} />
      ) : (
        <Configuration key={component.instance} {...{ system, component, full, select }} />
      )}
    </aside>
  );
}

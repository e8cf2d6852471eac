/** View of connections: makes and cuts connections of a component's ports without the graph. */

import { useEffect, useState } from "react";
import type { Component, Fit, PortAddress, SystemState } from "./protocol/Ui.ts";
import type { Misfit } from "./Purpose.tsx";
import { Purpose } from "./Purpose.tsx";
import { store } from "./store.ts";
import { t } from "./texts.ts";
import type { Unfit } from "./Unfit.tsx";
import { UnfitCard, differences, ordered, sentence } from "./Unfit.tsx";

const named = ({ instance, port }: PortAddress): string => `${instance}.${port}`;
const KINDS = { PORT_IN: t("in"), PORT_OUT: t("out"), PORT_SERVICE: t("service") } as const;

export function Connections({ system, component, full, chosen, choose }: { system: SystemState; component: Component; full: boolean; chosen: string; choose: (port: string) => void }) {
  const [fits, setFits] = useState<readonly Fit[]>();
  const [misfit, ask] = useState<Misfit>();
  const [unfit, explain] = useState<Unfit>();
  const port = component.ports.find((each) => each.name === chosen);
  const here: PortAddress = { instance: component.instance, port: chosen };
  const own = system.connections.filter(({ source, target }) => [named(source), named(target)].includes(named(here)));
  // The ports that fit depend on the existing ports and their connections.
  const shape = [...system.components.map((each) => each.instance), ...system.connections.map((each) => each.name)].join("\n");

  useEffect(() => {
    let current = true;
    setFits(undefined);
    if (port)
      void store.ask({ case: "ends", value: { instance: component.instance, port: port.name } }).then((result) => {
        if (current) result.done ? setFits(result.fits) : store.notify(result.message);
      });
    return () => {
      current = false;
    };
  }, [component.instance, port?.name, shape]);

  const show = (there: PortAddress, reason: string, { currentTarget }: { currentTarget: Element }) => explain({ ends: ordered(system.components, here, there), reason, at: currentTarget.getBoundingClientRect() });
  const connect = async (there: PortAddress, at: { currentTarget: Element }) => {
    const [source, target] = port?.kind === "PORT_IN" ? [there, here] : [here, there];
    const { currentTarget } = at;
    const reason = await store.attempt({ case: "wire", value: { source, target, name: "", properties: [] } });
    if (reason) show(there, reason, { currentTarget });
  };
  const offered = fits?.filter((each) => !each.refused) ?? [];
  const refused = fits?.filter((each) => each.refused) ?? [];
  return (
    <>
      <label>
        {t("Port")}
        <select aria-label={t("Chosen port")} value={port?.name ?? ""} onChange={(e) => choose(e.target.value)}>
          <option value="">{t("none")}</option>
          {component.ports.map((each) => (
            <option key={each.name} value={each.name}>
              <bdi>{each.name}</bdi> ({KINDS[each.kind]})
            </option>
          ))}
        </select>
      </label>
      {!port && (
        <ul className="ends" aria-label={t("Ports of {instance}", { instance: component.instance })}>
          {component.ports.map((each) => {
            const count = system.connections.filter(({ source, target }) => [named(source), named(target)].includes(named({ instance: component.instance, port: each.name }))).length;
            return (
              <li key={each.name}>
                <button type="button" className="link plain" onClick={() => choose(each.name)}>
                  {each.name}
                </button>
                <small>{`${KINDS[each.kind]}, ${count ? t("{count} connected", { count }) : t("not connected")}`}</small>
              </li>
            );
          })}
        </ul>
      )}
      {port && (
        <>
          <h2>{t("Connected")}</h2>
          {!own.length && <p>{t("Not connected.")}</p>}
          <ul className="ends" aria-label={t("Connections of {here}", { here: named(here) })}>
            {own.map((each) => {
              const there = named(each.source) === named(here) ? each.target : each.source;
              return (
                <li key={each.name}>
                  <bdi>{named(there)}</bdi>
                  <button type="button" disabled={!full} aria-label={t("Cut {here} from {there}", { here: named(here), there: named(there) })} onClick={() => store.order({ case: "connection", value: each.name })}>
                    {t("Cut")}
                  </button>
                </li>
              );
            })}
          </ul>
          <h2>{t("Fits")}</h2>
          {fits && !offered.length && <p>{t("No other port fits.")}</p>}
          <ul className="ends" aria-label={t("Ports that fit {here}", { here: named(here) })}>
            {offered.map(({ port: there }) => (
              <li key={named(there)}>
                <bdi>{named(there)}</bdi>
                <button type="button" disabled={!full} aria-label={t("Connect {here} with {there}", { here: named(here), there: named(there) })} onClick={(e) => void connect(there, e)}>
                  {t("Connect")}
                </button>
              </li>
            ))}
          </ul>
          <details>
            <summary>{t("{count} {count:port does|ports do} not fit", { count: refused.length })}</summary>
            <ul className="refusals" aria-label={t("Ports that do not fit {here}", { here: named(here) })}>
              {refused.map((each) => (
                <li key={named(each.port)}>
                  <strong>{named(each.port)}</strong> <bdi>{sentence(each.refused)}</bdi>
                  {differences(each.refused).length > 0 && (
                    <button type="button" aria-haspopup="dialog" aria-label={t("Compare the types of {here} and {there}", { here: named(here), there: named(each.port) })} onClick={(e) => show(each.port, each.refused, e)}>
                      {t("Compare the types")}
                    </button>
                  )}
                  {each.allow && (
                    <button type="button" disabled={!full} aria-label={t("Connect {here} with {port} on purpose", { here: named(here), port: named(each.port) })} onClick={() => ask({ here, fit: each })}>
                      {t("Connect on purpose")}
                    </button>
                  )}
                </li>
              ))}
            </ul>
          </details>
        </>
      )}
      {unfit && <UnfitCard unfit={unfit} close={() => explain(undefined)} />}
      {misfit && <Purpose misfit={misfit} close={() => ask(undefined)} />}
    </>
  );
}

/** The samples of a component's ports, and of those that its InPorts are connected to. */

import { useMemo } from "react";
import { Elsewhere } from "./Elsewhere.tsx";
import { isTime, MemberPlot, portOf } from "./MemberPlot.tsx";
import { usePlots } from "./members.ts";
import { Span } from "./Plot.tsx";
import type { Component, SystemState } from "./protocol/Ui.ts";
import { rich } from "./rich.tsx";
import { leaves, store } from "./store.ts";
import { t } from "./texts.ts";

/** The members of a sample by their paths; a time stamp is one, in seconds. */
function membersOf(sample: unknown): [string, unknown][] {
  const members = leaves(sample);
  const [sec, nsec] = ["tm.sec", "tm.nsec"].map((path) => members.find(([each]) => each === path)?.[1]);
  if (sec === undefined || nsec === undefined) return members;
  return [["tm", `${String(sec)}.${String(nsec).padStart(9, "0")} s`], ...members.filter(([path]) => !isTime(path))];
}

export function Values({ system, component, select }: { system: SystemState; component: Component; select: (instance: string) => void }) {
  const plots = usePlots();
  const shown = useMemo(() => {
    const near = new Set(
      system.connections
        .filter((each) => each.target.instance === component.instance)
        .map((each) => `${each.source.instance}.${each.source.port}`),
    );
    return system.channels.filter((each) => each.port.instance === component.instance || near.has(portOf(each)));
  }, [system.connections, system.channels, component.instance]);
  const unknown = component.ports.filter((each) => component.place && each.kind === "PORT_OUT" && each.type_number < 0);
  if (!shown.length && !unknown.length) {
    const writers = new Set(system.channels.map((each) => each.port.instance));
    return <Elsewhere reason={t("No port of this component has values.")} system={system} has={(each) => writers.has(each.instance)} select={select} />;
  }
  const sections = shown.filter((each) => !each.beside).map((channel) => {
    const name = portOf(channel);
    const other = shown.find((each) => each.beside && portOf(each) === name);
    const [track, beside] = [store.tracks.get(channel.id), other && store.tracks.get(other.id)];
    const rows = track?.times.length ? track : beside;
    const texts = new Map(membersOf(beside?.value));
    const others = membersOf(rows?.value).filter(([path]) => !rows?.numbers.has(path) || isTime(path));
    const id = `values ${name}`;
    return (
      <section key={channel.id} aria-label={name}>
        <h2>{name}</h2>
        {track?.refused && <p className="reason">{t("The last sample could not be read: {reason}", { reason: track.refused })}</p>}
        {!rows?.times.length && !track?.refused && <p>{t("No sample yet.")}</p>}
        <MemberPlot id={id} label={t("Values over time")} system={system} own={channel} added={plots.get(id) ?? []} />
        {rows?.thinned && <p className="thinned">{t("Older parts of the plot show only some of the samples: short peaks may be missing there.")}</p>}
        {rows && rows.times.length > 0 && others.length > 0 && (
          <table aria-label={t("Texts of {name}", { name })}>
            <tbody>
              {others.map(([path, value]) => (
                <tr key={path}>
                  <th scope="row">{path}</th>
                  <td className="text">{track?.times.length ? String(value) : ""}</td>
                  {other && <td className="text">{texts.has(path) ? String(texts.get(path)) : ""}</td>}
                </tr>
              ))}
            </tbody>
          </table>
        )}
      </section>
    );
  });
  return (
    <>
      <Span compared={system.beside !== ""} />
      {sections}
      {unknown.map((each) => (
        <p key={each.name}>
          {rich("{port}: the project does not define {type}, so its samples cannot be read.", { port: <bdi>{each.name}</bdi>, type: <bdi>{each.type}</bdi> })}
        </p>
      ))}
    </>
  );
}

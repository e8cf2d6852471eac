/** A plot of members of ports, in this run and in the compared one. */

import type { ReactNode } from "react";
import { useEffect, useRef } from "react";
import type { Curve } from "./curves.ts";
import { differences, stampOf } from "./curves.ts";
import { Plot } from "./Plot.tsx";
import type { Member } from "./members.ts";
import { addMember, carriedOf, memberOf, removeMember } from "./members.ts";
import type { Channel, SystemState } from "./protocol/Ui.ts";
import { leaves, store } from "./store.ts";

export const portOf = ({ port }: Channel): string => `${port.instance}.${port.port}`;

/** The units of numbers in a port's samples, by the paths of members. */
export function unitsOf(system: SystemState, channel: Channel): (path: string) => string {
  const owner = system.components.find((each) => each.instance === channel.port.instance);
  const port = owner?.ports.find((each) => each.name === channel.port.port && each.kind === "PORT_OUT");
  const units = new Map(port?.units.map((each) => [each.name, each.text]));
  return (path) => units.get(path.replace(/\[[^\]]*\]/g, "")) ?? "";
}

/** Whether a member is of the time stamp, which plots do not show. */
export const isTime = (path: string): boolean => /^tm\b/.test(path);

interface Props {
  id: string;
  label: string;
  system: SystemState;
  /** The port whose members the plot has, beside those that were added. */
  own?: Channel;
  added: readonly Member[];
  children?: ReactNode;
}

export function MemberPlot({ id, label, system, own, added, children }: Props) {
  const ports = [...new Set([...(own ? [portOf(own)] : []), ...added.map((each) => each.port)])];
  const channels = system.channels.filter((each) => ports.includes(portOf(each)));
  const wanted = channels.map((each) => each.id).join();
  useEffect(() => store.watch(wanted ? wanted.split(",").map(Number) : []), [wanted]);

  const members: readonly Member[] = own ? [{ port: portOf(own), path: "" }, ...added] : added;
  const several = ports.length > 1 || !own;
  const units = new Map(channels.filter((each) => !each.beside).map((each) => [portOf(each), unitsOf(system, each)]));
  const read = (): Curve[] => {
    const numbers = new Map<string, number>();
    const found = new Map<string, Curve>();
    for (const { port, path } of members)
      for (const channel of channels) {
        if (portOf(channel) !== port) continue;
        const track = store.tracks.get(channel.id);
        if (!track) continue;
        for (const [name, values] of track.numbers) {
          if (path ? name !== path : isTime(name)) continue;
          const key = carriedOf({ port, path: name });
          if (!numbers.has(key)) numbers.set(key, numbers.size);
          const title = several ? `${port} ${name}` : name;
          const curve = { key, name: title, unit: units.get(port)?.(name) ?? "", times: track.times, values, colour: numbers.get(key)! };
          if (channel.beside) found.set(`${key} beside`, { ...curve, beside: true });
          else found.set(key, curve);
        }
      }
    return [...found.values()];
  };
  const kept = useRef<{ stamp: string; curves: Curve[] }>({ stamp: "", curves: [] });
  const isDifference = system.beside !== "" && store.page.differs;
  const readDifferences = () => {
    const curves = read();
    const stamp = stampOf(curves);
    if (stamp !== kept.current.stamp) kept.current = { stamp, curves: differences(curves) };
    return kept.current.curves;
  };
  const texts = new Map<string, string>();
  for (const channel of channels)
    if (!channel.beside) for (const [path, value] of leaves(store.tracks.get(channel.id)?.value)) if (typeof value !== "number") texts.set(carriedOf({ port: portOf(channel), path }), String(value));
  const take = (carried: string) => {
    const member = memberOf(carried);
    if (member && !(own && member.port === portOf(own))) addMember(id, member);
  };
  const remove = (key: string) => {
    const member = memberOf(key)!;
    const found = added.find((each) => each.port === member.port && (each.path === member.path || each.path === ""));
    return found && (() => removeMember(id, found));
  };
  return (
    <Plot id={id} label={label} read={isDifference ? readDifferences : read} texts={isDifference ? undefined : texts} carried={(key) => key} dropped={take} remove={remove} compared={system.beside !== "" && !isDifference}>
      {children}
    </Plot>
  );
}

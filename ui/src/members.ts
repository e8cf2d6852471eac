/** What plots contain: members of ports, which are added and removed by hand. */

import { useSyncExternalStore } from "react";

/** A member of the samples of a port, or all of them. */
export interface Member {
  /** `INSTANCE.PORT` */
  port: string;
  /** Empty: all members. */
  path: string;
}

/** Kept while the tab is open. */
const KEPT = "rtgen plots";
const SEPARATOR = "\n";

export const carriedOf = ({ port, path }: Member): string => port + SEPARATOR + path;

export function memberOf(carried: string): Member | undefined {
  const [port, path, ...rest] = carried.split(SEPARATOR);
  return port && path !== undefined && !rest.length ? { port, path } : undefined;
}

type Plots = ReadonlyMap<string, readonly Member[]>;

function restored(): Plots {
  try {
    const found: unknown = JSON.parse(sessionStorage.getItem(KEPT) ?? "[]");
    if (!Array.isArray(found)) return new Map();
    return new Map(
      found.flatMap((each: unknown): [string, Member[]][] =>
        Array.isArray(each) && typeof each[0] === "string" && Array.isArray(each[1])
          ? [[each[0], each[1].flatMap((member) => (typeof member === "string" ? (memberOf(member) ?? []) : []))]]
          : [],
      ),
    );
  } catch {
    return new Map(); // without storage, plots are as at first
  }
}

let plots = restored();
const listeners = new Set<() => void>();

function subscribe(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function change(next: Plots): void {
  plots = next;
  try {
    sessionStorage.setItem(KEPT, JSON.stringify([...plots].map(([id, members]) => [id, members.map(carriedOf)])));
  } catch {
    // they are not kept
  }
  for (const listener of listeners) listener();
}

const same = (one: Member) => (other: Member): boolean => carriedOf(one) === carriedOf(other);

/** Members by the plots to which they were added, in the order of the plots. */
export const usePlots = (): Plots => useSyncExternalStore(subscribe, () => plots);

export const plotsNow = (): Plots => plots;

export function addMember(plot: string, member: Member): void {
  const before = plots.get(plot) ?? [];
  if (!before.some(same(member))) change(new Map(plots).set(plot, [...before, member]));
}

export function removeMember(plot: string, member: Member): void {
  change(new Map(plots).set(plot, (plots.get(plot) ?? []).filter((each) => !same(member)(each))));
}

export function addPlot(plot: string): void {
  change(new Map(plots).set(plot, []));
}

export function removePlot(plot: string): void {
  const next = new Map(plots);
  next.delete(plot);
  change(next);
}

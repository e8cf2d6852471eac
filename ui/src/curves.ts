/** Curves of numbers over time: of members of ports, in this run and in the compared one. */

import { t } from "./texts.ts";
import uPlot from "uplot";

/** Curves that are shown at first. */
export const FIRST = 8;

export interface Curve {
  key: string;
  name: string;
  /** Empty without a unit. */
  unit: string;
  times: readonly number[];
  values: readonly number[];
  /** Number of the curve's colour. */
  colour: number;
  /** Whether it belongs to the compared run. */
  beside?: boolean;
}

export const labelOf = ({ name, unit, beside }: Curve): string => `${name}${unit && ` [${unit}]`}${beside ? " (beside)" : ""}`;

/** Something that changes when samples are added to curves. */
export const stampOf = (curves: readonly Curve[]): string =>
  [...new Set(curves.map((each) => each.times))].map((times) => `${times.length} ${times[0]} ${times.at(-1)}`).join() + curves.map((each) => each.key).join();

/** Curves over a common time. */
export function joined(curves: readonly Curve[]): uPlot.AlignedData {
  const tables = [...new Set(curves.map((each) => each.times))].map((times) => curves.filter((each) => each.times === times));
  if (!tables.length) return [[]];
  const aligned = uPlot.join(tables.map((table) => [table[0]!.times as number[], ...table.map((each) => each.values as number[])]));
  const order = tables.flat();
  return [aligned[0], ...curves.map((each) => aligned[1 + order.indexOf(each)]!)];
}

/** The curves of this run less those of the compared one, whose samples hold until the next; from the time when both have one. */
export function differences(curves: readonly Curve[]): Curve[] {
  return curves.flatMap((own) => {
    const other = curves.find((each) => each.beside && each.key === own.key);
    if (own.beside || !other) return [];
    const first = until(own.times, (other.times[0] ?? Infinity) - SAME);
    const times = own.times.slice(first, until(own.times, (other.times.at(-1) ?? -Infinity) + SAME));
    let at = 0;
    const values = times.map((time, i) => {
      while (at + 1 < other.times.length && other.times[at + 1]! <= time + SAME) at++;
      return own.values[first + i]! - other.values[at]!;
    });
    return [{ ...own, name: t("{name}, difference", { name: own.name }), times, values }];
  });
}

/** The number of times before or at a time. */
export function until(times: readonly number[], time: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The value that holds at a time; NaN before the first one. */
export const valueAt = ({ times, values }: Curve, time: number): number => values[until(times, time) - 1] ?? NaN;

/** Times nearer than this are the same [s]. */
const SAME = 1e-9;

export interface Figures {
  least: number;
  most: number;
  mean: number;
  /** The standard deviation. */
  spread: number;
}

/** Sums of binary numbers are as far off, as a part of the greatest one. */
const NOISE = 1e-12;

/** Statistics of a curve in a range of time, in which each sample holds until the next; undefined without any. */
export function figuresOf({ times, values }: Curve, [from, to]: readonly [number, number]): Figures | undefined {
  let [weight, least, most, mean, square] = [0, Infinity, -Infinity, 0, 0];
  for (let i = until(times, from - SAME); i < times.length && times[i]! <= to; i++) {
    const value = values[i]!;
    if (!Number.isFinite(value)) continue;
    [least, most] = [Math.min(least, value), Math.max(most, value)];
    // Of older samples some are left out: without weights, the newest ones would count twice. The sums are those of Welford (1962).
    const held = Math.max(Math.min(times[i + 1] ?? to, to) - times[i]!, SAME);
    const off = value - mean;
    weight += held;
    mean += (off * held) / weight;
    square += held * off * (value - mean);
  }
  if (!weight) return undefined;
  const noise = NOISE * Math.max(Math.abs(least), Math.abs(most));
  const withoutNoise = (value: number) => (Math.abs(value) < noise ? 0 : value);
  return { least, most, mean: withoutNoise(mean), spread: withoutNoise(Math.sqrt(square / weight)) };
}

const quoted = (text: string): string => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** The samples of curves in a range of time as CSV (RFC 4180); a cell is empty where a curve has no sample. */
export function csv(curves: readonly Curve[], [from, to]: readonly [number, number]): string {
  const [times, ...rows] = joined(curves);
  const lines = [["time [s]", ...curves.map(labelOf)].map(quoted).join()];
  for (let i = until(times as number[], from - SAME); i < times.length && times[i]! <= to; i++)
    lines.push([times[i], ...rows.map((row) => (Number.isNaN(row[i]) ? "" : (row[i] ?? "")))].join());
  return lines.map((line) => `${line}\r\n`).join("");
}

/** Units in groups for one picture each, which has an axis on its left and one on its right. */
export function inPictures(units: Iterable<string>): string[][] {
  const all = [...new Set(units)];
  return all.flatMap((_, i) => (i % AXES ? [] : [all.slice(i, i + AXES)]));
}

/** Number of axes of values of a picture. */
const AXES = 2;

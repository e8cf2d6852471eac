/** Plots of numbers over time. */

import { useEffect, useRef } from "react";
import uPlot from "uplot";
import { colour } from "./colours.ts";
import type { Track } from "./store.ts";
import { store } from "./store.ts";

const MAX_CURVES = 8;
/** Number of axes of values of a plot. */
const AXES = 2;
/** Height of a plot [px]. */
const HEIGHT = 180;

/** The duration shown by plots [s]; 0: the whole run. */
const SPANS = [5, 30, 0];

export interface Curves {
  names: string[];
  /** The unit of each curve; empty without one. Each unit has a scale of its own. */
  units: string[];
  data: uPlot.AlignedData;
  /** Number of curves of this run, which come first; the rest, dashed, belong to the compared run. */
  own?: number;
}

/** The curves of a track of samples. */
export function curvesOf(track: Track | undefined, unitOf: (name: string) => string): Curves | undefined {
  if (!track) return undefined;
  const curves = [...track.numbers].filter(([name]) => !/^tm\b/.test(name)).slice(0, MAX_CURVES);
  const names = curves.map(([name]) => name);
  return { names, units: names.map(unitOf), data: [track.times, ...curves.map(([, row]) => row)] };
}

/** The curves of these units. */
export function ofUnits(curves: Curves | undefined, shown: readonly string[]): Curves | undefined {
  if (!curves) return undefined;
  const own = curves.own ?? curves.names.length;
  const kept = curves.units.flatMap((unit, i) => (shown.includes(unit) ? [i] : []));
  const [times, ...rows] = curves.data;
  return {
    names: kept.map((i) => curves.names[i]!),
    units: kept.map((i) => curves.units[i]!),
    data: [times, ...kept.map((i) => rows[i]!)],
    own: kept.filter((i) => i < own).length,
  };
}

/** Units in groups for one plot each, which has an axis on its left and one on its right. */
export function inPlots(units: Iterable<string>): string[][] {
  const all = [...new Set(units)];
  return all.flatMap((_, i) => (i % AXES ? [] : [all.slice(i, i + AXES)]));
}

/** The curves of two runs over a common time; the names of the second run are marked. */
export function overlaid(curves: Curves | undefined, beside: Curves | undefined): Curves | undefined {
  if (!beside) return curves;
  const names = beside.names.map((each) => `${each} (beside)`);
  if (!curves) return { ...beside, names, own: 0 };
  return {
    names: [...curves.names, ...names],
    units: [...curves.units, ...beside.units],
    data: uPlot.join([curves.data, beside.data]),
    own: curves.names.length,
  };
}

/** The key of a unit's scale: no text of a unit is `x`, or a member that all objects have. */
const scaleOf = (unit: string): string => `unit ${unit}`;

function series({ names, units, own = names.length }: Curves): uPlot.Series[] {
  const several = new Set(units).size > 1;
  return names.map((name, i) => ({
    label: several && units[i] ? `${name} [${units[i]}]` : name,
    scale: scaleOf(units[i]!),
    spanGaps: true,
    stroke: colour(i < own ? i : i - own),
    width: 2,
    ...(i >= own && { dash: [5, 4] }),
  }));
}

/** Selects the duration shown by all plots. */
export function Span() {
  return (
    <label>
      Plots show
      <select value={store.page.span} onChange={(e) => store.span(Number(e.target.value))}>
        {SPANS.map((each) => (
          <option key={each} value={each}>
            {each ? `the last ${each} s` : "the run"}
          </option>
        ))}
      </select>
    </label>
  );
}

/** Whether the page is dark; its change creates new plots, whose axes have its colours. */
const dark = matchMedia("(prefers-color-scheme: dark)");

/** Space for the longest label of an axis [px]. */
const space = (_: unknown, labels: readonly string[] | null): number => 20 + 7 * Math.max(4, ...(labels ?? []).map((each) => each.length));

const range = (_: unknown, first: number, last: number): [number, number] => [store.page.span ? Math.max(first, last - store.page.span) : first, last];

/** `read` is called before each drawing; another `source` creates a new plot. */
export function Plot({ source, read, label }: { source: string; read: () => Curves | undefined; label: string }) {
  const place = useRef<HTMLDivElement>(null);
  const reading = useRef(read);
  reading.current = read;
  useEffect(() => {
    let plot: uPlot | undefined;
    let names = "";
    let drawn = "";
    let frame = 0;
    const draw = () => {
      frame = requestAnimationFrame(draw);
      const curves = reading.current();
      if (!curves || !place.current) return;
      const { data } = curves;
      const size = { width: place.current.clientWidth, height: HEIGHT };
      const now = [dark.matches, ...curves.names, ...curves.units].join();
      const stamp = `${store.page.span} ${data.length} ${data[0].length} ${data[0][0]} ${data[0].at(-1)}`;
      if (!plot || now !== names) {
        plot?.destroy();
        names = now;
        const text = getComputedStyle(place.current).color;
        const axis = { stroke: text, grid: { stroke: "#8884", width: 1 }, ticks: { stroke: "#8884" } };
        plot = new uPlot(
          {
            ...size,
            scales: { x: { time: false, range } },
            legend: { live: false, markers: { dash: (_, i) => (i > (curves.own ?? curves.names.length) ? "dashed" : "solid") } },
            axes: [
              { ...axis, size: 30, label: "time [s]", labelSize: 16 },
              ...[...new Set(curves.units)].map((unit, i) => ({
                ...axis,
                scale: scaleOf(unit),
                size: space,
                ...(unit && { label: unit }),
                ...(i > 0 && { side: 1 as const, grid: { show: false } }),
              })),
            ],
            series: [{ label: "t" }, ...series(curves)],
          },
          data,
          place.current,
        );
      } else if (stamp !== drawn) {
        plot.setData(data);
      }
      // Tables beside it, and their scroll bar, may come after the plot.
      if (size.width && size.width !== plot.width) plot.setSize(size);
      drawn = stamp;
    };
    draw();
    return () => {
      cancelAnimationFrame(frame);
      plot?.destroy();
    };
  }, [source]);
  return <div className="plot" ref={place} role="img" aria-label={label} />;
}

/** Plots of numbers over time: pictures, and a table of their curves. */

import { Download, Image, Maximize2, X, ZoomIn, ZoomOut } from "lucide-react";
import type { CSSProperties, DragEvent, MouseEvent, PointerEvent, ReactNode } from "react";
import { useEffect, useMemo, useRef, useState, useSyncExternalStore } from "react";
import uPlot from "uplot";
import { colour } from "./colours.ts";
import type { Curve } from "./curves.ts";
import { FIRST, csv, figuresOf, inPictures, joined, labelOf, stampOf, until, valueAt } from "./curves.ts";
import { IconButton } from "./kit/Button.tsx";
import { Name } from "./kit/Name.tsx";
import { brief } from "./numbers.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";

/** Height of a picture [px]. */
const HEIGHT = 200;
/** The duration shown by plots [s]; 0: the whole run. */
const SPANS = [5, 30, 0];
const ZOOM = 0.5;
/** The shortest time to zoom to [s]. */
const SHORTEST = 1e-6;

/** The time that the cursor of all plots points at. */
class Cursor {
  time: number | undefined;
  /** The picture that the mouse is over, which has the cursor of the mouse. */
  owner: uPlot | undefined;
  private readonly listeners = new Set<() => void>();

  point(time: number | undefined, owner?: uPlot): void {
    if (this.time === time && this.owner === owner) return;
    [this.time, this.owner] = [time, owner];
    for (const listener of this.listeners) listener();
  }

  subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  snapshot = (): number | undefined => this.time;
}

const cursor = new Cursor();

// A finger leaves its cursor behind, until it touches something else.
document.addEventListener("pointerdown", ({ target, pointerType }) => {
  if (pointerType === "touch" && !(target as Element).closest(".plots")) cursor.point(undefined);
});

/** Which curves are shown, by plot and curve; kept while views change. */
const choices = new Map<string, Map<string, boolean>>();

/** The key of a unit's scale: no text of a unit is `x`, or a member that all objects have. */
const scaleOf = (unit: string): string => `unit ${unit}`;

/** Selects the duration shown by all plots, and with a compared run whether they show the difference. */
export function Span({ compared = false }: { compared?: boolean }) {
  const { span, zoom, differs } = store.page;
  return (
    <>
    <label>
      {t("Plots show")}
      <select value={zoom ? "" : span} onChange={(e) => store.span(Number(e.target.value))}>
        {zoom && <option value="">{t("{first} s to {last} s", { first: brief(zoom[0]), last: brief(zoom[1]) })}</option>}
        {SPANS.map((each) => (
          <option key={each} value={each}>
            {each ? t("the last {span} s", { span: each }) : t("the run")}
          </option>
        ))}
      </select>
    </label>
    {compared && (
      <label>
        <input type="checkbox" checked={differs} onChange={(e) => store.differ(e.target.checked)} />
        {t("Difference: this run less the other")}
      </label>
    )}
    </>
  );
}

/** The times that plots show, of those from `first` to `last` [s]. */
function shownTimes(first: number, last: number): [number, number] {
  const { span, zoom } = store.page;
  return zoom ? [...zoom] : [span ? Math.max(first, last - span) : first, last];
}

/** Whether the page is dark; its change creates new plots, whose axes have its colours. */
const dark = matchMedia("(prefers-color-scheme: dark)");

/** Labels of an axis, with as many digits as tell them apart. */
function labels(_: unknown, splits: readonly number[]): string[] {
  const step = Math.abs((splits[1] ?? 1) - (splits[0] ?? 0)) || 1;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const most = Math.max(...splits.map(Math.abs));
  return splits.map((each) => {
    const isZero = Math.abs(each) < step / 1000;
    return isZero ? "0" : digits > 6 || most >= 1e7 ? Number(each.toPrecision(3)).toExponential() : Number(each.toFixed(digits + 2)).toString();
  });
}

/** Space for the longest label of an axis [px]. */
const space = (_: unknown, labels: readonly string[] | null): number => 20 + 7 * Math.max(4, ...(labels ?? []).map((each) => each.length));

/** The range of an axis. `zero`: from 0; a value that does not change is in the middle. */
function shownValues(least: number | null, most: number | null, zero: boolean): uPlot.Range.MinMax {
  if (least === null || most === null) return [null, null];
  if (zero) return [0, 1.1 * most || 1];
  const around = Math.abs(most) / 10 || 1;
  return least === most ? [least - around, most + around] : uPlot.rangeNum(least, most, 0.1, true);
}

function options(curves: readonly Curve[], text: string, size: { width: number; height: number }, zero: boolean): uPlot.Options {
  const units = [...new Set(curves.map((each) => each.unit))];
  const axis = { stroke: text, grid: { stroke: "#8884", width: 1 }, ticks: { stroke: "#8884" } };
  return {
    ...size,
    scales: {
      x: { time: false, range: (_, first, last) => shownTimes(first, last) },
      ...Object.fromEntries(units.map((unit) => [scaleOf(unit), { range: (_: unknown, least: number | null, most: number | null) => shownValues(least, most, zero) }])),
    },
    legend: { show: false },
    cursor: {
      y: false,
      drag: { x: true, y: false, setScale: false },
      bind: { dblclick: () => () => (store.zoom(undefined), null) },
    },
    hooks: {
      setCursor: [
        (plot) => {
          // A plot whose data change also has the cursor that follows that of another one.
          const { left = -1, event } = plot.cursor;
          if (left >= 0 && event && event.type !== "mouseleave") cursor.point(plot.posToVal(left, "x"), plot);
          else if (cursor.owner === plot) cursor.point(undefined);
        },
      ],
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          if (!width) return;
          const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          if (to - from > SHORTEST) store.zoom([from, to]);
        },
      ],
    },
    axes: [
      { ...axis, size: 30, label: t("time [s]"), labelSize: 16 },
      ...units.map((unit, i) => ({
        ...axis,
        scale: scaleOf(unit),
        size: space,
        values: labels,
        ...(unit && { label: unit }),
        ...(i > 0 && { side: 1 as const, grid: { show: false } }),
      })),
    ],
    series: [
      { label: "t" },
      ...curves.map((each) => ({
        label: labelOf(each),
        scale: scaleOf(each.unit),
        spanGaps: true,
        stroke: colour(each.colour),
        width: 2,
        ...(each.beside && { dash: [5, 4] }),
      })),
    ],
  };
}

/** One picture. `read` is called before each drawing; another `source` creates a new one. */
function Picture({ source, read, label, zero, keep }: { source: string; read: () => readonly Curve[]; label: string; zero: boolean; keep: (plot: uPlot | undefined) => void }) {
  const place = useRef<HTMLDivElement>(null);
  const reading = useRef(read);
  reading.current = read;
  const picture = useRef<uPlot>(undefined);
  /** The fingers on the picture, and the times that they have taken hold of. */
  const fingers = useRef(new Map<number, { x: number; time: number }>());
  useEffect(() => {
    let plot: uPlot | undefined;
    let made = "";
    let drawn = "";
    let frame = 0;
    const show = (made: uPlot | undefined) => {
      picture.current = made;
      keep(made);
    };
    const end = () => {
      if (plot && cursor.owner === plot) cursor.point(undefined);
      plot?.destroy();
    };
    const draw = () => {
      frame = requestAnimationFrame(draw);
      const curves = reading.current();
      if (!curves.length || !place.current?.clientWidth) return;
      const size = { width: place.current.clientWidth, height: HEIGHT };
      const now = [dark.matches, ...curves.map((each) => `${labelOf(each)} ${each.colour}`)].join();
      const stamp = `${store.page.span} ${store.page.zoom} ${stampOf(curves)}`;
      if (!plot || now !== made) {
        end();
        made = now;
        plot = new uPlot(options(curves, getComputedStyle(place.current).color, size, zero), joined(curves), place.current);
        show(plot);
      } else if (stamp !== drawn) {
        plot.setData(joined(curves));
      }
      // Tables beside it, and their scroll bar, may come after the plot.
      if (size.width !== plot.width) plot.setSize(size);
      drawn = stamp;
      if (cursor.owner !== plot) {
        const left = cursor.time === undefined ? -10 : Math.round(plot.valToPos(cursor.time, "x"));
        if (left !== plot.cursor.left) plot.setCursor({ left, top: left < 0 ? -10 : 0 }, false);
      }
    };
    draw();
    return () => {
      cancelAnimationFrame(frame);
      end();
      show(undefined);
    };
  }, [source]);
  /** Moves the cursor by samples, zooms around it, and moves what is shown. */
  const press = (key: string, far: boolean): boolean => {
    const [times] = joined(reading.current()) as [number[]];
    const [first, last] = [times[0], times.at(-1)];
    if (first === undefined || last === undefined) return false;
    const [from, to] = shownTimes(first, last);
    const at = cursor.time ?? to;
    const step = key === "ArrowRight" ? 1 : key === "ArrowLeft" ? -1 : 0;
    if (step && far) store.zoom([from + (step * (to - from)) / 4, to + (step * (to - from)) / 4]);
    else if (step) {
      const next = step > 0 ? until(times, at) : until(times, at) - (times[until(times, at) - 1] === at ? 2 : 1);
      cursor.point(Math.min(Math.max(times[Math.min(Math.max(next, 0), times.length - 1)]!, from), to));
    } else if (key === "+") zoomAround(at, from, to, ZOOM);
    else if (key === "-") zoomAround(at, from, to, 1 / ZOOM);
    else if (key === "0") store.zoom(undefined);
    else if (key === "Escape") cursor.point(undefined);
    else return false;
    return true;
  };
  const placeOf = ({ clientX }: { clientX: number }): number => clientX - picture.current!.over.getBoundingClientRect().left;
  const touch = (e: PointerEvent) => {
    if (e.pointerType !== "touch" || !picture.current) return;
    const x = placeOf(e);
    fingers.current.set(e.pointerId, { x, time: picture.current.posToVal(x, "x") });
  };
  /** One finger moves the cursor; two move and stretch what is shown, so that each keeps its time. */
  const drag = (e: PointerEvent) => {
    const [finger, plot] = [fingers.current.get(e.pointerId), picture.current];
    if (!finger || !plot) return;
    const x = placeOf(e);
    const other = [...fingers.current].find(([id]) => id !== e.pointerId)?.[1];
    finger.x = x;
    if (!other) return cursor.point(plot.posToVal(x, "x"));
    cursor.point(undefined);
    const pace = (finger.time - other.time) / (x - other.x);
    const from = other.time - other.x * pace;
    const width = plot.over.clientWidth * pace;
    if (Number.isFinite(from) && width > SHORTEST) store.zoom([from, from + width]);
  };
  /** The mouse events of a tap end with one that takes the cursor away, unless it is not theirs. */
  const tap = (e: MouseEvent) => {
    if ((e.nativeEvent as globalThis.PointerEvent).pointerType === "touch" && picture.current) cursor.point(picture.current.posToVal(placeOf(e), "x"));
  };
  return (
    <div
      className="plot"
      ref={place}
      role="img"
      tabIndex={0}
      aria-label={label}
      title={t("Drag to zoom, double click for all; by touch: one finger moves the cursor, two zoom. Keys: arrows move the cursor, Shift moves the picture, + − 0 zoom")}
      onPointerDown={touch}
      onPointerMove={drag}
      onPointerUp={(e) => fingers.current.delete(e.pointerId)}
      onPointerCancel={(e) => fingers.current.delete(e.pointerId) && cursor.point(undefined)}
      onClick={tap}
      onKeyDown={(e) => {
        if (e.ctrlKey || e.metaKey || e.altKey || !press(e.key, e.shiftKey)) return;
        e.preventDefault();
        e.stopPropagation();
      }}
    />
  );
}

function zoomAround(at: number, from: number, to: number, factor: number): void {
  const middle = Math.min(Math.max(at, from), to);
  if ((to - from) * factor > SHORTEST) store.zoom([middle - (middle - from) * factor, middle + (to - middle) * factor]);
}

/** Gives the user a file. */
function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href));
}

const fileName = (label: string, suffix: string): string => `${label.replace(/[^\w.-]+/g, "_").replace(/^_+|_+$/g, "") || "plot"}.${suffix}`;

const LINE = 18;

/** Pictures below each other, and the names of their curves, as one picture. */
function composed(plots: readonly uPlot[], curves: readonly Curve[], around: Element): HTMLCanvasElement {
  const made = document.createElement("canvas");
  const ratio = window.devicePixelRatio;
  const pictures = plots.map((each) => each.ctx.canvas);
  made.width = Math.max(...pictures.map((each) => each.width));
  made.height = pictures.reduce((sum, each) => sum + each.height, 0) + (curves.length + 0.5) * LINE * ratio;
  const pen = made.getContext("2d")!;
  const { color, backgroundColor } = getComputedStyle(around);
  pen.fillStyle = backgroundColor;
  pen.fillRect(0, 0, made.width, made.height);
  let top = 0;
  for (const each of pictures) {
    pen.drawImage(each, 0, top);
    top += each.height;
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, top);
  pen.font = `12px ${getComputedStyle(around).fontFamily}`;
  curves.forEach((each, i) => {
    pen.fillStyle = colour(each.colour);
    pen.fillRect(8, (i + 0.25) * LINE, 12, 12);
    pen.fillStyle = color;
    pen.fillText(labelOf(each), 28, (i + 0.8) * LINE);
  });
  return made;
}

interface Props {
  /** Identifies the plot while the page is open. */
  id: string;
  label: string;
  /** The curves now; those of the compared run follow the one that they belong to. */
  read: () => readonly Curve[];
  /** The texts of newest values by key, where they are not numbers. */
  texts?: ReadonlyMap<string, string>;
  /** What a row carries when it is dragged, by the key of its curve. */
  carried?: (key: string) => string;
  /** Takes a row that is dropped. */
  dropped?: (carried: string) => void;
  remove?: (key: string) => (() => void) | undefined;
  compared?: boolean;
  /** Whether the axes begin at zero. */
  zero?: boolean;
  children?: ReactNode;
}

/** The kind of what is dragged from a table into a plot. */
export const MEMBER = "application/x-rtgen-member";

export function Plot({ id, label, read, texts, carried, dropped, remove, compared = false, zero = false, children }: Props) {
  const [, choose] = useState(0);
  const plots = useRef(new Map<string, uPlot>());
  const [over, setOver] = useState(false);
  const time = useSyncExternalStore(cursor.subscribe, cursor.snapshot);
  const all = read();
  const own = all.filter((each) => !each.beside);
  const rows = [...own, ...all.filter((each) => each.beside && !own.some((one) => one.key === each.key))];
  const chosen = choices.get(id);
  const isShown = (key: string): boolean => chosen?.get(key) ?? rows.findIndex((each) => each.key === key) < FIRST;
  const shownOf = (curves: readonly Curve[]) => curves.filter((each) => isShown(each.key));
  const shown = shownOf(all);
  const groups = inPictures(shown.map((each) => each.unit));
  const [first, last] = [Math.min(...shown.map((each) => each.times[0] ?? Infinity)), Math.max(...shown.map((each) => each.times.at(-1) ?? -Infinity))];
  const range = shownTimes(first, last);
  const { zoom } = store.page;
  const stamp = `${range} ${stampOf(shown)} ${shown.map((each) => each.values.length)}`;
  const figures = useMemo(() => new Map(shown.filter((each) => !each.beside).map((each) => [each.key, figuresOf(each, range)])), [stamp]);
  const change = (key: string, show: boolean) => {
    choices.set(id, new Map(chosen).set(key, show));
    choose((count) => count + 1);
  };
  const now = (curve: Curve | undefined) => {
    if (!curve) return "";
    if (time === undefined) return (curve.beside ? undefined : texts?.get(curve.key)) ?? brief(curve.values.at(-1) ?? NaN);
    return brief(valueAt(curve, time));
  };
  const drop = dropped && {
    onDragOver: (e: DragEvent) => {
      if (!e.dataTransfer.types.includes(MEMBER)) return;
      e.preventDefault();
      setOver(true);
    },
    onDragLeave: (e: DragEvent) => !e.currentTarget.contains(e.relatedTarget as Node | null) && setOver(false),
    onDrop: (e: DragEvent) => {
      e.preventDefault();
      setOver(false);
      dropped(e.dataTransfer.getData(MEMBER));
    },
  };
  const empty = !shown.some((each) => each.times.length);
  return (
    <div className={`plots ${over ? "over" : ""}`} {...drop}>
      <div className="toolbar">
        <IconButton icon={ZoomIn} look="plain" label={t("Zoom in time")} keys="+" disabled={empty} onClick={() => zoomAround(time ?? range[1], ...range, ZOOM)} />
        <IconButton icon={ZoomOut} look="plain" label={t("Zoom out of time")} keys="-" disabled={empty || !zoom} onClick={() => zoomAround(time ?? range[1], ...range, 1 / ZOOM)} />
        <IconButton icon={Maximize2} look="plain" label={t("Show all times")} keys="0" disabled={!zoom} onClick={() => store.zoom(undefined)} />
        <IconButton icon={Download} look="plain" label={t("Save {label} as CSV", { label })} disabled={empty} onClick={() => download(fileName(id, "csv"), new Blob([csv(shown, range)], { type: "text/csv" }))} />
        <IconButton
          icon={Image}
          look="plain"
          label={t("Save {label} as PNG", { label })}
          disabled={empty}
          onClick={(e) => composed([...plots.current.values()], shown, e.currentTarget.closest(".panel, main") ?? document.body).toBlob((content) => content && download(fileName(id, "png"), content))}
        />
        {children}
        <output aria-label={t("Time at the cursor")}>{time === undefined ? "" : t("at {time} s", { time: brief(time) })}</output>
      </div>
      {groups.map((units, i) => (
        <Picture
          key={i}
          source={id}
          read={() => shownOf(read()).filter((each) => units.includes(each.unit))}
          label={i ? t("{label} in {units}", { label, units: units.filter(Boolean).join(", ") }) : label}
          zero={zero}
          keep={(plot) => (plot ? plots.current.set(String(i), plot) : plots.current.delete(String(i)))}
        />
      ))}
      {rows.length > 0 && (
        <div className="rows curves" tabIndex={0} style={{ "--columns": compared ? 7 : 6 } as CSSProperties}>
          <table aria-label={t("Curves of {label}", { label })}>
            <thead>
              <tr>
                <th scope="col">{t("value")}</th>
                <th scope="col">{time === undefined ? t("now") : t("cursor")}</th>
                {compared && <th scope="col">{t("beside")}</th>}
                <th scope="col">{t("min")}</th>
                <th scope="col">{t("max")}</th>
                <th scope="col">{t("mean")}</th>
                <th scope="col" title={t("Standard deviation")}>σ</th>
                <th scope="col">{t("unit")}</th>
              </tr>
            </thead>
            <tbody>
              {rows.map((curve) => {
                const found = figures.get(curve.key);
                const taken = remove?.(curve.key);
                return (
                  <tr key={curve.key} draggable={carried !== undefined} onDragStart={(e) => carried && e.dataTransfer.setData(MEMBER, carried(curve.key))}>
                    <th scope="row">
                      <label>
                        <input type="checkbox" checked={isShown(curve.key)} onChange={(e) => change(curve.key, e.target.checked)} />
                        <span className="swatch" style={{ background: colour(curve.colour) }} />
                        <span><Name text={curve.name} /></span>
                      </label>
                      {taken && <IconButton icon={X} look="plain" label={t("Remove {name}", { name: curve.name })} onClick={taken} />}
                    </th>
                    <td>{now(curve.beside ? undefined : curve)}</td>
                    {compared && <td>{now(all.find((each) => each.beside && each.key === curve.key))}</td>}
                    {(["least", "most", "mean", "spread"] as const).map((each) => (
                      <td key={each}>{found ? brief(found[each]) : ""}</td>
                    ))}
                    <td className="text">{curve.unit}</td>
                  </tr>
                );
              })}
            </tbody>
          </table>
        </div>
      )}
    </div>
  );
}

/** Poses with their trails, paths, scans and occupancy grids on a map. */

import { Eraser, Maximize2, Ruler, ZoomIn, ZoomOut } from "lucide-react";
import type { PointerEvent as ReactPointerEvent } from "react";
import { useEffect, useMemo, useRef, useState } from "react";
import { colour } from "./colours.ts";
import type { Layer, Measured, View } from "./draw.ts";
import { distance, draw, fitted, metres, round } from "./draw.ts";
import type { Figure, Pose, Reader } from "./figures.ts";
import { placed, reader } from "./figures.ts";
import { Button, IconButton } from "./kit/Button.tsx";
import type { Channel, SystemState } from "./protocol/Ui.ts";
import type { Track } from "./store.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";
import { Trail, isAim } from "./trails.ts";

const LEGEND_EVERY = 200;

interface Shown {
  channel: Channel;
  name: string;
  reader: Reader;
  colour: string;
  /** The pose around which a scan is drawn; undefined: the origin. */
  frame: Channel | undefined;
  /** Whether names say that its poses are to be reached. */
  aim: boolean;
}

const nameOf = ({ port, beside }: Channel): string => beside ? t("{port} (beside)", { port: `${port.instance}.${port.port}` }) : `${port.instance}.${port.port}`;

/** The pose of a scan: received or sent by its component, else by the components connected to its inputs. */
function frameOf(system: SystemState, instance: string, poses: readonly Channel[], seen = new Set<string>()): Channel | undefined {
  if (seen.has(instance)) return undefined;
  seen.add(instance);
  const sources = system.connections.filter((each) => each.target.instance === instance).map((each) => each.source);
  const fed = sources.map(({ instance: owner, port }) => poses.find((each) => each.port.instance === owner && each.port.port === port));
  const found = fed.find(Boolean) ?? poses.find(({ port }) => port.instance === instance);
  if (found) return found;
  for (const source of sources) {
    const before = frameOf(system, source.instance, poses, seen);
    if (before) return before;
  }
  return undefined;
}

function aimOf({ components, connections }: SystemState, { port }: Channel): boolean {
  const owner = components.find((each) => each.instance === port.instance);
  const type = owner?.ports.find((each) => each.name === port.port)?.type ?? "";
  const inPorts = connections.filter(({ source }) => source.instance === port.instance && source.port === port.port).map((each) => each.target.port);
  return isAim(port.port, type, inPorts);
}

/** The channels that can be drawn. */
function drawn(system: SystemState): Shown[] {
  const found = system.channels.flatMap((channel) => {
    const made = channel.type_number < 0 ? undefined : reader(store.types, channel.type_number);
    return made ? [{ channel, reader: made }] : [];
  });
  const poses = found.filter((each) => each.reader.kind === "pose").map((each) => each.channel);
  return found.map((each, i) => ({
    ...each,
    name: nameOf(each.channel),
    colour: colour(i),
    aim: aimOf(system, each.channel),
    frame: each.reader.kind === "scan" ? frameOf(system, each.channel.port.instance, poses.filter((pose) => pose.beside === each.channel.beside)) : undefined,
  }));
}

/** A pose that is watched but not drawn. */
function frameFigure({ id, type_number }: Channel): Figure | undefined {
  const track = store.tracks.get(id);
  return track?.times.length ? reader(store.types, type_number)?.read(track.value) : undefined;
}

/** The figures of the newest samples, and the trails of poses. */
class Scene {
  private readonly seen = new Map<number, { value: unknown; figure: Figure | undefined }>();
  private readonly trails = new Map<number, { track: Track; taken: number; trail: Trail }>();

  private figure({ channel, reader: { read } }: Shown): Figure | undefined {
    const track = store.tracks.get(channel.id);
    // Without: the time was set back, or another system was opened.
    if (!track?.times.length) return undefined;
    const known = this.seen.get(channel.id);
    const figure = known?.value === track.value ? known?.figure : read(track.value);
    this.seen.set(channel.id, { value: track.value, figure });
    return figure;
  }

  private trail({ channel, reader: { read } }: Shown): Trail | undefined {
    const track = store.tracks.get(channel.id);
    if (!track?.times.length) {
      this.trails.delete(channel.id);
      return undefined;
    }
    let known = this.trails.get(channel.id);
    if (known?.track !== track) known = { track, taken: 0, trail: new Trail() };
    this.trails.set(channel.id, known);
    const added = Math.min(track.count - known.taken, track.fresh.length);
    for (let i = track.fresh.length - added; i < track.fresh.length; i++) {
      const figure = read(track.fresh[i]);
      if (figure?.kind === "pose") known.trail.add(track.times[i]!, figure.pose, track.thinned);
    }
    known.taken = track.count;
    return known.trail;
  }

  forget(): void {
    for (const { trail } of this.trails.values()) trail.clear();
  }

  layers(shown: readonly Shown[]): Layer[] {
    const figures = new Map(shown.map((each) => [each.channel.id, this.figure(each)]));
    const framing = (frame: Channel | undefined) => frame && (figures.get(frame.id) ?? frameFigure(frame));
    return shown.map((each) => {
      const { channel, name, colour, frame, aim, reader } = each;
      const figure = figures.get(channel.id);
      const around = framing(frame);
      const eye = around?.kind === "pose" ? around.pose : { x: 0, y: 0, heading: 0 };
      const trail = reader.kind === "pose" ? this.trail(each) : undefined;
      const isGoal = trail !== undefined && (trail.jumps || aim);
      return {
        name,
        label: channel.port.instance.split("/").at(-1)!,
        colour,
        kind: reader.kind !== "pose" ? reader.kind : isGoal ? ("goal" as const) : ("body" as const),
        frame: frame ? nameOf(frame) : t("the origin"),
        pose: figure?.kind === "pose" ? figure.pose : undefined,
        trail: isGoal ? [] : (trail?.parts ?? []),
        path: figure?.kind === "path" ? figure.poses : [],
        points: figure?.kind === "scan" ? figure.points.map((point) => placed(point, eye)) : [],
        eye: figure?.kind === "scan" && frame ? eye : undefined,
        grid: figure?.kind === "grid" ? figure.grid : undefined,
      };
    });
  }
}

/** A number with fixed decimals, without the sign of a rounded zero. */
const fixed = (number: number, decimals: number): string => number.toFixed(decimals).replace(/^-(?=[0.]+$)/, "");
const degrees = (angle: number): string => `${fixed((angle * 180) / Math.PI, 1)}°`;
const place = ({ x, y, heading }: Pose): string => `x ${fixed(x, 3)} m, y ${fixed(y, 3)} m${Number.isNaN(heading) ? "" : `, ${degrees(heading)}`}`;

/** A layer in words. */
function words({ kind, pose, path, points, frame, grid }: Layer): string {
  if (grid) return t("{columns} × {rows} {rows:cell|cells} of {width}", { columns: grid.columns, rows: grid.rows, width: metres(grid.width) });
  if (points.length) return t("{count} {count:point|points} around {frame}", { count: points.length, frame });
  if (pose) return kind === "goal" ? t("goal at {place}", { place: place(pose) }) : place(pose);
  const last = path.at(-1);
  return last ? t("{count} {count:pose|poses} to {place}", { count: path.length, place: place(last) }) : t("no sample yet");
}

const measuredWords = (measured: Measured): string => {
  const { from, to } = measured;
  return `${distance(measured)}, ${degrees(Math.atan2(to.y - from.y, to.x - from.x))}`;
};

const ZOOM = 1.25;
const STEP = 40;
/** The greatest way of a press that is no drag [px]. */
const STILL = 4;

export function MapView({ system, plot }: { system: SystemState; plot: () => void }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const scene = useRef(new Scene());
  const view = useRef<View>(undefined);
  const [free, showFree] = useState(false);
  /** Whether the map has been moved by hand, also before the page is drawn again. */
  const moved = useRef(false);
  const setFree = (is: boolean) => {
    moved.current = is;
    showFree(is);
  };
  const [followed, follow] = useState("");
  const [hidden, hide] = useState<ReadonlySet<string>>(new Set());
  const [legend, setLegend] = useState<{ lines: string[]; scale: string }>({ lines: [], scale: "" });
  const [measuring, measure] = useState(false);
  const [measured, setMeasured] = useState<Measured>();
  const [pointed, point] = useState<Pose>();
  /** Whether the second point of a measurement follows the middle of the map, for the keyboard. */
  const [ranging, range] = useState(false);
  const all = useMemo(() => drawn(system), [system.channels, system.connections]);
  const shown = useMemo(() => all.filter((each) => !hidden.has(each.name)), [all, hidden]);
  const wanted = [...new Set(shown.flatMap((each) => (each.frame ? [each.channel.id, each.frame.id] : [each.channel.id])))].join();
  const pointers = useRef(new Map<number, { x: number; y: number }>());

  useEffect(() => store.watch(wanted ? wanted.split(",").map(Number) : []), [wanted]);

  useEffect(() => {
    let frame = 0;
    let [updated, known] = [0, -1];
    const paint = (now: number) => {
      frame = requestAnimationFrame(paint);
      const area = canvas.current;
      if (!area?.clientWidth) return;
      const layers = scene.current.layers(shown);
      const leader = layers.find((each) => each.name === followed)?.pose;
      if (!view.current || (!moved.current && !leader)) view.current = fitted(layers, area.clientWidth, area.clientHeight);
      if (leader) view.current = { ...view.current, x: leader.x, y: leader.y };
      const { x, y } = view.current;
      const seen = measured && ranging ? { ...measured, to: { x, y, heading: NaN } } : measured;
      draw(area, layers, view.current, seen, measuring && area === document.activeElement);
      const filled = layers.filter(({ grid, pose, points, path }) => grid ?? pose ?? (points.length || path.length)).length;
      if (now - updated < LEGEND_EVERY && filled === known) return;
      [updated, known] = [now, filled];
      setLegend((before) => {
        const lines = layers.map(words);
        const scale = metres(round(110 / (view.current?.scale ?? 1)));
        return before.scale === scale && before.lines.join() === lines.join() ? before : { lines, scale };
      });
    };
    frame = requestAnimationFrame(paint);
    return () => cancelAnimationFrame(frame);
  }, [shown, followed, measuring, measured, ranging]);

  const move = (change: (view: View) => View) => {
    if (!view.current) return;
    view.current = change(view.current);
    setFree(true);
  };
  const worldAt = (e: { clientX: number; clientY: number }): Pose => {
    const { left, top, width, height } = canvas.current!.getBoundingClientRect();
    const { x, y, scale } = view.current!;
    return { x: x + (e.clientX - left - width / 2) / scale, y: y - (e.clientY - top - height / 2) / scale, heading: NaN };
  };
  /** Zooms around a point, else around the middle. */
  const zoom = (factor: number, around?: Pose) =>
    move((seen) => {
      const scale = Math.min(Math.max(seen.scale * factor, 1e-3), 1e5);
      const { x, y } = around ?? seen;
      return { scale, x: x + (seen.x - x) * (seen.scale / scale), y: y + (seen.y - y) * (seen.scale / scale) };
    });
  const pan = (across: number, down: number) => {
    follow("");
    move((seen) => ({ ...seen, x: seen.x - across / seen.scale, y: seen.y + down / seen.scale }));
  };
  const fit = () => {
    follow("");
    setFree(false);
  };
  const middle = (): Pose => ({ x: view.current!.x, y: view.current!.y, heading: NaN });
  const mark = () => {
    if (!ranging) setMeasured({ from: middle(), to: middle() });
    else setMeasured(measured && { ...measured, to: middle() });
    range(!ranging);
  };
  const end = () => {
    measure(false);
    range(false);
    setMeasured(undefined);
  };
  const keys: Record<string, () => void> = {
    "+": () => zoom(ZOOM),
    "-": () => zoom(1 / ZOOM),
    "0": fit,
    ArrowLeft: () => pan(STEP, 0),
    ArrowRight: () => pan(-STEP, 0),
    ArrowUp: () => pan(0, STEP),
    ArrowDown: () => pan(0, -STEP),
    ...(measuring && { Enter: mark, Escape: end }),
  };
  /** Moves the map, measures, or zooms by two fingers. */
  const drag = (e: ReactPointerEvent) => {
    const last = pointers.current.get(e.pointerId);
    point(e.pointerType === "touch" ? undefined : worldAt(e));
    if (!last) return;
    const now = { x: e.clientX, y: e.clientY };
    pointers.current.set(e.pointerId, now);
    const other = [...pointers.current].find(([id]) => id !== e.pointerId)?.[1];
    if (other) {
      const far = (one: { x: number; y: number }) => Math.max(Math.hypot(one.x - other.x, one.y - other.y), STILL);
      zoom(far(now) / far(last), worldAt({ clientX: other.x, clientY: other.y }));
    } else if (measuring) setMeasured((before) => before && { ...before, to: worldAt(e) });
    else pan(now.x - last.x, now.y - last.y);
  };
  const release = (e: ReactPointerEvent) => pointers.current.delete(e.pointerId);
  const turned = useRef<(e: WheelEvent) => void>(() => undefined);
  turned.current = (e) => {
    e.preventDefault();
    zoom(e.deltaY < 0 ? ZOOM : 1 / ZOOM, worldAt(e));
  };
  useEffect(() => {
    const area = canvas.current;
    // Listeners of React cannot keep the panel from scrolling.
    const onWheel = (e: WheelEvent) => turned.current(e);
    area?.addEventListener("wheel", onWheel, { passive: false });
    return () => area?.removeEventListener("wheel", onWheel);
  }, [all.length > 0]);
  const bodies = shown.filter((each) => each.reader.kind === "pose");

  if (!all.length)
    return (
      <>
        <p>{t("No port has poses, paths, scans or grids.")}</p>
        <Button onClick={plot}>{t("Plots of numbers")}</Button>
      </>
    );
  return (
    <section className="map" aria-label={t("Map")}>
      <div className="toolbar">
        <IconButton icon={ZoomIn} look="plain" label={t("Zoom in")} keys="+" onClick={() => zoom(ZOOM)} />
        <IconButton icon={ZoomOut} look="plain" label={t("Zoom out")} keys="-" onClick={() => zoom(1 / ZOOM)} />
        <IconButton icon={Maximize2} look="plain" label={t("Fit")} keys="0" aria-pressed={!free && !followed} onClick={fit} />
        <IconButton icon={Ruler} look="plain" label={t("Measure")} tip={t("Measure: drag, or Enter at both ends")} aria-pressed={measuring} onClick={() => (measuring ? end() : measure(true))} />
        <IconButton icon={Eraser} look="plain" label={t("Clear trails")} onClick={() => scene.current.forget()} />
        <label>
          {t("Follow")}
          <select value={bodies.some((each) => each.name === followed) ? followed : ""} onChange={(e) => follow(e.target.value)}>
            <option value="">{t("nothing")}</option>
            {bodies.map(({ name }) => (
              <option key={name} value={name}>
                {name}
              </option>
            ))}
          </select>
        </label>
      </div>
      <canvas
        ref={canvas}
        role="img"
        tabIndex={0}
        className={measuring ? "measuring" : ""}
        aria-label={t(measuring ? "Map, scale bar {scale}; + and − zoom, arrow keys move, 0 fits, Enter marks an end" : "Map, scale bar {scale}; + and − zoom, arrow keys move, 0 fits", { scale: legend.scale })}
        onKeyDown={(e) => {
          const act = keys[e.key];
          if (!act || e.ctrlKey || e.metaKey || e.altKey) return;
          e.preventDefault();
          act();
        }}
        onPointerDown={(e) => {
          e.currentTarget.setPointerCapture(e.pointerId);
          pointers.current.set(e.pointerId, { x: e.clientX, y: e.clientY });
          if (!measuring) return;
          range(false);
          setMeasured({ from: worldAt(e), to: worldAt(e) });
        }}
        onPointerMove={drag}
        onPointerUp={release}
        onPointerCancel={release}
        onPointerLeave={() => point(undefined)}
      />
      <p className="at">
        <span>{pointed ? place(pointed) : ""}</span>
        <output aria-label={t("Measured")}>{measured ? (ranging ? t("from here to the middle") : measuredWords(measured)) : measuring ? t("drag, or Enter at both ends") : ""}</output>
      </p>
      <ul className="legend" aria-label={t("On the map")}>
        {all.map((each) => {
          const at = shown.indexOf(each);
          return (
            <li key={each.channel.id}>
              <label>
                <input
                  type="checkbox"
                  checked={at >= 0}
                  onChange={() =>
                    hide((before) => {
                      const after = new Set(before);
                      if (!after.delete(each.name)) after.add(each.name);
                      return after;
                    })
                  }
                />
                <span className="swatch" style={{ background: each.colour }} />
                {each.name}
              </label>
              <output aria-label={t("{name} on the map", { name: each.name })}>{at >= 0 ? legend.lines[at] : t("hidden")}</output>
            </li>
          );
        })}
      </ul>
    </section>
  );
}

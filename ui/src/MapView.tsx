/** Poses with their trails, paths, scans and occupancy grids on a map. */

import { useEffect, useMemo, useRef, useState } from "react";
import { colour } from "./colours.ts";
import type { Layer, View } from "./draw.ts";
import { draw, fitted, metres, round } from "./draw.ts";
import type { Figure, Pose, Reader } from "./figures.ts";
import { placed, reader } from "./figures.ts";
import type { Channel, SystemState } from "./protocol/Ui.ts";
import type { Track } from "./store.ts";
import { store } from "./store.ts";

const MAX_TRAIL_LENGTH = 5000;
/** Minimum distance between points of a trail [m]. */
const NEAREST = 0.005;
const LEGEND_EVERY = 200;

interface Shown {
  channel: Channel;
  name: string;
  reader: Reader;
  colour: string;
  /** The pose around which a scan is drawn; undefined: the origin. */
  frame: Channel | undefined;
}

const nameOf = ({ port, beside }: Channel): string => `${port.instance}.${port.port}${beside ? " (beside)" : ""}`;

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
  private readonly trails = new Map<number, Pose[]>();
  private readonly tracks = new Map<number, Track>();

  private figure({ channel, reader: { kind, read } }: Shown): Figure | undefined {
    const track = store.tracks.get(channel.id);
    if (!track?.times.length) {
      // The time was set back, or another system was opened.
      this.seen.delete(channel.id);
      this.trails.delete(channel.id);
      return undefined;
    }
    if (this.tracks.get(channel.id) !== track) {
      this.tracks.set(channel.id, track);
      this.trails.delete(channel.id);
    }
    for (const value of track.fresh.splice(0)) {
      const passed = kind === "pose" ? read(value) : undefined;
      if (passed?.kind === "pose") this.extend(channel.id, passed.pose);
    }
    const known = this.seen.get(channel.id);
    const figure = known?.value === track.value ? known?.figure : read(track.value);
    this.seen.set(channel.id, { value: track.value, figure });
    // Cleared trails restart at the current pose.
    if (figure?.kind === "pose" && !this.trails.has(channel.id)) this.extend(channel.id, figure.pose);
    return figure;
  }

  private extend(channel: number, pose: Pose): void {
    const trail = this.trails.get(channel) ?? [];
    this.trails.set(channel, trail);
    const last = trail.at(-2);
    if (last && Math.hypot(pose.x - last.x, pose.y - last.y) < NEAREST) trail.pop();
    trail.push(pose);
    if (trail.length > MAX_TRAIL_LENGTH) trail.splice(0, trail.length - MAX_TRAIL_LENGTH);
  }

  forget(): void {
    this.trails.clear();
    this.seen.clear();
    this.tracks.clear();
  }

  layers(shown: readonly Shown[]): Layer[] {
    const figures = new Map(shown.map((each) => [each.channel.id, this.figure(each)]));
    const framing = (frame: Channel | undefined) => frame && (figures.get(frame.id) ?? frameFigure(frame));
    return shown.map(({ channel, name, colour, frame }) => {
      const figure = figures.get(channel.id);
      const around = framing(frame);
      const pose = around?.kind === "pose" ? around.pose : { x: 0, y: 0, heading: 0 };
      return {
        name,
        colour,
        frame: frame ? nameOf(frame) : "the origin",
        trail: figure?.kind === "pose",
        poses: figure?.kind === "pose" ? (this.trails.get(channel.id) ?? []) : figure?.kind === "path" ? figure.poses : [],
        points: figure?.kind === "scan" ? figure.points.map((each) => placed(each, pose)) : [],
        grid: figure?.kind === "grid" ? figure.grid : undefined,
      };
    });
  }
}

/** A number with fixed decimals, without the sign of a rounded zero. */
const fixed = (number: number, decimals: number): string => number.toFixed(decimals).replace(/^-(?=[0.]+$)/, "");
const degrees = (angle: number): string => `${fixed((angle * 180) / Math.PI, 1)}°`;

/** A layer in words. */
function words(layer: Layer): string {
  const last = layer.poses.at(-1);
  if (layer.grid) {
    const { columns, rows, width } = layer.grid;
    return `${columns} × ${rows} cells of ${metres(width)}`;
  }
  if (layer.points.length) return `${layer.points.length} points around ${layer.frame}`;
  if (!last) return "no sample yet";
  const heading = Number.isNaN(last.heading) ? "" : `, ${degrees(last.heading)}`;
  const where = `x ${fixed(last.x, 3)} m, y ${fixed(last.y, 3)} m${heading}`;
  return layer.trail ? where : `${layer.poses.length} poses to ${where}`;
}

const ZOOM = 1.25;
const STEP = 40;

export function MapView({ system }: { system: SystemState }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const scene = useRef(new Scene());
  const view = useRef<View>(undefined);
  const [free, setFree] = useState(false);
  const [hidden, hide] = useState<ReadonlySet<string>>(new Set());
  const [legend, setLegend] = useState<{ lines: string[]; scale: string }>({ lines: [], scale: "" });
  const all = useMemo(() => drawn(system), [system.channels, system.connections]);
  const shown = useMemo(() => all.filter((each) => !hidden.has(each.name)), [all, hidden]);
  const wanted = [...new Set(shown.flatMap((each) => (each.frame ? [each.channel.id, each.frame.id] : [each.channel.id])))].join();

  useEffect(() => store.watch(wanted ? wanted.split(",").map(Number) : []), [wanted]);

  useEffect(() => {
    let frame = 0;
    let updated = 0;
    const paint = (now: number) => {
      frame = requestAnimationFrame(paint);
      const place = canvas.current;
      if (!place?.clientWidth) return;
      const layers = scene.current.layers(shown);
      if (!free || !view.current) view.current = fitted(layers, place.clientWidth, place.clientHeight);
      draw(place, layers, view.current);
      if (now - updated < LEGEND_EVERY) return;
      updated = now;
      setLegend((before) => {
        const lines = layers.map(words);
        const scale = metres(round(110 / (view.current?.scale ?? 1)));
        return before.scale === scale && before.lines.join() === lines.join() ? before : { lines, scale };
      });
    };
    frame = requestAnimationFrame(paint);
    return () => cancelAnimationFrame(frame);
  }, [shown, free]);

  const move = (change: (view: View) => View) => {
    if (!view.current) return;
    view.current = change(view.current);
    setFree(true);
  };
  const zoom = (factor: number) => move((seen) => ({ ...seen, scale: Math.min(Math.max(seen.scale * factor, 1e-3), 1e5) }));
  const pan = (across: number, down: number) => move((seen) => ({ ...seen, x: seen.x - across / seen.scale, y: seen.y + down / seen.scale }));
  const keys: Record<string, () => void> = {
    "+": () => zoom(ZOOM),
    "-": () => zoom(1 / ZOOM),
    "0": () => setFree(false),
    ArrowLeft: () => pan(STEP, 0),
    ArrowRight: () => pan(-STEP, 0),
    ArrowUp: () => pan(0, STEP),
    ArrowDown: () => pan(0, -STEP),
  };

  if (!all.length) return <p>No port has poses, paths, scans or grids.</p>;
  return (
    <section className="map" aria-label="Map">
      <div className="buttons">
        <button type="button" aria-label="Zoom in" onClick={() => zoom(ZOOM)}>
          +
        </button>
        <button type="button" aria-label="Zoom out" onClick={() => zoom(1 / ZOOM)}>
          −
        </button>
        <button type="button" aria-pressed={!free} onClick={() => setFree(false)}>
          Fit
        </button>
        <button type="button" onClick={() => scene.current.forget()}>
          Clear trails
        </button>
      </div>
      <canvas
        ref={canvas}
        role="img"
        tabIndex={0}
        aria-label={`Map, scale bar ${legend.scale}; + and − zoom, arrow keys move, 0 fits`}
        onKeyDown={(e) => {
          const act = keys[e.key];
          if (!act) return;
          e.preventDefault();
          act();
        }}
        onWheel={(e) => zoom(e.deltaY < 0 ? ZOOM : 1 / ZOOM)}
        onPointerDown={(e) => e.currentTarget.setPointerCapture(e.pointerId)}
        onPointerMove={(e) => e.buttons && pan(e.movementX, e.movementY)}
      />
      <ul className="legend" aria-label="On the map">
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
              <output aria-label={`${each.name} on the map`}>{at >= 0 ? legend.lines[at] : "hidden"}</output>
            </li>
          );
        })}
      </ul>
    </section>
  );
}

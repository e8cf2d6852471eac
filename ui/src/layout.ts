/** Layout of the wiring: sizes and places of boxes, routes of connections (layered algorithm of ELK). */

import type { ElkNode, ElkPort } from "elkjs/lib/elk-api.js";
import { layoutWorker } from "./early.ts";
import type { Answer, Asked, Placed } from "./elk.ts";
import type { Line } from "./lines.ts";
import type { Component, Connection, Location, Port } from "./protocol/Ui.ts";
import { CLEAR, isClear } from "./routes.ts";
import type { Rectangle } from "./routes.ts";
import { t } from "./texts.ts";
import { token } from "./token.ts";

const HEADER = 46;
/** A port has its name, and below it its type. */
const ROW = 30;
const END = 9;
/** Space for state, rate and overruns. */
const NARROWEST = 180;
/** Longer labels are cut; their titles are complete. */
export const WIDEST = 320;
/** Total margin of a label in a box. */
const PADDING = 24;
/** Scale of places by RT System Editor, whose boxes are narrower. */
const SPREAD = 1.5;
const MARGIN = 16;
/** Space for the buttons of the view: at its left, or below a narrow one. */
const LEFT = 52;
const BELOW = 72;
/** Size of a node of a bus [px]. */
export const NODE = { width: NARROWEST, height: 40 };
/** Gaps between boxes and a bus, two boxes on a bus, two buses. */
const GAP = 24;

export type Point = { x: number; y: number };

export interface Arrangement {
  places: ReadonlyMap<string, Point>;
  /** The corners of each connection, including its ends. */
  routes: ReadonlyMap<string, readonly Point[]>;
  /** Extent of all boxes and connections, from 0. */
  end: Point;
}

/** A bus below the boxes, with the middle of each of its nodes from its left end. */
export interface Rail {
  at: Point;
  width: number;
  middles: readonly number[];
}

/** The distance between a line to a bus and its box, or a box beside it [px]. */
export const BESIDE = 10;

/** Where a line goes down to a bus, from the lower edge of a box that others may be below: past them, beside the lines of other nodes. */
export function descent(from: Point, bottom: number, boxes: readonly Rectangle[], node: number): number {
  const below = boxes.filter((each) => each.y >= from.y && each.y < bottom);
  const isFree = (x: number) => !below.some((each) => x > each.x - CLEAR && x < each.x + each.width + CLEAR);
  const isReached = (x: number) => isClear(boxes, [{ x: from.x, y: from.y + BESIDE }, { x, y: from.y + BESIDE }]);
  const away = BESIDE + 3 * node;
  const ways = [from.x, ...below.flatMap((each) => [each.x - away, each.x + each.width + away])].filter((x) => isFree(x) && isReached(x));
  return ways.sort((a, b) => Math.abs(a - from.x) - Math.abs(b - from.x))[0] ?? from.x;
}

/** The components without connections, which are placed at their bus. */
export function hung(components: readonly Component[], connections: readonly Connection[], lines: readonly Line[]): ReadonlySet<string> {
  const joined = new Set(connections.flatMap((each) => [each.source.instance, each.target.instance]));
  const onBus = new Set(lines.flatMap((line) => line.nodes.flatMap((node) => [...node.proxies, ...node.devices])));
  return new Set(components.map((each) => each.instance).filter((each) => onBus.has(each) && !joined.has(each)));
}

const total = (lengths: readonly number[]): number => lengths.reduce((sum, each) => sum + each + GAP, -GAP);
const tallest = (row: readonly Component[]): number => Math.max(0, ...row.map((each) => size(each).height + GAP));

/** The height of buses with the components placed at them. */
export function height(lines: readonly Line[], free: ReadonlyMap<string, Component>): number {
  const of = (instances: readonly string[]) => tallest(instances.flatMap((each) => free.get(each) ?? []));
  return lines.reduce((sum, line) => sum + NODE.height + 2 * GAP + of(line.nodes.flatMap((each) => each.proxies)) + of(line.nodes.flatMap((each) => each.devices)), 0);
}

/** Places buses below the boxes within two corners: nodes below their proxies if possible, components without connections at their nodes. */
export function rails(lines: readonly Line[], boxes: readonly (Point & { component: Component })[], [start, end]: [Point, Point], free: ReadonlyMap<string, Component>): { rails: Rail[]; places: Map<string, Point>; end: Point } {
  const places = new Map<string, Point>();
  const found: Rail[] = [];
  let [right, y] = [end.x, end.y];
  for (const line of lines) {
    const slots = line.nodes.map((node) => {
      const middles = boxes.filter(({ component }) => [...node.proxies, ...node.devices].includes(component.instance)).map((each) => each.x + width(each.component) / 2);
      const [above, below] = [node.proxies, node.devices].map((row) => row.flatMap((each) => free.get(each) ?? [])) as [Component[], Component[]];
      const wide = Math.max(NODE.width, total(above.map(width)), total(below.map(width)));
      return { above, below, wide, wanted: middles.length ? total(middles.map((each) => each - GAP)) / middles.length - wide / 2 : Infinity, x: 0 };
    });
    const order = [...slots].sort((a, b) => a.wanted - b.wanted || 0);
    let x = start.x;
    for (const slot of order) {
      slot.x = Number.isFinite(slot.wanted) ? Math.max(x, slot.wanted) : x;
      x = slot.x + slot.wide + GAP;
    }
    // Items too far to the right move left as far as possible.
    let last = Math.max(end.x, start.x + total(order.map((each) => each.wide)));
    right = Math.max(right, last);
    for (const slot of order.reverse()) {
      slot.x = Math.min(slot.x, last - slot.wide);
      last = slot.x - GAP;
    }
    const top = y + GAP;
    const at = top + Math.max(...slots.map((each) => tallest(each.above)), 0) + GAP;
    const bottom = at + NODE.height + GAP;
    const stand = (row: readonly Component[], { x, wide }: { x: number; wide: number }, level: (component: Component) => number) => {
      let left = x + (wide - total(row.map(width))) / 2;
      for (const each of row) {
        places.set(each.instance, { x: left, y: level(each) });
        left += width(each) + GAP;
      }
    };
    for (const slot of slots) {
      stand(slot.above, slot, (each) => at - 2 * GAP - size(each).height);
      stand(slot.below, slot, () => bottom);
    }
    found.push({ at: { x: start.x, y: at }, width: 0, middles: slots.map((each) => each.x + each.wide / 2 - start.x) });
    y = bottom - GAP + Math.max(...slots.map((each) => tallest(each.below)), 0);
  }
  return { rails: found.map((each) => ({ ...each, width: right - start.x })), places, end: { x: right, y } };
}

export const shown = ({ x, y }: Location): Location => ({ x: x * SPREAD, y });
export const stored = ({ x, y }: Location): Location => ({ x: x / SPREAD, y });

const ports = (component: Component, kind: Port["kind"]) => component.ports.filter((port) => port.kind === kind);

const canvas = document.createElement("canvas").getContext("2d")!;
const lengths = new Map<string, number>();

function drawn(text: string, font: string): number {
  const key = `${font} ${text}`;
  if (!lengths.has(key)) {
    canvas.font = `${font} ${getComputedStyle(document.documentElement).fontFamily}`;
    lengths.set(key, canvas.measureText(text).width);
  }
  return lengths.get(key)!;
}

const length = (text: string, font: string): number => Math.min(drawn(text, font) + PADDING, WIDEST);

/** At this size, rounded widths of letters matter little [px]. */
const PRECISE = 60;

/** The width of bold words of which each stays in one line, as a multiple of the size of their letters. */
export const widest = (words: readonly string[]): number => Math.max(1, ...words.map((each) => drawn(each, `bold ${PRECISE}px`) / PRECISE));

/** The title of a box: for a component of another process, the name without its place. */
export const title = ({ place, instance }: Component): string => (instance.startsWith(`${place}/`) ? instance.slice(place.length + 1) : instance);

const sizes = new WeakMap<Component, { width: number; height: number }>();

/** Size of a box for its labels. */
export const width = (component: Component): number => size(component).width;

function needed(component: Component): number {
  const longest = (kind: Port["kind"]) => Math.max(0, ...ports(component, kind).map((port) => Math.max(length(port.name, "12px"), length(typeOf(port), "10px"))));
  const widths = [NARROWEST, length(title(component), "bold 12px"), longest("PORT_IN") + longest("PORT_OUT"), longest("PORT_SERVICE")];
  return Math.ceil(Math.max(...widths));
}

export function size(component: Component): { width: number; height: number } {
  const known = sizes.get(component);
  if (known) return known;
  const rows = Math.max(ports(component, "PORT_IN").length, ports(component, "PORT_OUT").length) + ports(component, "PORT_SERVICE").length;
  const found = { width: needed(component), height: HEADER + ROW * rows + END };
  sizes.set(component, found);
  return found;
}

/** The end of a wire at a port, relative to its box. */
export function portPlace(component: Component, name: string, right: boolean): Point | undefined {
  const [ins, outs, services] = [ports(component, "PORT_IN"), ports(component, "PORT_OUT"), ports(component, "PORT_SERVICE")];
  const find = (list: readonly Port[]) => list.findIndex((each) => each.name === name);
  const row = right ? find(outs) : find(ins);
  const service = find(services);
  const at = row >= 0 ? row : service >= 0 ? Math.max(ins.length, outs.length) + service : undefined;
  return at === undefined ? undefined : { x: right ? size(component).width : 0, y: HEADER + ROW * (at + 0.5) };
}

/** The last part of the name of a type, and of the interfaces of a service port. */
export function typeOf(port: Port): string {
  const last = (name: string) => name.replace(/^IDL:(.*):[\d.]+$/, "$1").split(/::|\//).at(-1) ?? name;
  return port.kind === "PORT_SERVICE" ? port.interfaces.map((each) => last(each.type)).join(", ") : last(port.type);
}

// Names may contain any character.
const entry = (instance: string, port: string) => JSON.stringify(["in", instance, port]);
const exit = (instance: string, port: string) => JSON.stringify(["out", instance, port]);

function ends(component: Component): ElkPort[] {
  const { width } = size(component);
  const [ins, outs, services] = [ports(component, "PORT_IN"), ports(component, "PORT_OUT"), ports(component, "PORT_SERVICE")];
  const at = (row: number, right: boolean, port: Port): ElkPort => ({
    id: (right ? exit : entry)(component.instance, port.name),
    x: right ? width : 0,
    y: HEADER + ROW * (row + 0.5),
    layoutOptions: { "elk.port.side": right ? "EAST" : "WEST" },
  });
  const below = Math.max(ins.length, outs.length);
  return [
    ...ins.map((port, i) => at(i, false, port)),
    ...outs.map((port, i) => at(i, true, port)),
    ...services.flatMap((port, i) => [at(below + i, false, port), at(below + i, true, port)]),
  ];
}

/** The zoom at which boxes fit a view whose buttons are at its left, or in a narrow one at its bottom. */
const zoom = (across: number, down: number, wide: number, high: number, narrow = false): number =>
  narrow ? Math.min((wide - MARGIN) / across, (high - BELOW - MARGIN / 2) / down) : Math.min((wide - LEFT - MARGIN) / across, (high - 2 * MARGIN) / down);

/** A layout of proportions that differ more from those of its view wastes space, so that others are tried. */
const SKEWED = 1.6;

/** The layout with the largest zoom in a view, above the space for buses. */
export async function arrange(components: readonly Component[], connections: readonly Connection[], wide: number, high: number, buses: number, by: Grouping): Promise<Arrangement> {
  const all = await proportioned(components, connections, wide / Math.max(high, 1), by);
  const aspect = wide / Math.max(high, 1);
  const skew = all.end.x / Math.max(all.end.y, 1) / aspect;
  if (!buses && Math.max(skew, 1 / skew) < SKEWED) return all;
  if (!buses) {
    let best = all;
    for (const each of [aspect / skew, aspect / Math.sqrt(skew)]) {
      const other = await proportioned(components, connections, each, by);
      if (zoom(other.end.x, other.end.y, wide, high) > zoom(best.end.x, best.end.y, wide, high)) best = other;
    }
    return best;
  }
  const wider = await proportioned(components, connections, wide / Math.max(high - buses, high / 2, 1), by);
  const [first, second] = [all, wider].map(({ end }) => zoom(end.x, end.y + buses, wide, high)) as [number, number];
  return second > first ? wider : all;
}

/** What boxes are grouped by, if at all. */
export type Grouping = "" | "process" | "host";

/** The space of a group around its boxes, above them for its name. */
const FRAME = { side: 16, top: 36 };

/** The group of a component: its naming context, or its host; empty for this process. */
export function groupOf({ place }: Component, by: Grouping): string {
  if (by !== "host") return by && place;
  return /^.*?\.host_cxt(?=\/|$)/.exec(place)?.[0] ?? place.split("/")[0]!;
}

export interface Frame extends Point {
  name: string;
  width: number;
  height: number;
}

/** The frames around the boxes of each group; none if there is one group only. */
export function frames(boxes: readonly (Point & { component: Component })[], by: Grouping): Frame[] {
  const groups = new Map<string, (Point & { component: Component })[]>();
  for (const each of boxes) groups.set(groupOf(each.component, by), [...(groups.get(groupOf(each.component, by)) ?? []), each]);
  if (!by || groups.size < 2) return [];
  return [...groups].map(([name, members]) => {
    const [start, end] = around(members);
    const { side, top } = FRAME;
    return { name: name || t("this process"), x: start.x - side, y: start.y - top, width: end.x - start.x + 2 * side, height: end.y - start.y + side + top };
  });
}

/** The boxes of each group within a node of its own, if there are several. */
function nested(boxes: (ElkNode & { group: string })[]): { children: ElkNode[]; isNested: boolean } {
  const groups = [...new Set(boxes.map((each) => each.group))];
  if (groups.length < 2) return { children: boxes, isNested: false };
  const { side, top } = FRAME;
  const padding = `[top=${top},left=${side},bottom=${side},right=${side}]`;
  const children = groups.map((group, i) => ({ id: `group ${i}`, children: boxes.filter((each) => each.group === group), layoutOptions: { "elk.padding": padding } }));
  return { children, isNested: true };
}

let engine: Engine | undefined;
type Engine = { layout: (graph: ElkNode) => Promise<Placed> };

/** The layout in a worker, so that it loads while the page does, and the page goes on while it places boxes. */
export function layouter(): Engine {
  if (engine) return engine;
  let fail: (reason: Error) => void;
  const failed = new Promise<never>((_, reject) => (fail = reject));
  failed.catch(() => (engine = undefined));
  const worker = layoutWorker();
  worker.onerror = (e) => {
    worker.terminate();
    fail(new Error(e.message || t("its worker has ended")));
  };
  const answered = (graph: ElkNode) =>
    new Promise<Placed>((resolve, reject) => {
      const { port1, port2 } = new MessageChannel();
      port1.onmessage = ({ data }: MessageEvent<Answer>) => {
        port1.close();
        if ("placed" in data) resolve(data.placed);
        else reject(new Error(data.error));
      };
      worker.postMessage({ graph, token: token() } satisfies Asked, [port2]);
    });
  return (engine = { layout: (graph) => Promise.race([answered(graph), failed]) });
}

/** Connections above which the layout tries one order of the boxes, and breaks circles where the file does: half the time, and fewer crossings. */
const MANY = 100;

/** Layout in the proportion of a view; a chain that is too long is folded. */
async function proportioned(components: readonly Component[], connections: readonly Connection[], aspect: number, by: Grouping): Promise<Arrangement> {
  const known = new Set(components.map((each) => each.instance));
  const { children, isNested } = nested(
    components.map((each) => ({
      id: each.instance,
      ...size(each),
      layoutOptions: { "elk.portConstraints": "FIXED_POS" },
      ports: ends(each),
      group: groupOf(each, by),
    })),
  );
  const graph: ElkNode = {
    id: "system",
    layoutOptions: {
      "elk.algorithm": "layered",
      "elk.direction": "RIGHT",
      "elk.edgeRouting": "ORTHOGONAL",
      "elk.aspectRatio": String(aspect),
      ...(connections.length > MANY && { "elk.layered.thoroughness": "1", "elk.layered.cycleBreaking.strategy": "GREEDY_MODEL_ORDER" }),
      "elk.spacing.nodeNode": "24",
      "elk.layered.spacing.nodeNodeBetweenLayers": "30",
      ...(isNested ? { "elk.hierarchyHandling": "INCLUDE_CHILDREN" } : { "elk.layered.wrapping.strategy": "MULTI_EDGE" }),
    },
    children,
    edges: connections
      .filter((each) => known.has(each.source.instance) && known.has(each.target.instance))
      .map((each) => ({
        id: each.name,
        sources: [exit(each.source.instance, each.source.port)],
        targets: [entry(each.target.instance, each.target.port)],
      })),
  };
  const { width, height, boxes, wires } = await layouter().layout(graph);
  return {
    places: new Map(boxes.map(([name, x, y]) => [name, { x, y }])),
    routes: new Map(wires.map(([name, corners]) => [name, corners.map(([x, y]) => ({ x, y }))])),
    end: { x: width, y: height },
  };
}

/** The bounding box of boxes. */
export function around(boxes: readonly (Point & { component: Component })[]): [Point, Point] {
  const sized = boxes.map((each) => ({ ...each, ...size(each.component) }));
  return [
    { x: Math.min(...sized.map((each) => each.x)), y: Math.min(...sized.map((each) => each.y)) },
    { x: Math.max(...sized.map((each) => each.x + each.width)), y: Math.max(...sized.map((each) => each.y + each.height)) },
  ];
}

/** A view of everything within two corners. `narrow`: of a page whose buttons are below. */
export function view([start, end]: [Point, Point], wide: number, high: number, narrow: boolean): Point & { zoom: number } {
  const [across, down] = [end.x - start.x, end.y - start.y];
  const scale = Math.min(1, Math.max(0, zoom(across, down, wide, high, narrow)));
  return {
    x: Math.max(narrow ? MARGIN / 2 : LEFT, (wide - across * scale) / 2) - start.x * scale,
    y: Math.max(narrow ? MARGIN / 2 : MARGIN, (high - down * scale - (narrow ? BELOW : 0)) / 2) - start.y * scale,
    zoom: scale,
  };
}

/** A line through rounded corners. */
export function line(points: readonly Point[]): string {
  const towards = (from: Point, to: Point): string => {
    const distance = Math.hypot(to.x - from.x, to.y - from.y);
    const part = distance ? Math.min(6, distance / 2) / distance : 0;
    return `${from.x + (to.x - from.x) * part},${from.y + (to.y - from.y) * part}`;
  };
  return points
    .map((point, i) => {
      const [before, after] = [points[i - 1], points[i + 1]];
      if (!before) return `M${point.x},${point.y}`;
      return after ? `L${towards(point, before)} Q${point.x},${point.y} ${towards(point, after)}` : `L${point.x},${point.y}`;
    })
    .join(" ");
}

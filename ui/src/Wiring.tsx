/** The graph of components and connections, changed by mouse and by keyboard. */

import { Background, BaseEdge, ControlButton, Controls, EdgeLabelRenderer, Handle, MiniMap, Position, ReactFlow, getSmoothStepPath, useNodesState, useStore } from "@xyflow/react";
import { Group, LayoutGrid, Map as MapIcon, Maximize, Plus } from "lucide-react";
import type { Connection as Drawn, Edge, EdgeProps, Node, NodeProps, ReactFlowInstance } from "@xyflow/react";
import type { CSSProperties, RefObject } from "react";
import { memo, useCallback, useContext, useEffect, useLayoutEffect, useMemo, useRef, useState, useSyncExternalStore } from "react";
import { BusLine } from "./BusLine.tsx";
import type { BusNode, Drop } from "./BusLine.tsx";
import { Button } from "./kit/Button.tsx";
import { WIDEST, around, arrange, descent, frames, height, hung, line, portPlace, rails, shown, size, stored, title, typeOf, view, widest, width } from "./layout.ts";
import type { Arrangement, Grouping, Point } from "./layout.ts";
import { linesOf } from "./lines.ts";
import { Name, partsOf } from "./kit/Name.tsx";
import { Inspecting } from "./Inspector.tsx";
import type { Subject } from "./Inspector.tsx";
import { Menu } from "./Menu.tsx";
import type { Item, Place } from "./Menu.tsx";
import { DRAGGED } from "./Palette.tsx";
import { Taken, isClear, route } from "./routes.ts";
import type { Bus, Component, Connection, Fit, PlannedEvent, Port, PortAddress } from "./protocol/Ui.ts";
import type { Misfit } from "./Purpose.tsx";
import { Purpose } from "./Purpose.tsx";
import { stateClass, stateOf, store } from "./store.ts";
import { t } from "./texts.ts";
import type { Unfit } from "./Unfit.tsx";
import { UnfitCard, ordered, sentence } from "./Unfit.tsx";
import type { View } from "./views.ts";
import { ROOM, useWidth } from "./width.ts";

interface BoxData extends Record<string, unknown> {
  component: Component;
  fits: ReadonlyMap<string, Fit> | undefined;
  /** The names of the ports with connections, and the sides of each that have them. */
  joined: ReadonlySet<string>;
}

type Box = Node<BoxData, "component">;
type Shown = Box | BusNode | GroupNode;

/** React Flow puts ids into selectors, so names with any characters are escaped. */
const idOf = encodeURIComponent;
const nameOf = decodeURIComponent;
const byInstance = (components: readonly Component[]): Map<string, Component> => new Map(components.map((each) => [each.instance, each]));
const portOf = (node: string | null, handle: string | null | undefined): PortAddress => ({ instance: nameOf(node ?? ""), port: nameOf(handle ?? "") });
const address = ({ instance, port }: PortAddress): string => JSON.stringify([instance, port]);

/** A side of a port, in a set of names of ports. */
const sideOf = (port: string, right: boolean): string => `${port}\0${right ? "right" : "left"}`;

/** A hue for each type, the same on each page. */
export function hue(type: string): number {
  let sum = 0;
  for (const character of type) sum = (sum * 31 + character.charCodeAt(0)) % 360;
  return sum;
}

/** The colour of a type, with a contrast above 3 on light and on dark paper (WCAG 2.2, 1.4.11). */
const ink = (type: string): string => `oklch(58% 0.15 ${hue(type)})`;

const REACH = <i className="reach" />;

function PortRow({ component, port, fits, joined }: { component: Component; port: Port; fits: BoxData["fits"]; joined: BoxData["joined"] }) {
  const inspect = useContext(Inspecting);
  const service = port.kind === "PORT_SERVICE";
  const kind = service ? "service" : port.kind === "PORT_IN" ? "in" : "out";
  const refused = fits?.get(address({ instance: component.instance, port: port.name }))?.refused;
  const type = service ? port.interfaces.map((each) => each.provided ? t("provides {type}", { type: each.type }) : t("uses {type}", { type: each.type })).join(", ") : port.type;
  const title = [port.name, type, port.unit && `[${port.unit}]`, port.doc, refused && t("Does not fit: {reason}", { reason: sentence(refused) })].filter(Boolean).join("\n");
  const mark = fits ? (refused === undefined ? "other" : refused ? "refused" : "fits") : "";
  const provided = port.interfaces.some((each) => each.provided);
  const style = { "--ink": ink(service ? typeOf(port) : port.type) } as CSSProperties;
  const isOpen = !joined.has(port.name);
  /** A side of a service port that no wire needs is seen only when the mouse is over it. */
  const side = (right: boolean) => ({ className: service && !(isOpen ? right !== provided : joined.has(sideOf(port.name, right))) ? "spare" : "" });
  const names = { id: idOf(port.name), role: "img", "aria-label": t(service ? "service port {port}" : port.kind === "PORT_IN" ? "in port {port}" : "out port {port}", { port: `${component.instance}.${port.name}` }), title, style };
  return (
    <div className={`port ${kind} ${mark} ${isOpen ? "open" : ""} ${service && !provided ? "socket" : ""}`} title={title}>
      {kind !== "out" && <Handle type="target" position={Position.Left} {...names} {...side(false)}>{REACH}</Handle>}
      <span onClick={() => inspect({ kind: "port", instance: component.instance, port: port.name })}>{port.name}</span>
      <small title={[typeOf(port), title].join("\n")}>{typeOf(port)}</small>
      {kind === "out" && <Handle type="source" position={Position.Right} {...names}>{REACH}</Handle>}
      {service && <Handle type="source" position={Position.Right} {...names} {...side(true)}>{REACH}</Handle>}
    </div>
  );
}

/** The overruns of a component, which change while nothing else of its box does. */
function Late({ instance }: { instance: string }) {
  const overruns = useSyncExternalStore(store.subscribe, () => store.page.statistics.get(instance)?.overruns ?? 0n);
  return overruns > 0n && <span className="late">{` ${t("{count} {count:overrun|overruns}", { count: overruns })}`}</span>;
}

/** Whether two objects have equal members, those of `data` and `position` as well: what is kept is not drawn anew. */
function isSame(one: object, other: object): boolean {
  const [a, b] = [one, other] as Record<string, unknown>[];
  const names = Object.keys(b!);
  return (
    names.length === Object.keys(a!).length &&
    names.every((name) => a![name] === b![name] || ((name === "data" || name === "position") && isSame(a![name] as object, b![name] as object)))
  );
}

/** A box that was moved or measured is drawn as before. */
const isDrawnAlike = (one: NodeProps<Box>, other: NodeProps<Box>): boolean => one.selected === other.selected && isSame(one.data, other.data);

const ComponentBox = memo(function ComponentBox({ data, selected }: NodeProps<Box>) {
  const { component, fits, joined } = data;
  const of = (kind: Port["kind"]) =>
    component.ports
      .filter((port) => port.kind === kind)
      .map((port) => <PortRow key={port.name} component={component} port={port} fits={fits} joined={joined} />);
  const rates = component.contexts.map((each) => `${each.rate} Hz`).join(", ");
  return (
    <div className={`box ${stateClass(component)} ${component.silent ? "silent" : ""} ${selected ? "selected" : ""}`} style={{ width: width(component), "--wide": `${width(component)}px`, "--widest": widest(partsOf(title(component))) } as CSSProperties}>
      <div className="head" title={[component.instance, component.type, component.doc, component.silent || component.reason].filter(Boolean).join("\n")}>
        <strong>
          <span>
            <Name text={title(component)} />
          </span>
        </strong>
        <small>
          {component.silent ? t("does not answer") : stateOf(component)} {rates}
          <Late instance={component.instance} />
        </small>
      </div>
      <div className="ports">
        <div style={{ maxWidth: WIDEST }}>{of("PORT_IN")}</div>
        <div style={{ maxWidth: WIDEST }}>{of("PORT_OUT")}</div>
      </div>
      {of("PORT_SERVICE")}
    </div>
  );
}, isDrawnAlike);

type GroupNode = Node<{ name: string }, "frame">;

/** A group of boxes: those of a process, or of a host. */
function GroupFrame({ data: { name } }: NodeProps<GroupNode>) {
  return (
    <section className="frame-of" aria-label={t("Group {name}", { name })}>
      <bdi>{name}</bdi>
    </section>
  );
}

const nodeTypes = { component: ComponentBox, bus: BusLine, frame: GroupFrame };

interface WireData extends Record<string, unknown> {
  route: readonly Point[] | undefined;
  type: string;
  planned?: string;
}

type Wire = Edge<WireData, "wire">;

/** An end of a wire is where its port is, unless its box is being moved. */
const NEAR = 14;

/** The middle of a line through corners. */
function middle(points: readonly Point[]): Point {
  const lengths = points.slice(1).map((each, i) => Math.hypot(each.x - points[i]!.x, each.y - points[i]!.y));
  let rest = lengths.reduce((sum, each) => sum + each, 0) / 2;
  for (const [i, length] of lengths.entries()) {
    const [one, other] = [points[i]!, points[i + 1]!];
    if (rest <= length && length > 0) return { x: one.x + ((other.x - one.x) * rest) / length, y: one.y + ((other.y - one.y) * rest) / length };
    rest -= length;
  }
  return points[0]!;
}

function WireLine({ id, data, selected, interactionWidth, ...ends }: EdgeProps<Wire>) {
  const [over, hover] = useState(false);
  const route = data?.route;
  const [first, last] = [route?.[0], route?.at(-1)];
  const fits = first && last && Math.hypot(first.x - ends.sourceX, first.y - ends.sourceY) < NEAR && Math.hypot(last.x - ends.targetX, last.y - ends.targetY) < NEAR;
  const [stepped, x, y] = getSmoothStepPath(ends);
  const path = fits ? line(route!) : stepped;
  const at = fits ? middle(route!) : { x, y };
  // The counts change each second; only wires that show theirs are drawn anew.
  const flow = useSyncExternalStore(store.subscribe, () => {
    const found = store.page.flows.get(nameOf(id));
    return found && (found.lost > 0n || over || selected) ? found : undefined;
  });
  const lost = flow && flow.lost > 0n;
  const rate = flow && flow.rate >= 0 ? `${flow.rate.toFixed(flow.rate < 10 ? 1 : 0)}/s` : "";
  const said = data?.planned ?? [rate, lost ? t("{count} lost", { count: flow.lost }) : ""].filter(Boolean).join(", ");
  return (
    <g onMouseEnter={() => hover(true)} onMouseLeave={() => hover(false)}>
      <BaseEdge id={id} path={path} style={{ stroke: ink(data?.type ?? "") }} {...(interactionWidth !== undefined && { interactionWidth })} />
      {said && (lost || over || selected) && (
        <EdgeLabelRenderer>
          <div className={`health ${lost ? "lossy" : ""} ${over || selected ? "" : "still"}`} style={{ transform: `translate(-50%, -50%) translate(${at.x}px, ${at.y}px)` }}>
            <span>{said}</span>
            {lost && (over || selected) && <small>{flow.details}</small>}
          </div>
        </EdgeLabelRenderer>
      )}
    </g>
  );
}

/** Below this zoom, boxes show their names alone, in letters that stay legible. */
const FAR = 0.75;
/** Below this zoom, no names fit boxes. */
const FARTHER = 0.22;

/** Tells the wiring's style how far away it is seen. */
function Distance({ of }: { of: RefObject<HTMLElement | null> }) {
  const zoom = useStore(({ transform }) => transform[2]);
  useLayoutEffect(() => {
    // The first zoom is 1, and the wiring's element comes after it.
    of.current?.style.setProperty("--zoom", String(zoom));
    of.current?.classList.toggle("far", zoom < FAR);
    of.current?.classList.toggle("farther", zoom < FARTHER);
  }, [of, zoom]);
  return null;
}

const MAP = { width: 160, height: 110 };

/** Whether a part of the wiring is outside of the view. */
const useIsCropped = (corners: readonly [Point, Point] | undefined): boolean =>
  useStore(({ transform: [x, y, zoom], width, height }) => {
    if (!corners) return false;
    const [start, end] = corners;
    return x + start.x * zoom < -1 || y + start.y * zoom < -1 || x + end.x * zoom > width + 1 || y + end.y * zoom > height + 1;
  });

/** The button of the small map. `wanted`: whether the user has asked for it; undefined: it is shown beside a part of the wiring. */
function MapButton({ corners, wanted, want }: { corners: readonly [Point, Point] | undefined; wanted: boolean | undefined; want: (shown: boolean) => void }) {
  const cropped = useIsCropped(corners);
  const isShown = wanted ?? cropped;
  return (
    <ControlButton aria-pressed={isShown} aria-label={t("Small map")} title={t("A small map of the whole wiring, by which the view is moved")} onClick={() => want(!isShown)}>
      <MapIcon aria-hidden />
    </ControlButton>
  );
}

function SmallMap({ corners, wanted }: { corners: readonly [Point, Point] | undefined; wanted: boolean | undefined }) {
  const cropped = useIsCropped(corners);
  if (!(wanted ?? cropped)) return null;
  return <MiniMap<Shown> position="top-right" style={MAP} pannable zoomable ariaLabel={t("Map of the wiring")} nodeClassName={(node) => (node.type === "component" ? stateClass(node.data.component) : "bus")} />;
}

const edgeTypes = { wire: WireLine };
const NONE: ReadonlySet<string> = new Set();
const UNPLACED: Wire[] = [];
/** The name of a connection that the timeline will make, which no connection has. */
const plannedName = (number: number): string => `\0${number}`;
/** Wires are routed in parts of this duration, between which the page goes on [ms]. */
const PART = 8;
/** Distance between the lines of two nodes of a bus [px]. */
const APART = 10;
/** What boxes are grouped by; kept when the page is reloaded. */
const GROUPED = "rtgen grouped";
const GROUPS: Readonly<Record<Grouping, { label: string; title: string }>> = {
  "": { label: t("Groups: none"), title: t("Groups: none. Click for those of processes.") },
  process: { label: t("Groups: process"), title: t("Groups: by process. Click for those of hosts.") },
  host: { label: t("Groups: host"), title: t("Groups: by host. Click for none.") },
};
const GROUPINGS: readonly Grouping[] = ["", "process", "host"];
/** Whether boxes are at the places of the layout; kept when the page is reloaded. */
const ARRANGED = "rtgen arranged";

/** What React Flow says to screen readers. */
const LABELS = {
  "node.a11yDescription.default": t("Press enter or space to select a node. Press delete to remove it and escape to cancel."),
  "node.a11yDescription.keyboardDisabled": t("Press enter or space to select a node. You can then use the arrow keys to move the node around. Press delete to remove it and escape to cancel."),
  "node.a11yDescription.ariaLiveMessage": ({ x, y }: { x: number; y: number }) => t("The box has moved to x {x}, y {y}.", { x, y }),
  "edge.a11yDescription.default": t("Press enter or space to select an edge. You can then press delete to remove it or escape to cancel."),
  "controls.ariaLabel": t("Control Panel"),
  "controls.zoomIn.ariaLabel": t("Zoom In"),
  "controls.zoomOut.ariaLabel": t("Zoom Out"),
  "minimap.ariaLabel": t("Map of the wiring"),
};

/** Without the parts that change with time, so that the wiring is only redrawn when it changes. */
export const Wiring = memo(function Wiring(props: {
  file: string;
  components: readonly Component[];
  connections: readonly Connection[];
  buses: readonly Bus[];
  /** Connections that the timeline will make. */
  planned: readonly PlannedEvent[];
  lost: ReadonlyMap<string, bigint>;
  full: boolean;
  selected: string;
  select: (instance: string) => void;
  open: (view: View) => void;
  rename: (instance: string) => void;
  inspect: (subject: Subject | undefined) => void;
  add: () => void;
}) {
  const { file, components, connections, buses, planned, lost, full, selected, select, open, rename, inspect, add } = props;
  const [nodes, setNodes, onNodesChange] = useNodesState<Shown>([]);
  const [arrangement, setArrangement] = useState<Arrangement & { shape: string }>();
  const [arranged, setArranged] = useState(() => sessionStorage.getItem(ARRANGED) !== "no");
  const [by, groupBy] = useState<Grouping>(() => GROUPINGS.find((each) => each === sessionStorage.getItem(GROUPED)) ?? "");
  /** Whether there are several processes, so that boxes can be grouped. */
  const isSpread = new Set(components.map((each) => each.place)).size > 1;
  const [flow, setFlow] = useState<ReactFlowInstance<Shown, Wire>>();
  const section = useRef<HTMLElement>(null);
  const [room, setRoom] = useState("");
  /** Whether the user has moved the view. */
  const moved = useRef(false);
  const [picked, pick] = useState<ReadonlySet<string>>(new Set());
  const [fits, setFits] = useState<ReadonlyMap<string, Fit>>();
  const [misfit, ask] = useState<Misfit>();
  const [unfit, explain] = useState<Unfit>();
  const [menu, setMenu] = useState<Place & { edge: boolean }>();
  /** Whether the small map is shown: undefined: beside a part of the wiring. */
  const [wanted, showMap] = useState<boolean>();
  const isWide = useWidth(ROOM);
  const isHidden = room.startsWith("0x");
  const drags = useRef(0);
  /** Places of boxes moved by arrow keys, until they are stored. */
  const steered = useRef(new Map<string, Point>());
  const shape = [file, by, ...components.map((each) => each.instance)].join("\n");

  const lines = useMemo(() => linesOf(components, buses), [components, buses]);

  useEffect(() => {
    const { clientWidth, clientHeight } = section.current!;
    // The proportions of a hidden view are not known: it is arranged when it is shown.
    if (!clientWidth) return undefined;
    let current = true;
    const free = hung(components, connections, lines);
    const joined = components.filter((each) => !free.has(each.instance));
    arrange(joined, connections, clientWidth, clientHeight, height(lines, byInstance(components)), by).then(
      (found) => current && setArrangement({ ...found, shape }),
      (error: unknown) => store.notify(t("The layout failed: {error}", { error: String(error) })),
    );
    return () => {
      current = false;
    };
    // Later connections do not move boxes.
  }, [shape, isHidden]);

  /** Places of boxes and buses, and the bounding box. */
  const places = useMemo(() => {
    if (!arrangement) return undefined;
    const boxes = components.flatMap((component) => {
      const place = !arranged && component.placed ? shown(component.where) : arrangement.places.get(component.instance);
      return place ? [{ component, ...place }] : [];
    });
    const placed = new Set(boxes.map((each) => each.component));
    const corners = (arranged || !boxes.length ? [{ x: 0, y: 0 }, arrangement.end] : around(boxes)) as [Point, Point];
    const found = rails(lines, boxes, corners, byInstance(components.filter((each) => !placed.has(each))));
    const of = new Map([...found.places, ...boxes.map(({ component, x, y }) => [component.instance, { x, y }] as const)]);
    return { of, rails: found.rails, corners: [corners[0], found.end] as [Point, Point], frames: frames(boxes, by) };
  }, [arrangement, arranged, components, lines, by]);

  /** Where boxes are, for the lines that go around them. */
  const standing = useMemo(
    () =>
      components.flatMap((each) => {
        const place = places?.of.get(each.instance);
        return place ? [{ ...place, ...size(each) }] : [];
      }),
    [components, places],
  );

  const joined = useMemo(() => {
    const found = new Map<string, Set<string>>();
    for (const { source, target } of connections)
      for (const [{ instance, port }, right] of [[source, true], [target, false]] as const)
        found.set(instance, (found.get(instance) ?? new Set()).add(port).add(sideOf(port, right)));
    return found;
  }, [connections]);

  useLayoutEffect(() => {
    setNodes((before) => {
      const known = new Map(before.map((node) => [node.id, node]));
      const boxes = components.map((component): Box => {
        const id = idOf(component.instance);
        const old = known.get(id) as Box | undefined;
        const next = {
          ...old,
          id,
          type: "component" as const,
          position: old?.dragging ? old.position : (steered.current.get(id) ?? places?.of.get(component.instance) ?? { x: 0, y: 0 }),
          ariaLabel: `${component.instance}, ${component.type}, ${component.silent ? t("does not answer") : stateOf(component)}`,
          data: { component, fits, joined: joined.get(component.instance) ?? NONE },
        };
        return old && isSame(old, next) ? old : next;
      });
      const isKept = places !== undefined && !lines.length && !places.frames.length && boxes.length === before.length && boxes.every((each, i) => each === before[i]);
      if (isKept) return before;
      // The boxes are made while the layout looks for their places.
      if (!places) return boxes;
      const sizes = new Map(components.map((each) => [each.instance, size(each)]));
      const buses = lines.map((line, i): BusNode => {
        const { at, width, middles } = places.rails[i]!;
        const from = (instance: string, node: number): Drop[] => {
          const [place, box] = [places.of.get(instance), sizes.get(instance)];
          if (!place || !box) return [];
          const isAbove = place.y < at.y;
          // Lines of boxes above each other do not coincide.
          const across = isAbove ? (node - (line.nodes.length - 1) / 2) * APART : 0;
          const start = { x: place.x + box.width / 2 + across, y: place.y + (isAbove ? box.height : 0) };
          const down = isAbove ? descent(start, at.y, standing, node) : start.x;
          return [{ x: start.x - at.x, y: start.y - at.y, down: down - at.x, chosen: instance === selected }];
        };
        return {
          ...(known.get(`bus ${line.name}`) as BusNode | undefined),
          id: `bus ${line.name}`,
          type: "bus",
          position: at,
          zIndex: -1,
          draggable: false,
          selectable: false,
          connectable: false,
          deletable: false,
          focusable: false,
          data: {
            line,
            width,
            nodes: line.nodes.map((node, j) => ({
              x: middles[j]!,
              proxies: node.proxies.flatMap((each) => from(each, j)),
              devices: node.devices.flatMap((each) => from(each, j)),
            })),
          },
        };
      });
      const groups = places.frames.map(
        ({ name, x, y, width, height }): GroupNode => ({
          ...(known.get(`group ${name}`) as GroupNode | undefined),
          id: `group ${name}`,
          type: "frame",
          position: { x, y },
          width,
          height,
          zIndex: -2,
          draggable: false,
          selectable: false,
          connectable: false,
          deletable: false,
          focusable: false,
          data: { name },
        }),
      );
      return [...groups, ...boxes, ...buses];
    });
  }, [components, places, standing, lines, fits, joined, selected, setNodes]);

  // React Flow calls each new function with what is selected, as if it had just been selected.
  const onSelectionChange = useCallback(({ nodes: chosen }: { nodes: Shown[] }) => chosen[0] && select(nameOf(chosen[0].id)), [select]);
  useEffect(
    () =>
      setNodes((before) =>
        before.some((node) => node.selected && node.id === idOf(selected)) ? before : before.map((node) => ({ ...node, selected: node.id === idOf(selected) })),
      ),
    [selected, setNodes],
  );

  useEffect(() => {
    const watching = new ResizeObserver(() => setRoom(`${section.current!.clientWidth}x${section.current!.clientHeight}`));
    watching.observe(section.current!);
    return () => watching.disconnect();
  }, []);

  const fit = () => {
    if (!flow || !places || !components.length || !section.current!.clientWidth) return;
    const { clientWidth, clientHeight } = section.current!;
    void flow.setViewport(view(places.corners, clientWidth, clientHeight, !isWide));
    moved.current = false;
  };
  // Moving boxes does not move the view.
  useEffect(fit, [flow, arrangement, arranged]);
  useEffect(() => {
    if (!moved.current) fit();
  }, [room]);

  /** Routes of the wires that the layout has none for, around the boxes as they are. */
  const [routes, setRoutes] = useState<ReadonlyMap<string, readonly Point[]>>();
  useLayoutEffect(() => {
    if (!places) return undefined;
    const known = byInstance(components);
    const end = ({ instance, port }: PortAddress, right: boolean): Point | undefined => {
      const [component, place] = [known.get(instance), places.of.get(instance)];
      const at = component && portPlace(component, port, right);
      return at && place && { x: place.x + at.x, y: place.y + at.y };
    };
    const taken = new Taken();
    const isAt = (one: Point | undefined, other: Point) => one !== undefined && Math.hypot(one.x - other.x, one.y - other.y) < 1;
    const found = new Map<string, readonly Point[]>();
    const wires = [...connections, ...planned.map((each, i) => ({ ...each, name: plannedName(i) }))];
    const waiting = wires.flatMap(({ name, source, target }) => {
      const [from, to] = [end(source, true), end(target, false)];
      if (!from || !to) return [];
      const proposed = arranged ? arrangement?.routes.get(name) : undefined;
      if (!proposed || !isAt(proposed[0], from) || !isAt(proposed.at(-1), to) || !isClear(standing, proposed)) return [{ name, from, to }];
      taken.add(proposed);
      found.set(name, proposed);
      return [];
    });
    let current = true;
    const go = () => {
      if (!current) return;
      const until = performance.now() + PART;
      while (waiting.length && performance.now() < until) {
        const wire = waiting.shift()!;
        const points = route(standing, wire, taken);
        if (!points) continue;
        taken.add(points);
        found.set(wire.name, points);
      }
      if (waiting.length) setTimeout(go);
      // At first, wires that have their routes are shown without those that have none yet.
      setRoutes((before) => (waiting.length ? (before ?? new Map(found)) : found));
    };
    go();
    return () => {
      current = false;
    };
  }, [places, standing, connections, components, planned, arranged, arrangement]);

  const drawn = useRef<Wire[]>([]);
  const edges = useMemo(() => {
    const known = byInstance(components);
    const typeAt = ({ instance, port }: PortAddress): string => {
      const found = known.get(instance)?.ports.find((each) => each.name === port);
      return found ? (found.kind === "PORT_SERVICE" ? typeOf(found) : found.type) : "";
    };
    const joins = new Set(connections.map((each) => `${address(each.source)} ${address(each.target)}`));
    const now = connections.map((each): Wire => {
      const count = lost.get(each.name);
      return {
        id: idOf(each.name),
        type: "wire",
        data: { route: routes?.get(each.name), type: typeAt(each.source) },
        source: idOf(each.source.instance),
        sourceHandle: idOf(each.source.port),
        target: idOf(each.target.instance),
        targetHandle: idOf(each.target.port),
        selected: picked.has(idOf(each.name)),
        ariaLabel: t(count ? "connection {name} from {source} to {target}, {lost} samples lost" : "connection {name} from {source} to {target}", {
          name: each.name,
          source: `${each.source.instance}.${each.source.port}`,
          target: `${each.target.instance}.${each.target.port}`,
          lost: count ?? 0n,
        }),
      };
    });
    const later = planned
      .filter(({ source, target }) => known.has(source.instance) && known.has(target.instance) && !joins.has(`${address(source)} ${address(target)}`))
      .map((each, i): Wire => ({
        id: `planned ${i}`,
        type: "wire",
        className: "planned",
        data: { route: routes?.get(plannedName(planned.indexOf(each))), type: typeAt(each.source), planned: t("at {time} s", { time: each.time }) },
        source: idOf(each.source.instance),
        sourceHandle: idOf(each.source.port),
        target: idOf(each.target.instance),
        targetHandle: idOf(each.target.port),
        selectable: false,
        deletable: false,
        focusable: false,
      }));
    const before = drawn.current;
    const earlier = new Map(before.map((each) => [each.id, each]));
    const after = [...later, ...now].map((each) => {
      const old = earlier.get(each.id);
      return old && isSame(old, each) ? old : each;
    });
    if (after.length !== before.length || after.some((each, i) => each !== before[i])) drawn.current = after;
    return drawn.current;
  }, [connections, components, planned, lost, picked, routes]);

  const begin = async (port: PortAddress) => {
    const drag = ++drags.current;
    const result = await store.ask({ case: "ends", value: port });
    // An answer after the end of its drag would be applied to the next drag.
    if (result.done && drag === drags.current) setFits(new Map(result.fits.map((each: Fit) => [address(each.port), each])));
  };
  /** Shows at a port why it does not fit the one that a line was begun at. */
  const refuse = (here: PortAddress, there: PortAddress, reason: string) => {
    const port = section.current!.querySelector(`[data-nodeid="${CSS.escape(idOf(there.instance))}"][data-handleid="${CSS.escape(idOf(there.port))}"]`);
    if (port) explain({ ends: ordered(components, here, there), reason, at: port.getBoundingClientRect() });
  };
  const connect = async (drawn: Drawn) => {
    const [source, target] = [portOf(drawn.source, drawn.sourceHandle), portOf(drawn.target, drawn.targetHandle)];
    const reason = await store.attempt({ case: "wire", value: { source, target, name: "", properties: [] } });
    if (reason) refuse(source, target, reason);
  };
  const place = (id: string, position: Point) =>
    store.order({ case: "place", value: { instance: nameOf(id), where: stored(position) } }).then(() => steered.current.delete(id));
  const items = ({ label, edge }: Place & { edge: boolean }): Item[] => {
    const order = (name: string, kind: "activated" | "deactivated" | "restored") => ({ name, act: () => void store.order({ case: kind, value: [label] }) });
    if (edge) return [{ name: t("Cut"), act: () => void store.order({ case: "connection", value: label }) }];
    const connections = () => {
      select(label);
      open("Connections");
    };
    return [
      order(t("Activate"), "activated"),
      order(t("Deactivate"), "deactivated"),
      order(t("Reset"), "restored"),
      ...(components.find((each) => each.instance === label)?.place ? [] : [{ name: t("Rename"), act: () => rename(label) }]),
      { name: t("Connections"), act: connections },
      { name: t("Remove"), act: () => void store.order({ case: "removed", value: label }) },
    ];
  };

  return (
    <section
      ref={section}
      className={arrangement ? "wiring" : "wiring unplaced"}
      aria-label={t("Wiring")}
      aria-busy={!isHidden && arrangement?.shape !== shape}
      onDragOver={(e) => {
        if (!full || !e.dataTransfer.types.includes(DRAGGED)) return;
        e.preventDefault();
        e.dataTransfer.dropEffect = "copy";
      }}
      onDrop={(e) => {
        const type = e.dataTransfer.getData(DRAGGED);
        if (!type || !flow) return;
        e.preventDefault();
        const where = stored(flow.screenToFlowPosition({ x: e.clientX, y: e.clientY }));
        void store.order({ case: "added", value: { type, instance: "", placed: true, where } });
      }}
      onKeyUp={(e) => {
        // Arrow keys have moved the selected boxes on this page; drags are stored when they end.
        if (full && !arranged && e.key.startsWith("Arrow")) for (const [id, position] of steered.current) void place(id, position);
      }}
      onKeyDown={(e) => {
        const target = (e.target as HTMLElement).closest<HTMLElement>(".react-flow__node, .react-flow__edge");
        // One that is selected already tells of no change.
        if (e.key === "Enter" && target?.matches(".react-flow__edge:not(.planned)")) inspect({ kind: "wire", name: nameOf(target.dataset["id"] ?? "") });
        if (target && full && (e.key === "ContextMenu" || (e.key === "F10" && e.shiftKey))) {
          e.preventDefault();
          const box = target.getBoundingClientRect();
          setMenu({ label: nameOf(target.dataset["id"] ?? ""), edge: target.matches(".react-flow__edge"), x: box.x + 20, y: box.y + 20 });
        }
      }}
    >
        <Inspecting.Provider value={inspect}>
        <ReactFlow
          nodes={nodes}
          edges={routes ? edges : UNPLACED}
          nodeTypes={nodeTypes}
          edgeTypes={edgeTypes}
          onInit={setFlow}
          onMoveStart={(event) => {
            moved.current ||= event !== null;
            if (event) explain(undefined);
          }}
          colorMode="system"
          ariaLabelConfig={LABELS}
          defaultEdgeOptions={{ interactionWidth: 16 }}
          minZoom={0.05}
          nodesConnectable={full}
          nodesDraggable={full && !arranged}
          deleteKeyCode={full ? ["Delete", "Backspace"] : null}
          onNodesChange={(changes) => {
            for (const each of changes) if (each.type === "position" && each.position && !each.dragging) steered.current.set(each.id, each.position);
            onNodesChange(changes);
          }}
          onEdgesChange={(changes) => {
            for (const each of changes) if (each.type === "select" && each.selected) inspect({ kind: "wire", name: nameOf(each.id) });
            pick((before) => {
              const after = new Set(before);
              for (const each of changes)
                if (each.type === "select") after[each.selected ? "add" : "delete"](each.id);
              return after;
            });
          }}
          onBeforeDelete={async ({ nodes: gone, edges: cut }) => {
            // The events of the server remove them from the page.
            if (gone.length) for (const each of gone) await store.order({ case: "removed", value: nameOf(each.id) });
            else for (const each of cut) await store.order({ case: "connection", value: nameOf(each.id) });
            return false;
          }}
          onConnectStart={(_, from) => void begin(portOf(from.nodeId, from.handleId))}
          onConnectEnd={(_, state) => {
            const end = state.toHandle;
            const fit = end && fits?.get(address(portOf(end.nodeId, end.id)));
            const from = state.fromHandle;
            if (fit?.allow && from && full) ask({ here: portOf(from.nodeId, from.id), fit });
            else if (fit?.refused && from) {
              store.refuse(fit.refused);
              refuse(portOf(from.nodeId, from.id), fit.port, fit.refused);
            }
            drags.current++;
            setFits(undefined);
          }}
          isValidConnection={(drawn) => {
            const refused = (...end: Parameters<typeof portOf>) => fits?.get(address(portOf(...end)))?.refused;
            return !(refused(drawn.target, drawn.targetHandle) || refused(drawn.source, drawn.sourceHandle));
          }}
          onConnect={(drawn) => void connect(drawn)}
          onEdgeClick={(_, { id, selectable }) => selectable !== false && inspect({ kind: "wire", name: nameOf(id) })}
          onNodeClick={(e) => (e.target as HTMLElement).closest(".port span, .bus-node") || inspect(undefined)}
          onNodeDragStop={(_, node) => void place(node.id, node.position)}
          onSelectionChange={onSelectionChange}
          onNodeContextMenu={(e, node) => {
            e.preventDefault();
            if (full) setMenu({ label: nameOf(node.id), edge: false, x: e.clientX, y: e.clientY });
          }}
          onEdgeContextMenu={(e, edge) => {
            e.preventDefault();
            if (full) setMenu({ label: nameOf(edge.id), edge: true, x: e.clientX, y: e.clientY });
          }}
        >
          <Background />
          <Distance of={section} />
          <Controls showInteractive={false} showFitView={false} orientation={isWide ? "vertical" : "horizontal"}>
            <ControlButton aria-label={t("Fit View")} title={t("Fit View")} onClick={fit}>
              <Maximize aria-hidden />
            </ControlButton>
            <ControlButton
              aria-pressed={arranged}
              aria-label={t("Arranged")}
              title={arranged ? t("Arranged: so that lines hardly cross. Click for the places of the file, where boxes can be dragged.") : t("The places of the file. Click to arrange the boxes.")}
              onClick={() => {
                setArranged(!arranged);
                sessionStorage.setItem(ARRANGED, arranged ? "no" : "yes");
              }}
            >
              <LayoutGrid aria-hidden />
            </ControlButton>
            {isSpread && (
              <ControlButton
                aria-pressed={by !== ""}
                aria-label={GROUPS[by].label}
                title={GROUPS[by].title}
                onClick={() => {
                  const next = GROUPINGS[(GROUPINGS.indexOf(by) + 1) % GROUPINGS.length]!;
                  groupBy(next);
                  sessionStorage.setItem(GROUPED, next);
                }}
              >
                <Group aria-hidden />
              </ControlButton>
            )}
            <MapButton corners={places?.corners} wanted={wanted} want={showMap} />
          </Controls>
          <SmallMap corners={places?.corners} wanted={wanted} />
        </ReactFlow>
        </Inspecting.Provider>
      {!components.length && (
        <div className="empty over">
          <strong>{t("This system has no components yet.")}</strong>
          <p>{t("Add the first one, then drag from port to port to connect it with the next.")}</p>
          <Button icon={Plus} look="primary" disabled={!full} onClick={add}>
            {t("Add a component")}
          </Button>
        </div>
      )}
      {menu && <Menu place={menu} items={items(menu)} close={() => setMenu(undefined)} />}
      {unfit && <UnfitCard unfit={unfit} close={() => explain(undefined)} />}
      {misfit && <Purpose misfit={misfit} close={() => ask(undefined)} />}
    </section>
  );
});

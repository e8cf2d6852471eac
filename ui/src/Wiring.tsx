/** The graph of components and connections, changed by mouse and by keyboard. */

import { Background, BaseEdge, ControlButton, Controls, Handle, Position, ReactFlow, getBezierPath, useNodesState } from "@xyflow/react";
import type { Connection as Drawn, Edge, EdgeProps, Node, NodeProps, ReactFlowInstance } from "@xyflow/react";
import { memo, useCallback, useEffect, useMemo, useRef, useState } from "react";
import { BusLine, OpenBuses } from "./BusLine.tsx";
import type { BusNode, Drop } from "./BusLine.tsx";
import { WIDEST, around, arrange, height, hung, line, rails, shown, size, stored, title, view, width } from "./layout.ts";
import type { Arrangement, Point } from "./layout.ts";
import { linesOf } from "./lines.ts";
import { Menu } from "./Menu.tsx";
import type { Item, Place } from "./Menu.tsx";
import type { Tab } from "./Panel.tsx";
import type { Bus, Component, Connection, Fit, Port, PortAddress } from "./protocol/Ui.ts";
import type { Misfit } from "./Purpose.tsx";
import { Purpose } from "./Purpose.tsx";
import type { Statistics } from "./store.ts";
import { stateName, store } from "./store.ts";

interface BoxData extends Record<string, unknown> {
  component: Component;
  overruns: bigint;
  fits: ReadonlyMap<string, Fit> | undefined;
}

type Box = Node<BoxData, "component">;
type Shown = Box | BusNode;

/** React Flow puts ids into selectors, so names with any characters are escaped. */
const idOf = encodeURIComponent;
const nameOf = decodeURIComponent;
const byInstance = (components: readonly Component[]): Map<string, Component> => new Map(components.map((each) => [each.instance, each]));
const portOf = (node: string | null, handle: string | null | undefined): PortAddress => ({ instance: nameOf(node ?? ""), port: nameOf(handle ?? "") });
const address = ({ instance, port }: PortAddress): string => JSON.stringify([instance, port]);

/** A hue for each type, the same on each page. */
export function hue(type: string): number {
  let sum = 0;
  for (const character of type) sum = (sum * 31 + character.charCodeAt(0)) % 360;
  return sum;
}

function PortRow({ component, port, fits }: { component: Component; port: Port; fits: BoxData["fits"] }) {
  const service = port.kind === "PORT_SERVICE";
  const kind = service ? "service" : port.kind === "PORT_IN" ? "in" : "out";
  const refused = fits?.get(address({ instance: component.instance, port: port.name }))?.refused;
  const type = service ? port.interfaces.map((each) => `${each.provided ? "provides" : "uses"} ${each.type}`).join(", ") : port.type;
  const title = [port.name, type, port.unit && `[${port.unit}]`, port.doc, refused && `Does not fit: ${refused}`].filter(Boolean).join("\n");
  const mark = fits ? (refused === undefined ? "other" : refused ? "refused" : "fits") : "";
  const provided = port.interfaces.some((each) => each.provided);
  const style = { background: service && !provided ? "var(--box)" : `hsl(${hue(type)} 65% 50%)` };
  const names = { id: idOf(port.name), role: "img", "aria-label": `${kind} port ${component.instance}.${port.name}`, title, style };
  return (
    <div className={`port ${kind} ${mark} ${service && !provided ? "socket" : ""}`} title={title}>
      {kind !== "out" && <Handle type="target" position={Position.Left} {...names} />}
      <span>{port.name}</span>
      {kind === "out" && <Handle type="source" position={Position.Right} {...names} />}
      {service && <Handle type="source" position={Position.Right} {...names} />}
    </div>
  );
}

function ComponentBox({ data, selected }: NodeProps<Box>) {
  const { component, overruns, fits } = data;
  const of = (kind: Port["kind"]) =>
    component.ports
      .filter((port) => port.kind === kind)
      .map((port) => <PortRow key={port.name} component={component} port={port} fits={fits} />);
  const rates = component.contexts.map((each) => `${each.rate} Hz`).join(", ");
  return (
    <div className={`box ${component.current} ${component.silent ? "silent" : ""} ${selected ? "selected" : ""}`} style={{ width: width(component) }}>
      <div className="head" title={[component.place && component.instance, component.type, component.doc, component.silent || component.reason].filter(Boolean).join("\n")}>
        <strong>{title(component)}</strong>
        <small>
          {component.silent ? "does not answer" : stateName(component.current)} {rates}
          {overruns > 0n && ` ${overruns} overruns`}
        </small>
      </div>
      <div className="ports">
        <div style={{ maxWidth: WIDEST }}>{of("PORT_IN")}</div>
        <div style={{ maxWidth: WIDEST }}>{of("PORT_OUT")}</div>
      </div>
      {of("PORT_SERVICE")}
    </div>
  );
}

const nodeTypes = { component: ComponentBox, bus: BusLine };

type Wire = Edge<{ route: readonly Point[] | undefined }, "wire">;

function WireLine({ id, data, interactionWidth, ...ends }: EdgeProps<Wire>) {
  const path = data?.route ? line(data.route) : getBezierPath(ends)[0];
  return <BaseEdge id={id} path={path} {...(interactionWidth !== undefined && { interactionWidth })} />;
}

const edgeTypes = { wire: WireLine };
/** Distance between the lines of two nodes of a bus [px]. */
const APART = 10;
/** Whether boxes are at the places of the layout; kept when the page is reloaded. */
const ARRANGED = "rtgen arranged";

/** Without the parts that change with time, so that the wiring is only redrawn when it changes. */
export const Wiring = memo(function Wiring(props: {
  file: string;
  components: readonly Component[];
  connections: readonly Connection[];
  buses: readonly Bus[];
  full: boolean;
  statistics: ReadonlyMap<string, Statistics>;
  selected: string;
  select: (instance: string) => void;
  open: (tab: Tab) => void;
}) {
  const { file, components, connections, buses, full, statistics, selected, select, open } = props;
  const [nodes, setNodes, onNodesChange] = useNodesState<Shown>([]);
  const [arrangement, setArrangement] = useState<Arrangement & { shape: string }>();
  const [arranged, setArranged] = useState(() => sessionStorage.getItem(ARRANGED) !== "no");
  const [flow, setFlow] = useState<ReactFlowInstance<Shown, Wire>>();
  const section = useRef<HTMLElement>(null);
  const [room, setRoom] = useState("");
  /** Whether the user has moved the view. */
  const moved = useRef(false);
  const [picked, pick] = useState<ReadonlySet<string>>(new Set());
  const [fits, setFits] = useState<ReadonlyMap<string, Fit>>();
  const [misfit, ask] = useState<Misfit>();
  const [menu, setMenu] = useState<Place & { edge: boolean }>();
  const drags = useRef(0);
  /** Places of boxes moved by arrow keys, until they are stored. */
  const steered = useRef(new Map<string, Point>());
  const shape = [file, ...components.map((each) => each.instance)].join("\n");

  const lines = useMemo(() => linesOf(components, buses), [components, buses]);

  useEffect(() => {
    let current = true;
    const { clientWidth, clientHeight } = section.current!;
    const free = hung(components, connections, lines);
    const joined = components.filter((each) => !free.has(each.instance));
    arrange(joined, connections, clientWidth, clientHeight, height(lines, byInstance(components))).then(
      (found) => current && setArrangement({ ...found, shape }),
      (error: unknown) => store.notify(`The layout failed: ${String(error)}`),
    );
    return () => {
      current = false;
    };
    // Later connections do not move boxes.
  }, [shape]);

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
    return { of, rails: found.rails, corners: [corners[0], found.end] as [Point, Point] };
  }, [arrangement, arranged, components, lines]);

  useEffect(() => {
    if (!places) return;
    setNodes((before) => {
      const known = new Map(before.map((node) => [node.id, node]));
      const boxes = components.map((component): Box => {
        const id = idOf(component.instance);
        const old = known.get(id) as Box | undefined;
        return {
          ...old,
          id,
          type: "component" as const,
          position: old?.dragging ? old.position : (steered.current.get(id) ?? places.of.get(component.instance) ?? { x: 0, y: 0 }),
          ariaLabel: `${component.instance}, ${component.type}, ${component.silent ? "does not answer" : stateName(component.current)}`,
          data: { component, overruns: statistics.get(component.instance)?.overruns ?? 0n, fits },
        };
      });
      const sizes = new Map(components.map((each) => [each.instance, size(each)]));
      const buses = lines.map((line, i): BusNode => {
        const { at, width, middles } = places.rails[i]!;
        const from = (instance: string, node: number): Drop[] => {
          const [place, box] = [places.of.get(instance), sizes.get(instance)];
          if (!place || !box) return [];
          const isAbove = place.y < at.y;
          // Lines of boxes above each other do not coincide.
          const across = isAbove ? (node - (line.nodes.length - 1) / 2) * APART : 0;
          return [{ x: place.x + box.width / 2 + across - at.x, y: place.y + (isAbove ? box.height : 0) - at.y, chosen: instance === selected }];
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
      return [...boxes, ...buses];
    });
  }, [components, places, lines, statistics, fits, selected, setNodes]);

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
    if (!flow || !places || !components.length) return;
    void flow.setViewport(view(places.corners, section.current!.clientWidth, section.current!.clientHeight));
    moved.current = false;
  };
  // Moving boxes does not move the view.
  useEffect(fit, [flow, arrangement, arranged]);
  useEffect(() => {
    if (!moved.current) fit();
  }, [room]);

  const edges = useMemo(
    () =>
      connections.map(
        (each): Wire => ({
          id: idOf(each.name),
          type: "wire",
          data: { route: arranged ? arrangement?.routes.get(each.name) : undefined },
          source: idOf(each.source.instance),
          sourceHandle: idOf(each.source.port),
          target: idOf(each.target.instance),
          targetHandle: idOf(each.target.port),
          selected: picked.has(idOf(each.name)),
          ariaLabel: `connection ${each.name} from ${each.source.instance}.${each.source.port} to ${each.target.instance}.${each.target.port}`,
        }),
      ),
    [connections, picked, arrangement, arranged],
  );

  const begin = async (port: PortAddress) => {
    const drag = ++drags.current;
    const result = await store.ask({ case: "ends", value: port });
    // An answer after the end of its drag would be applied to the next drag.
    if (result.done && drag === drags.current) setFits(new Map(result.fits.map((each: Fit) => [address(each.port), each])));
  };
  const connect = (drawn: Drawn) =>
    store.order({
      case: "wire",
      value: {
        source: portOf(drawn.source, drawn.sourceHandle),
        target: portOf(drawn.target, drawn.targetHandle),
        name: "",
        properties: [],
      },
    });
  const place = (id: string, position: Point) =>
    store.order({ case: "place", value: { instance: nameOf(id), where: stored(position) } }).then(() => steered.current.delete(id));
  const openBuses = useCallback(() => open("Buses"), [open]);
  const items = ({ label, edge }: Place & { edge: boolean }): Item[] => {
    const order = (name: string, kind: "activated" | "deactivated" | "restored") => ({ name, act: () => void store.order({ case: kind, value: [label] }) });
    if (edge) return [{ name: "Cut", act: () => void store.order({ case: "connection", value: label }) }];
    const connections = () => {
      select(label);
      open("Connections");
    };
    return [
      order("Activate", "activated"),
      order("Deactivate", "deactivated"),
      order("Reset", "restored"),
      { name: "Connections", act: connections },
      { name: "Remove", act: () => void store.order({ case: "removed", value: label }) },
    ];
  };

  return (
    <section
      ref={section}
      className="wiring"
      aria-label="Wiring"
      aria-busy={arrangement?.shape !== shape}
      onKeyUp={(e) => {
        // Arrow keys have moved the selected boxes on this page; drags are stored when they end.
        if (full && !arranged && e.key.startsWith("Arrow")) for (const [id, position] of steered.current) void place(id, position);
      }}
      onKeyDown={(e) => {
        const target = (e.target as HTMLElement).closest<HTMLElement>(".react-flow__node, .react-flow__edge");
        if (target && full && (e.key === "ContextMenu" || (e.key === "F10" && e.shiftKey))) {
          e.preventDefault();
          const box = target.getBoundingClientRect();
          setMenu({ label: nameOf(target.dataset["id"] ?? ""), edge: target.matches(".react-flow__edge"), x: box.x + 20, y: box.y + 20 });
        }
      }}
    >
      {arrangement && (
        <OpenBuses.Provider value={openBuses}>
        <ReactFlow
          nodes={nodes}
          edges={edges}
          nodeTypes={nodeTypes}
          edgeTypes={edgeTypes}
          onInit={setFlow}
          onMoveStart={(event) => {
            moved.current ||= event !== null;
          }}
          colorMode="system"
          defaultEdgeOptions={{ interactionWidth: 16 }}
          fitViewOptions={{ padding: 0.06 }}
          minZoom={0.1}
          nodesConnectable={full}
          nodesDraggable={full && !arranged}
          deleteKeyCode={full ? ["Delete", "Backspace"] : null}
          onNodesChange={(changes) => {
            for (const each of changes) if (each.type === "position" && each.position && !each.dragging) steered.current.set(each.id, each.position);
            onNodesChange(changes);
          }}
          onEdgesChange={(changes) =>
            pick((before) => {
              const after = new Set(before);
              for (const each of changes)
                if (each.type === "select") after[each.selected ? "add" : "delete"](each.id);
              return after;
            })
          }
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
            else if (fit?.refused) store.notify(fit.refused);
            drags.current++;
            setFits(undefined);
          }}
          isValidConnection={(drawn) => {
            const refused = (...end: Parameters<typeof portOf>) => fits?.get(address(portOf(...end)))?.refused;
            return !(refused(drawn.target, drawn.targetHandle) || refused(drawn.source, drawn.sourceHandle));
          }}
          onConnect={(drawn) => void connect(drawn)}
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
          <Controls showInteractive={false}>
            <ControlButton
              aria-pressed={arranged}
              aria-label="Arranged"
              title={arranged ? "Arranged: so that lines hardly cross. Click for the places of the file, where boxes can be dragged." : "The places of the file. Click to arrange the boxes."}
              onClick={() => {
                setArranged(!arranged);
                sessionStorage.setItem(ARRANGED, arranged ? "no" : "yes");
              }}
            >
              <svg viewBox="0 0 32 32" aria-hidden>
                <path d="M2 4h11v9H2zM19 4h11v9H19zM2 19h11v9H2zM19 19h11v9H19z" />
              </svg>
            </ControlButton>
          </Controls>
        </ReactFlow>
        </OpenBuses.Provider>
      )}
      {menu && <Menu place={menu} items={items(menu)} close={() => setMenu(undefined)} />}
      {misfit && <Purpose misfit={misfit} close={() => ask(undefined)} />}
    </section>
  );
});

/** The layout's worker: gets what the server has stored, and asks ELK for the rest, which loads in a worker of its own. */

import ELK from "elkjs/lib/elk-api.js";
import type { ElkNode, ElkPoint } from "elkjs/lib/elk-api.js";
import program from "elkjs/lib/elk-worker.min.js?url";

/** What the page asks for. */
export interface Asked {
  graph: ElkNode;
  /** The token of the page. */
  token: string;
}

/** Where ELK has placed a graph, as the server stores it. */
export interface Placed {
  width: number;
  height: number;
  /** Names and left upper corners of boxes. */
  boxes: (readonly [string, number, number])[];
  /** Names and corners of connections. */
  wires: (readonly [string, (readonly [number, number])[]])[];
}

export type Answer = { placed: Placed } | { error: string };

/** Longest time that ELK waits for the server [ms]. */
const LONGEST = 10_000;

function load(): Worker {
  const worker = new Worker(program);
  // The page hears of it by the error of its own worker.
  worker.onerror = (e) => {
    throw new Error(e.message);
  };
  return worker;
}

const elk = new ELK({ workerFactory: load, algorithms: ["layered"] });

self.onmessage = ({ data, ports: [page] }: MessageEvent<Asked>) => {
  arranged(data).then(
    (placed) => page!.postMessage({ placed } satisfies Answer),
    (error: unknown) => page!.postMessage({ error: error instanceof Error ? error.message : String(error) } satisfies Answer),
  );
};

async function arranged({ graph, token }: Asked): Promise<Placed> {
  // Without an answer, nothing is stored.
  const { stored, put } = await look(graph, token).catch(() => ({ stored: undefined, put: "" }));
  if (stored) return stored;
  const placed = compact(await elk.layout(graph));
  if (put) fetch(put, { method: "PUT", body: JSON.stringify(placed) }).catch(() => undefined);
  return placed;
}

/** What the server has stored for a graph, and the address where it takes another arrangement, if it does. */
async function look(graph: ElkNode, token: string): Promise<{ stored: Placed | undefined; put: string }> {
  const address = `/arrangements/${await keyOf(graph)}?token=${encodeURIComponent(token)}`;
  const answer = await fetch(address, { signal: AbortSignal.timeout(LONGEST) });
  const stored = answer.status === 200 ? ((await answer.json()) as Placed) : undefined;
  return { stored: stored && isOf(graph, stored) ? stored : undefined, put: answer.headers.get("allow")?.includes("PUT") ? address : "" };
}

/** The hash of a graph, and of the program that places it. */
async function keyOf(graph: ElkNode): Promise<string> {
  const text = JSON.stringify([new URL(program, location.href).pathname, graph]);
  const digest = await crypto.subtle.digest("SHA-256", new TextEncoder().encode(text));
  return [...new Uint8Array(digest)].map((octet) => octet.toString(16).padStart(2, "0")).join("");
}

const isGroup = (node: ElkNode): boolean => node.children !== undefined;

/** The boxes of a graph, also those within groups. */
const boxesOf = (graph: ElkNode, x = 0, y = 0): Placed["boxes"] =>
  (graph.children ?? []).flatMap((each) => {
    const at = [x + (each.x ?? 0), y + (each.y ?? 0)] as const;
    return isGroup(each) ? boxesOf(each, ...at) : [[each.id, ...at] as const];
  });

function isOf(graph: ElkNode, { boxes }: Placed): boolean {
  const names = new Set(boxes.map(([name]) => name));
  const wanted = boxesOf(graph);
  return wanted.length === boxes.length && wanted.every(([name]) => names.has(name));
}

function compact(placed: ElkNode): Placed {
  const { children = [], edges = [], width = 0, height = 0 } = placed;
  // Between groups, corners are relative to the nodes around them: such wires are routed on the page.
  const routed = children.some(isGroup) ? [] : edges;
  const pair = ({ x, y }: ElkPoint) => [x, y] as const;
  const wires = routed.map(({ id, sections = [] }) => {
    const points = sections.flatMap((each) => [each.startPoint, ...(each.bendPoints ?? []), each.endPoint]);
    return [id, points.map(pair)] as const;
  });
  return { width, height, boxes: boxesOf(placed), wires };
}

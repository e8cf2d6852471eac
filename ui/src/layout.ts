/** Places for boxes that have none, by the layered algorithm of ELK. */

import type { ElkNode } from "elkjs/lib/elk-api";
import type { Component, Connection, Location } from "./protocol/Ui.ts";

export const WIDTH = 240;
export const HEADER = 44;
export const ROW = 22;
/** RT System Editor, whose places these are, has narrower boxes. */
const SPREAD = 1.5;

export const shown = ({ x, y }: Location): Location => ({ x: x * SPREAD, y });
export const stored = ({ x, y }: Location): Location => ({ x: x / SPREAD, y });

export function height(component: Component): number {
  const count = (kind: string) => component.ports.filter((port) => port.kind === kind).length;
  return HEADER + ROW * (Math.max(count("PORT_IN"), count("PORT_OUT")) + count("PORT_SERVICE")) + 8;
}

export async function layout(
  components: readonly Component[],
  connections: readonly Connection[],
): Promise<Map<string, { x: number; y: number }>> {
  const { default: ELK } = await import("elkjs/lib/elk.bundled.js");
  const known = new Set(components.map((each) => each.instance));
  const graph: ElkNode = {
    id: "system",
    layoutOptions: {
      "elk.algorithm": "layered",
      "elk.direction": "RIGHT",
      "elk.spacing.nodeNode": "40",
      "elk.layered.spacing.nodeNodeBetweenLayers": "90",
      "elk.layered.considerModelOrder.strategy": "NODES_AND_EDGES",
    },
    children: components.map((each) => ({
      id: each.instance,
      width: WIDTH,
      height: height(each),
      layoutOptions: { "elk.portConstraints": "FIXED_ORDER" },
      ports: each.ports.map((port, i) => ({
        id: `${each.instance}.${port.name}`,
        width: 1,
        height: 1,
        layoutOptions: {
          "elk.port.side": port.kind === "PORT_OUT" ? "EAST" : "WEST",
          "elk.port.index": String(port.kind === "PORT_OUT" ? i : each.ports.length * 2 - i),
        },
      })),
    })),
    edges: connections
      .filter((each) => known.has(each.source.instance) && known.has(each.target.instance))
      .map((each) => ({
        id: each.name,
        sources: [`${each.source.instance}.${each.source.port}`],
        targets: [`${each.target.instance}.${each.target.port}`],
      })),
  };
  const placed = await new ELK().layout(graph);
  return new Map((placed.children ?? []).map((each) => [each.id, { x: each.x ?? 0, y: each.y ?? 0 }]));
}

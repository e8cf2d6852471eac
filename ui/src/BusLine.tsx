/** A CAN bus below the boxes: a line with its nodes and their components. */

import type { Node, NodeProps } from "@xyflow/react";
import type { CSSProperties } from "react";
import { useContext } from "react";
import { Inspecting } from "./Inspector.tsx";
import type { Line } from "./lines.ts";
import type { Point } from "./layout.ts";
import { BESIDE, NODE, widest } from "./layout.ts";
import { t } from "./texts.ts";

/** Start of a component's line, relative to the upper left of the bus. */
export interface Drop extends Point {
  /** Where the line goes down to the bus. */
  down: number;
  chosen: boolean;
}

/** The distance from the bus where the lines of a node turn, so that those of several nodes do not coincide [px]. */
const turn = (node: number): number => 5 + 3 * (node % 6);

export interface BusData extends Record<string, unknown> {
  line: Line;
  width: number;
  /** The position of each node, and the lines of its components. */
  nodes: readonly { x: number; proxies: readonly Drop[]; devices: readonly Drop[] }[];
}

export type BusNode = Node<BusData, "bus">;

const COLOURS = new Map([
  ["operational", "STATE_ACTIVE"],
  ["pre-operational", "STATE_INACTIVE"],
  ["stopped", "STATE_ERROR"],
]);

export function BusLine({ data: { line, width, nodes } }: NodeProps<BusNode>) {
  const inspect = useContext(Inspecting);
  return (
    <section className="bus-line" aria-label={t("Bus {name}", { name: line.name })} style={{ width }}>
      <svg aria-hidden width={width} height={NODE.height} overflow="visible">
        {nodes.map(({ x, proxies, devices }, node) =>
          [...proxies, ...devices].map((each, i) => (
            <path
              key={`${x} ${i}`}
              className={`drop ${i < proxies.length ? "proxy" : ""} ${each.chosen ? "chosen" : ""}`}
              d={each.y < 0 ? `M${each.x},${each.y} ${each.down === each.x ? "" : `V${each.y + BESIDE} H${each.down} `}V${-turn(node)} H${x} V0` : `M${x},${NODE.height} L${each.x},${each.y}`}
            />
          )),
        )}
      </svg>
      <span className="bus-name">
        <bdi>{line.name}</bdi>
        {line.bitRate > 0 && ` ${line.bitRate / 1000} kbit/s`}
      </span>
      {line.nodes.map((node, i) => (
        <button
          key={node.id}
          type="button"
          className={`bus-node nodrag nopan state ${COLOURS.get(node.nmtState) ?? "STATE_CREATED"}`}
          style={{ left: nodes[i]!.x - NODE.width / 2, width: NODE.width, height: NODE.height, "--wide": `${NODE.width}px`, "--widest": widest([`${node.id} ${node.name}`]) } as CSSProperties}
          aria-label={t("{id} {name} {state}, node of {bus}", { id: node.id, name: node.name, state: node.nmtState || t("unknown"), bus: line.name })}
          title={[`${node.id} ${node.name}`, node.nmtState, ...node.proxies.map((each) => t("proxy {each}", { each })), ...node.devices.map((each) => t("device {each}", { each }))].filter(Boolean).join("\n")}
          onClick={() => inspect({ kind: "node", bus: line.name, id: node.id })}
        >
          <strong>
            {node.id} <bdi>{node.name}</bdi>
          </strong>{" "}
          <small>{node.nmtState || t("unknown")}</small>
        </button>
      ))}
    </section>
  );
}

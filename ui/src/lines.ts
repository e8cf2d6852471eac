/** CAN buses as lines: their nodes, and the components that are proxies of nodes, or nodes themselves. */

import type { Bus, Component } from "./protocol/Ui.ts";

export interface LineNode {
  id: number;
  name: string;
  /** NMT state as named by CiA 301; empty: unknown. */
  nmtState: string;
  /** Instances of the node's proxies. */
  proxies: string[];
  /** Instances that are the node itself: devices, or the manager. */
  devices: string[];
}

export interface Line {
  name: string;
  bitRate: number;
  nodes: LineNode[];
}

/** The name that bus files give the node of the manager. */
const MANAGER = "manager";

/** The parameters by which a component of CANopen joins its bus, with the values of its active set. */
function settings(component: Component): ReadonlyMap<string, string> {
  const set = component.configuration_sets.find((each) => each.name === component.active_set);
  return new Map(component.parameters.map((each) => [each.name, set?.values.find((one) => one.name === each.name)?.text ?? each.default_value]));
}

/** The lines of active buses, and of buses named by parameters of components. */
export function linesOf(components: readonly Component[], buses: readonly Bus[]): Line[] {
  const lines = new Map(
    buses.map((bus) => [
      bus.name,
      {
        name: bus.name,
        bitRate: bus.bit_rate,
        nodes: bus.nodes.map((each) => ({ id: each.node_id, name: each.name, nmtState: each.nmt_state, proxies: [] as string[], devices: [] as string[] })),
      },
    ]),
  );
  for (const component of components) {
    if (!component.parameters.some((each) => each.name === "channel") || !component.parameters.some((each) => each.name === "network")) continue;
    const found = settings(component);
    const name = found.get("channel")!;
    const line = lines.get(name) ?? { name, bitRate: 0, nodes: [] };
    lines.set(name, line);
    const id = found.has("node_id") ? Number(found.get("node_id")) : undefined;
    let node = line.nodes.find((each) => (id === undefined ? each.name === MANAGER : each.id === id));
    if (!node) {
      if (id === undefined) continue;
      node = { id, name: `node ${id}`, nmtState: "", proxies: [], devices: [] };
      line.nodes.push(node);
    }
    node[found.has("boot_timeout") ? "proxies" : "devices"].push(component.instance);
  }
  return [...lines.values()].map((line) => ({ ...line, nodes: line.nodes.sort((a, b) => a.id - b.id) }));
}

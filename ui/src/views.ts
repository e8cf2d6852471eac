/** The views of the workspace, and how their panes are written in the address. */

import type { SplitNode, SplitNodeInput, TabNode, TabsetNode, TabsetNodeInput } from "react-resizable-panels";
import type { SystemState } from "./protocol/Ui.ts";
import { linesOf } from "./lines.ts";
import { t } from "./texts.ts";

/** Views of the selected component, or of the system while none is selected. */
export const COMPONENT = ["Values", "Connections", "Configuration", "Services"] as const;
export const SYSTEM = ["Plots", "Map", "Drive", "Buses", "Boards", "Console", "Timeline"] as const;
export const VIEWS = ["Wiring", ...COMPONENT, ...SYSTEM, "Palette"] as const;
export type View = (typeof VIEWS)[number];

const TITLES: Readonly<Record<View, string>> = {
  Wiring: t("Wiring"),
  Values: t("Values"),
  Connections: t("Connections"),
  Configuration: t("Configuration"),
  Services: t("Services"),
  Plots: t("Plots"),
  Map: t("Map"),
  Drive: t("Drive"),
  Buses: t("Buses"),
  Boards: t("Boards"),
  Console: t("Console"),
  Timeline: t("Timeline"),
  Palette: t("Palette"),
};
export const titleOf = (view: View): string => TITLES[view];

/** Sizes are percentages of the split; those of one that has none are equal. */
export type Tree = TabsetNodeInput<View> | SplitNodeInput<View>;

export const isView = (name: string): name is View => (VIEWS as readonly string[]).includes(name);
export const isOfComponent = (view: View): boolean => (COMPONENT as readonly string[]).includes(view);

/** Why a view has nothing to show; empty if it has something. */
export function emptiness(view: View, { components, buses }: Pick<SystemState, "components" | "buses">, calls: number): string {
  if (view === "Buses" && !linesOf(components, buses).length) return t("There is no CAN bus.");
  if (view === "Boards" && !calls) return t("No board has been called.");
  return "";
}

export const tabOf = (view: View): TabNode<View> => ({ id: view, title: titleOf(view), data: view });

export function pane(views: readonly View[], size?: number | string, selected?: View): TabsetNodeInput<View> {
  return { type: "tabset", tabs: views.map(tabOf), ...(size !== undefined && { size }), ...(selected && { selectedId: selected }) };
}

export function split(orientation: "horizontal" | "vertical", children: Tree[], size?: number | string): SplitNodeInput<View> {
  return { type: "split", orientation, children, ...(size !== undefined && { size }) };
}

const others = (...shown: View[]): View[] => VIEWS.filter((each) => each !== "Palette" && !shown.includes(each));

/** Panes for a purpose, by its name; the first one is the main pane. */
export const PRESETS: Readonly<Record<string, () => Tree>> = {
  Wire: () => split("horizontal", [pane(["Wiring"]), pane(others("Wiring"), "400px")]),
  Drive: () => split("horizontal", [pane(["Map"], 60), split("vertical", [pane(["Drive"], 45), pane(["Wiring", ...others("Map", "Drive", "Wiring")], 55)], 40)]),
  Bus: () => split("horizontal", [pane(["Buses"], 55), split("vertical", [pane(["Wiring"], 50), pane(others("Buses", "Wiring"), 50, "Timeline")], 45)]),
  Compare: () => split("horizontal", [pane(["Plots"], 50), split("vertical", [pane(["Values", ...others("Plots", "Values", "Timeline")], 60), pane(["Timeline"], 40)], 50)]),
};

/** The view for which a preset is; one that is not named is for all of a system. */
const PURPOSES: Readonly<Record<string, View>> = { Bus: "Buses" };

/** Why a preset is of no use; `emptiness` says it of a view. */
export const obstacleToPreset = (name: string, emptiness: (view: View) => string): string => (PURPOSES[name] ? emptiness(PURPOSES[name]) : "");

/** The names of the presets as people read them. */
export const LAYOUTS: Readonly<Record<string, string>> = { Wire: t("Wire"), Drive: t("Drive"), Bus: t("Bus"), Compare: t("Compare") };

type Node = TabsetNode<View> | SplitNode<View>;

/** The panes of a tree, the main one first. */
export function panes(node: Node): TabsetNode<View>[] {
  return node.type === "tabset" ? [node] : node.children.flatMap(panes);
}

/** A tree in which a view has exchanged its place with the one that the main pane shows. */
export function exchanged(root: Node, view: View): Node {
  const [main] = panes(root);
  const shown = (main!.selectedId ?? main!.tabs[0]!.id) as View;
  const other = (id: string) => (id === view ? shown : id === shown ? view : id) as View;
  const map = (node: Node): Node =>
    node.type === "split"
      ? { ...node, children: node.children.map(map) }
      : { ...node, tabs: node.tabs.map(({ id }) => tabOf(other(id))), ...(node.selectedId && { selectedId: other(node.selectedId) }) };
  return map(root);
}

/** A tree as text: `(Wiring~72,(Values+Map*~50/Timeline~50)~28)`: panes beside (,) and below (/) each other, in each the views, the shown one with *, and its share. */
export function written(node: Node | Tree): string {
  const share = typeof node.size === "number" ? `~${Math.round(node.size * 10) / 10}` : typeof node.size === "string" ? `~${node.size}` : "";
  if (node.type === "split") return `(${node.children.map(written).join(node.orientation === "horizontal" ? "," : "/")})${share}`;
  const shown = node.selectedId ?? node.tabs[0]?.id;
  return node.tabs.map(({ id }) => (id === shown && node.tabs.length > 1 ? `${id}*` : id)).join("+") + share;
}

/** Whether a view is seen in panes of this text. */
export const isSeen = (text: string, view: View): boolean => new RegExp(`(^|[(,/])${view}(?![A-Za-z+])|${view}\\*`).test(text);

/** A tree of a text; undefined if it is none. Views that are named twice, or unknown, are left out. */
export function read(text: string): Tree | undefined {
  const seen = new Set<View>();
  let at = 0;
  const size = (): number | string | undefined => {
    const found = /^~(\d+(?:\.\d+)?)(px)?/.exec(text.slice(at));
    at += found?.[0].length ?? 0;
    return found ? (found[2] ? `${found[1]}px` : Number(found[1])) : undefined;
  };
  const node = (depth: number): Tree | undefined => {
    if (text[at] !== "(") {
      const [names] = /^[A-Za-z*+]*/.exec(text.slice(at))!;
      at += names.length;
      const named = names.split("+").map((each) => [each.replace("*", ""), each.endsWith("*")] as const);
      const views = named.flatMap(([name]) => (isView(name) && !seen.has(name) ? (seen.add(name), [name]) : []));
      const share = size();
      return views.length ? pane(views, share, views.find((view) => named.some(([name, shown]) => shown && name === view))) : undefined;
    }
    at++;
    const children: Tree[] = [];
    let mark = "";
    for (;;) {
      const child = depth > 0 ? node(depth - 1) : undefined;
      if (child) children.push(child);
      if (text[at] !== "," && text[at] !== "/") break;
      mark = text[at++]!;
    }
    if (text[at++] !== ")") return undefined;
    const share = size();
    return children.length > 1 ? split(mark === "/" ? "vertical" : "horizontal", children, share) : children[0];
  };
  const found = node(DEEPEST);
  return at === text.length ? found : undefined;
}

const DEEPEST = 6;

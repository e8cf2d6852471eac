/** The command palette: each command, component, view and system by its name. */

import { Command } from "cmdk";
import type { Command as Order, Component, SystemState } from "./protocol/Ui.ts";
import { stateOf, store } from "./store.ts";
import type { View } from "./views.ts";
import { PRESETS, VIEWS } from "./views.ts";

/** How well a name has all words of a search: best at its beginning, then at that of its words; 0: not. */
function rank(name: string, search: string): number {
  const [text, words] = [name.toLowerCase(), search.toLowerCase().trim().split(/\s+/)];
  if (!words.every((word) => text.includes(word))) return 0;
  if (text.startsWith(words[0]!)) return 1;
  return words.every((word) => text.includes(` ${word}`)) ? 0.8 : 0.5;
}

interface Props {
  system: SystemState;
  full: boolean;
  component: Component | undefined;
  close: () => void;
  select: (instance: string) => void;
  open: (view: View) => void;
  /** Undefined where there is no room for panes. */
  arrange: ((name: string) => void) | undefined;
  help: () => void;
  rename: (instance: string) => void;
}

export function Commands({ system, full, component, close, select, open, arrange, help, rename }: Props) {
  const { time, edits } = system;
  const simulated = time.kind === "CLOCK_SIMULATED";
  const item = (name: string, act: () => void, keys = "", more = "") => (
    <Command.Item
      key={name}
      value={name}
      onSelect={() => {
        close();
        act();
      }}
    >
      <span>{name}</span>
      <small>{more}</small>
      {keys && <kbd>{keys}</kbd>}
    </Command.Item>
  );
  const order = (name: string, asked: Order, keys = "", more = "") => item(name, () => void store.order(asked), keys, more);
  return (
    <Command.Dialog open onOpenChange={(shown) => shown || close()} label="Find a command" overlayClassName="veil" contentClassName="dialog commands" filter={rank} loop>
      <Command.Input placeholder="Command, component, view, system" />
      <Command.List>
        <Command.Empty>Nothing has this name.</Command.Empty>
        {full && (
          <Command.Group heading="Run">
            {simulated && order(time.playing ? "Pause" : "Play", time.playing ? { case: "paused", value: true } : { case: "played", value: true }, "Space")}
            {simulated && !time.playing && order("Step", { case: "step", value: 0 }, ".")}
            {simulated && order("Go to the beginning", { case: "time", value: 0 })}
            {order("Activate all", { case: "activated", value: [] })}
            {order("Deactivate all", { case: "deactivated", value: [] })}
            {order("Reset all", { case: "restored", value: [] })}
            {edits.undo && order("Undo", { case: "undone", value: true }, "Ctrl Z", edits.undo)}
            {edits.redo && order("Redo", { case: "redone", value: true }, "Ctrl Y", edits.redo)}
          </Command.Group>
        )}
        {component && full && (
          <Command.Group heading={component.instance}>
            {order(`Activate ${component.instance}`, { case: "activated", value: [component.instance] })}
            {order(`Deactivate ${component.instance}`, { case: "deactivated", value: [component.instance] })}
            {order(`Reset ${component.instance}`, { case: "restored", value: [component.instance] })}
            {!component.place && item(`Rename ${component.instance}`, () => rename(component.instance), "F2")}
          </Command.Group>
        )}
        <Command.Group heading="Components">
          {component && item("Overview", () => select(""))}
          {system.components.map((each) => item(`Select ${each.instance}`, () => select(each.instance), "", `${each.type}, ${stateOf(each)}`))}
        </Command.Group>
        <Command.Group heading="Views">
          {VIEWS.map((view) => (view === "Palette" ? item("Palette of components", () => open(view)) : item(`View ${view}`, () => open(view))))}
          {arrange && Object.keys(PRESETS).map((name) => item(`Layout ${name}`, () => arrange(name)))}
          {item("Keys", help, "?")}
        </Command.Group>
        {full && system.systems.length > 1 && edits.saved && (
          <Command.Group heading="Systems">{system.systems.map((file) => order(`Open ${file}`, { case: "system", value: file }))}</Command.Group>
        )}
        {full && (
          <Command.Group heading="Add">
            {system.palette.map(({ type, category }) => order(`Add ${type}`, { case: "added", value: { type, instance: "", placed: false, where: { x: 0, y: 0 } } }, "", category))}
          </Command.Group>
        )}
      </Command.List>
    </Command.Dialog>
  );
}

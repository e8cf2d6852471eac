/** The command palette: each command, component, view and system by its name. */

import { Command } from "cmdk";
import type { Next } from "./Compare.tsx";
import type { Command as Order, Component, SystemState } from "./protocol/Ui.ts";
import { useFocusBack } from "./kit/focus.ts";
import { STEP, obstacleToAll, stateOf, store } from "./store.ts";
import { languages, t } from "./texts.ts";
import type { View } from "./views.ts";
import { COMPONENT, LAYOUTS, PRESETS, SYSTEM, obstacleToPreset, titleOf } from "./views.ts";

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
  /** What to do next with two runs. */
  next: Next | undefined;
  close: () => void;
  select: (instance: string) => void;
  open: (view: View) => void;
  /** Undefined where there is no room for panes. */
  arrange: ((name: string) => void) | undefined;
  /** Why a view has nothing to show. */
  emptiness: (view: View) => string;
  help: () => void;
  rename: (instance: string) => void;
}

export function Commands({ system, full, component, next, close, select, open, arrange, emptiness, help, rename }: Props) {
  useFocusBack();
  const { time, edits } = system;
  const simulated = time.kind === "CLOCK_SIMULATED";
  const obstacle = obstacleToAll(system);
  const item = (name: string, act: () => void, keys = "", more = "", disabled = false) => (
    <Command.Item
      key={name}
      value={name}
      disabled={disabled}
      onSelect={() => {
        close();
        act();
      }}
    >
      <span>{name}</span>
      <small title={more}>{more}</small>
      {keys && <kbd>{keys}</kbd>}
    </Command.Item>
  );
  const order = (name: string, asked: Order, keys = "", more = "") => item(name, () => void store.order(asked), keys, more);
  const itemUnless = (obstacle: string, name: string, act: () => void) => item(name, act, "", obstacle, obstacle !== "");
  const orderAll = (name: string, asked: Order) => itemUnless(obstacle, name, () => void store.order(asked));
  const view = (view: View) => itemUnless(emptiness(view), t("View {view}", { view: titleOf(view) }), () => open(view));
  return (
    <Command.Dialog open onOpenChange={(shown) => shown || close()} label={t("Find a command")} overlayClassName="veil" contentClassName="dialog commands" filter={rank} loop>
      <Command.Input placeholder={t("Command, component, view, system")} />
      <Command.List label={t("Found")}>
        <Command.Empty>{t("Nothing has this name.")}</Command.Empty>
        {time.kind === "CLOCK_RECORDING" && (
          <Command.Group heading={t("Recording")}>
            {item(store.page.playing ? t("Pause") : t("Play"), () => store.play(!store.page.playing), "Space")}
            {item(t("Step"), () => store.step(STEP), ".")}
          </Command.Group>
        )}
        {full && (
          <Command.Group heading={t("Run")}>
            {simulated && order(time.playing ? t("Pause") : t("Play"), time.playing ? { case: "paused", value: true } : { case: "played", value: true }, "Space")}
            {simulated && !time.playing && order(t("Step"), { case: "step", value: 0 }, ".")}
            {simulated && order(t("Go to the beginning"), { case: "time", value: 0 })}
            {simulated && !system.keeps && !system.beside && order(t("Keep to compare"), { case: "kept", value: true })}
            {next?.act && item(next.name, next.act)}
            {orderAll(t("Activate all"), { case: "activated", value: [] })}
            {orderAll(t("Deactivate all"), { case: "deactivated", value: [] })}
            {orderAll(t("Reset all"), { case: "restored", value: [] })}
            {edits.undo && order(t("Undo"), { case: "undone", value: true }, "Ctrl Z", edits.undo)}
            {edits.redo && order(t("Redo"), { case: "redone", value: true }, "Ctrl Y", edits.redo)}
          </Command.Group>
        )}
        {component && full && (
          <Command.Group heading={component.instance}>
            {order(t("Activate {instance}", { instance: component.instance }), { case: "activated", value: [component.instance] })}
            {order(t("Deactivate {instance}", { instance: component.instance }), { case: "deactivated", value: [component.instance] })}
            {order(t("Reset {instance}", { instance: component.instance }), { case: "restored", value: [component.instance] })}
            {!component.place && item(t("Rename {instance}", { instance: component.instance }), () => rename(component.instance), "F2")}
          </Command.Group>
        )}
        <Command.Group heading={t("Components")}>
          {component && item(t("Overview"), () => select(""))}
          {system.components.map((each) => item(t("Select {instance}", { instance: each.instance }), () => select(each.instance), "", `${each.type}, ${stateOf(each)}`))}
        </Command.Group>
        <Command.Group heading={t("Views of the component")}>{COMPONENT.map(view)}</Command.Group>
        <Command.Group heading={t("Views of the system")}>
          {(["Wiring", ...SYSTEM] as const).map(view)}
          {item(t("Palette of components"), () => open("Palette"))}
          {arrange && Object.keys(PRESETS).map((name) => itemUnless(obstacleToPreset(name, emptiness), t("Layout {name}", { name: LAYOUTS[name] ?? name }), () => arrange(name)))}
        </Command.Group>
        <Command.Group heading={t("Page")}>
          {item(t("Keys"), help, "?")}
          {languages().map(({ name, act }) => item(name, act))}
        </Command.Group>
        {full && system.systems.length > 1 && edits.saved && (
          <Command.Group heading={t("Systems")}>{system.systems.map((file) => order(t("Open {file}", { file }), { case: "system", value: file }))}</Command.Group>
        )}
        {full && (
          <Command.Group heading={t("Add")}>
            {system.palette.map(({ type, category }) => order(t("Add {type}", { type }), { case: "added", value: { type, instance: "", placed: false, where: { x: 0, y: 0 } } }, "", category))}
          </Command.Group>
        )}
      </Command.List>
    </Command.Dialog>
  );
}

/** The keys of the page, and a window that shows them. */

import { useEffect } from "react";
import { Dialog } from "./kit/Dialog.tsx";
import type { SystemState } from "./protocol/Ui.ts";
import { STEP, store } from "./store.ts";
import { t } from "./texts.ts";

const SHOWN: readonly (readonly [string, readonly (readonly [string, string])[]])[] = [
  [t("Page"), [["Ctrl K", t("find a command, a component, a view")], ["?", t("this list")], ["Ctrl Z", t("undo")], ["Ctrl Y", t("redo")], ["Tab", t("next control")]]],
  [t("Time"), [["Space", t("play or pause")], [".", t("step to the next instant, or on in a recording")], [",", t("look back by one step")], ["L", t("back to the present")], [t("Arrows"), t("on the time line: look at another time")]]],
  [t("Wiring"), [["Enter", t("select the box or the wire that has the focus")], ["F2", t("rename what is selected")], ["Shift F10", t("menu of the box or the wire")], ["Delete", t("remove the box, cut the wire")], [t("Arrows"), t("move the box, at the places of the file")]]],
];

export function Keys({ close }: { close: () => void }) {
  return (
    <Dialog title={t("Keys")} close={close}>
      <div className="keys">
        {SHOWN.map(([part, keys]) => (
          <div key={part} className="part">
            <h3>{part}</h3>
            <dl>
              {keys.map(([key, what]) => (
                <div key={key}>
                  <dt>
                    <kbd>{key}</kbd>
                  </dt>
                  <dd>{what}</dd>
                </div>
              ))}
            </dl>
          </div>
        ))}
      </div>
    </Dialog>
  );
}

/** Whether keys are for a field, or for an open window. */
const isTyping = (e: KeyboardEvent): boolean => (e.target as HTMLElement).matches("input:not([type=range]), textarea, select, option") || document.querySelector("[role=dialog], [role=alertdialog]") !== null;

interface Bindings {
  keys: () => void;
  commands: () => void;
  rename: () => void;
}

/** Binds the keys of the whole page; fields have their own undo. */
export function useKeys(system: SystemState | undefined, full: boolean, { keys, commands, rename }: Bindings): void {
  const time = system?.time;
  const [simulated, recorded, playing, past] = [time?.kind === "CLOCK_SIMULATED", time?.kind === "CLOCK_RECORDING", time?.playing ?? false, time?.past ?? false];
  useEffect(() => {
    const onKeyDown = (e: KeyboardEvent) => {
      const key = e.key.toLowerCase();
      const held = e.ctrlKey || e.metaKey;
      const done = (act: () => void) => {
        e.preventDefault();
        act();
      };
      if (held && !e.altKey && key === "k") return done(commands);
      if (isTyping(e)) return;
      if (held && !e.altKey) {
        if (!full || (key !== "z" && key !== "y")) return;
        const undo = key === "z" && !e.shiftKey;
        return done(() => void store.order(undo ? { case: "undone", value: true } : { case: "redone", value: true }));
      }
      if (held || e.altKey) return;
      if (e.key === "?") return done(keys);
      if (e.key === "F2" && full) return done(rename);
      const onButton = (e.target as HTMLElement).closest("button, summary, [role=tab], .react-flow__node, .react-flow__edge, .stick") !== null;
      if (e.key === " " && !onButton && recorded) return done(() => store.play(!store.page.playing));
      if (e.key === "." && recorded) return done(() => store.step(STEP));
      if (e.key === " " && !onButton && simulated && full) return done(() => void store.order(playing ? { case: "paused", value: true } : { case: "played", value: true }));
      if (e.key === "." && simulated && full && !playing) return done(() => void store.order({ case: "step", value: 0 }));
      if (e.key === ",") return done(() => store.step(-STEP));
      if (key === "l" && past) return done(() => void store.look(-1));
    };
    window.addEventListener("keydown", onKeyDown);
    return () => window.removeEventListener("keydown", onKeyDown);
  }, [full, simulated, recorded, playing, past, keys, commands, rename]);
}

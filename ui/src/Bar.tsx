/** The views of a narrow page: one fills the screen, the bar below it changes it. */

import { Boxes, ChartLine, Ellipsis, Gamepad2, History, Languages, Map as MapIcon, Workflow } from "lucide-react";
import type { LucideIcon } from "lucide-react";
import { useState } from "react";
import type { ReactNode } from "react";
import { Button } from "./kit/Button.tsx";
import { Dialog } from "./kit/Dialog.tsx";
import { languages, t } from "./texts.ts";
import type { View } from "./views.ts";
import { VIEWS, isOfComponent, titleOf } from "./views.ts";

const SHOWN: readonly (readonly [View, string, LucideIcon])[] = [
  ["Wiring", t("Wiring"), Workflow],
  ["Values", t("Values"), ChartLine],
  ["Map", t("Map"), MapIcon],
  ["Drive", t("Drive"), Gamepad2],
  ["Timeline", t("Time"), History],
];

export function Bar({ shown, show, emptiness, children }: { shown: View; show: (view: View) => void; emptiness: (view: View) => string; children?: ReactNode }) {
  const [more, open] = useState(false);
  const isIn = (view: View) => view === shown || (view === "Values" && isOfComponent(shown));
  const rest = VIEWS.filter((each) => !isOfComponent(each) && !SHOWN.some(([view]) => view === each) && !emptiness(each));
  return (
    <nav className="bar" aria-label={t("Views")}>
      {SHOWN.map(([view, name, Icon]) => (
        <button key={view} type="button" aria-current={isIn(view) ? "page" : undefined} onClick={() => show(view)}>
          <Icon size={20} aria-hidden />
          {name}
        </button>
      ))}
      <button type="button" aria-haspopup="dialog" aria-current={SHOWN.some(([view]) => isIn(view)) ? undefined : "page"} onClick={() => open(true)}>
        <Ellipsis size={20} aria-hidden />
        {t("More")}
      </button>
      {more && (
        <Dialog title={t("More")} close={() => open(false)} className="more">
          <div className="choice">
            {rest.map((view) => (
              <Button
                key={view}
                icon={Boxes}
                aria-pressed={view === shown}
                onClick={() => {
                  open(false);
                  show(view);
                }}
              >
                {view === "Palette" ? t("Components") : titleOf(view)}
              </Button>
            ))}
          </div>
          {children}
          <div className="choice">
            {languages().map(({ name, act }) => (
              <Button key={name} icon={Languages} onClick={act}>
                {name}
              </Button>
            ))}
          </div>
        </Dialog>
      )}
    </nav>
  );
}

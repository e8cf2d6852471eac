/** What to do next with two runs, from the moment when a run is kept until its difference is shown. */

import type { ReactNode } from "react";
import { useState } from "react";
import { Button } from "./kit/Button.tsx";
import { addMember, plotsNow } from "./members.ts";
import { portOf } from "./MemberPlot.tsx";
import type { SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { rich } from "./rich.tsx";
import { t } from "./texts.ts";

/** Plots of this number of ports are made at first. */
const PORTS = 3;

export interface Next {
  said: ReactNode;
  /** Empty without a button. */
  name: string;
  /** Undefined where it cannot be done now. */
  act?: () => void;
}

export function useNext(system: SystemState | undefined, selected: string, full: boolean, open: () => void): Next | undefined {
  const [goal, run] = useState<string>();
  if (!system) return undefined;
  const { beside, keeps, time, channels } = system;
  if (time.kind === "CLOCK_RECORDING" || (!keeps && !beside) || (beside && store.page.differs)) return undefined;
  const again = async () => {
    run(time.now.toFixed(1));
    // Two runs of the same length are compared.
    if (time.playing) await store.order({ case: "paused", value: true });
    await store.order({ case: "time", value: time.now });
    run(undefined);
  };
  const plot = () => {
    const ports = channels.filter((each) => !each.beside && each.port.instance === selected).map(portOf);
    if (!plotsNow().size) for (const port of ports.slice(0, PORTS)) addMember("Plot 1", { port, path: "" });
    store.differ(true);
    open();
  };
  if (goal !== undefined) return { said: t("The run begins again, and goes on to {time} s.", { time: goal }), name: t("Running …") };
  if (beside) return { said: rich("Plots show this run and, dashed, {beside}.", { beside: <bdi>{beside}</bdi> }), name: t("Plot the difference"), act: plot };
  return {
    said: t("This run is kept. Change something, such as a parameter in Configuration, and run it again."),
    name: time.kind === "CLOCK_SIMULATED" ? t("Run again to {time} s", { time: time.now.toFixed(1) }) : "",
    act: full && time.now > 0 ? () => void again() : undefined,
  };
}

/** The next step above the time line. */
export function Compare({ said, name, act }: Next) {
  return (
    <p className="notice beside" role="status" aria-label={t("Two runs")}>
      <span>{said}</span>
      {name && (
        <Button look="primary" aria-disabled={!act} onClick={act}>
          {name}
        </Button>
      )}
    </p>
  );
}

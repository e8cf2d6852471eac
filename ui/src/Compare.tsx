/** What to do next with two runs: above the time line, from the moment when a run is kept until its difference is shown. */

import { Button } from "./kit/Button.tsx";
import { addMember, plotsNow } from "./members.ts";
import { portOf } from "./MemberPlot.tsx";
import type { SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { rich } from "./rich.tsx";
import { t } from "./texts.ts";

/** Plots of this number of ports are made at first. */
const PORTS = 3;

export function Compare({ system, selected, full, open }: { system: SystemState; selected: string; full: boolean; open: () => void }) {
  const { beside, keeps, time, channels } = system;
  if (time.kind === "CLOCK_RECORDING" || (!keeps && !beside) || (beside && store.page.differs)) return null;
  const again = async () => {
    const result = await store.order({ case: "time", value: 0 });
    if (result.done) await store.order({ case: "time", value: time.now });
  };
  const plot = () => {
    const ports = channels.filter((each) => !each.beside && each.port.instance === selected).map(portOf);
    if (!plotsNow().size) for (const port of ports.slice(0, PORTS)) addMember("Plot 1", { port, path: "" });
    store.differ(true);
    open();
  };
  return (
    <p className="notice beside" role="status" aria-label={t("Two runs")}>
      {beside ? (
        <>
          <span>{rich("Plots show this run and, dashed, {beside}.", { beside: <bdi>{beside}</bdi> })}</span>
          <Button look="primary" onClick={plot}>
            {t("Plot the difference")}
          </Button>
        </>
      ) : (
        <>
          <span>{t("This run is kept. Change something, such as a parameter in Configuration, and run it again.")}</span>
          {time.kind === "CLOCK_SIMULATED" && (
            <Button look="primary" disabled={!full || time.now <= 0} onClick={() => void again()}>
              {t("Run again to {time} s", { time: time.now.toFixed(1) })}
            </Button>
          )}
        </>
      )}
    </p>
  );
}

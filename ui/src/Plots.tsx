/** Plots of members of any ports together. */

import { ChartLine, Trash2 } from "lucide-react";
import { useState } from "react";
import { Button, IconButton } from "./kit/Button.tsx";
import { MemberPlot, portOf } from "./MemberPlot.tsx";
import { addMember, addPlot, memberOf, removePlot, usePlots } from "./members.ts";
import { MEMBER, Span } from "./Plot.tsx";
import type { SystemState } from "./protocol/Ui.ts";
import { rich } from "./rich.tsx";
import { t } from "./texts.ts";

/** Plots of this view, by their numbers; those of other views have other names. */
const NAME = /^Plot (\d+)$/;
const labelOf = (id: string): string => t("Plot {number}", { number: NAME.exec(id)![1]! });

export function Plots({ system }: { system: SystemState }) {
  const plots = usePlots();
  const [over, setOver] = useState(false);
  const shown = [...plots].filter(([id]) => NAME.test(id));
  const next = `Plot ${1 + Math.max(0, ...shown.map(([id]) => Number(NAME.exec(id)![1])))}`;
  const ports = [...new Set(system.channels.map(portOf))].sort();
  const choice = (id: string, label: string) => (
    <label>
      <span className="announced">{label}</span>
      <select aria-label={label} value="" onChange={(e) => e.target.value && addMember(id, { port: e.target.value, path: "" })}>
        <option value="">{t("Add a port …")}</option>
        {ports
          .filter((each) => !plots.get(id)?.some(({ port, path }) => port === each && !path))
          .map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
      </select>
    </label>
  );
  if (!ports.length) return <p>{t("No port of this system has values.")}</p>;
  return (
    <>
      <div className="toolbar">
        <Button icon={ChartLine} onClick={() => addPlot(next)}>
          {t("New plot")}
        </Button>
        <Span compared={system.beside !== ""} />
      </div>
      {shown.map(([id, members]) => (
        <section key={id} aria-label={labelOf(id)} className="card">
          <h2>{labelOf(id)}</h2>
          <MemberPlot id={id} label={labelOf(id)} system={system} added={members}>
            {choice(id, t("Add a port to {plot}", { plot: labelOf(id) }))}
            <IconButton icon={Trash2} look="plain" label={t("Remove {name}", { name: labelOf(id) })} onClick={() => removePlot(id)} />
          </MemberPlot>
          {!members.length && (
            <p className="empty">
              {t("Add a port.")} <span className="by-mouse">{t("Or drag rows here from the tables of Values.")}</span>
            </p>
          )}
        </section>
      ))}
      <div
        className={`drop-here ${over ? "over" : ""}`}
        onDragOver={(e) => {
          if (!e.dataTransfer.types.includes(MEMBER)) return;
          e.preventDefault();
          setOver(true);
        }}
        onDragLeave={() => setOver(false)}
        onDrop={(e) => {
          e.preventDefault();
          setOver(false);
          const member = memberOf(e.dataTransfer.getData(MEMBER));
          if (member) addMember(next, member);
        }}
      >
        {choice(next, t("Add a port to a new plot"))}
        <span className="by-mouse">{t("or drag a row of a table here for a new plot")}</span>
      </div>
      {system.keeps || system.beside || system.time.kind !== "CLOCK_SIMULATED" ? null : (
        <p className="empty">{rich("To compare two runs: {keep}, at the time line, then run again.", { keep: <strong>{t("Keep to compare")}</strong> })}</p>
      )}
    </>
  );
}

/** Plots of members of any ports together. */

import { ChartLine, Trash2 } from "lucide-react";
import { useState } from "react";
import { Button, IconButton } from "./kit/Button.tsx";
import { MemberPlot, portOf } from "./MemberPlot.tsx";
import { addMember, addPlot, memberOf, removePlot, usePlots } from "./members.ts";
import { MEMBER, Span } from "./Plot.tsx";
import type { SystemState } from "./protocol/Ui.ts";

/** Plots of this view, by their numbers; those of other views have other names. */
const NAME = /^Plot (\d+)$/;

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
        <option value="">Add a port …</option>
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
  if (!ports.length) return <p>No port of this system has values.</p>;
  return (
    <>
      <div className="toolbar">
        <Button icon={ChartLine} onClick={() => addPlot(next)}>
          New plot
        </Button>
        <Span />
      </div>
      {shown.map(([id, members]) => (
        <section key={id} aria-label={id} className="card">
          <h2>{id}</h2>
          <MemberPlot id={id} label={id} system={system} added={members}>
            {choice(id, `Add a port to ${id}`)}
            <IconButton icon={Trash2} look="plain" label={`Remove ${id}`} onClick={() => removePlot(id)} />
          </MemberPlot>
          {!members.length && <p className="empty">Add a port, or drag rows here from the tables of Values.</p>}
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
        {choice(next, "Add a port to a new plot")}
        <span>or drag a row of a table here for a new plot</span>
      </div>
    </>
  );
}

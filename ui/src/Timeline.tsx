/** What has happened in the run, the latest first, and what is planned: of a kind, of a component, or with words. */

import { useStated } from "./address.ts";
import type { PlannedEvent, SystemState } from "./protocol/Ui.ts";
import type { Line } from "./store.ts";
import { t } from "./texts.ts";

const KINDS: Readonly<Record<Line["kind"], string>> = {
  state: t("states"),
  error: t("errors"),
  event: t("events"),
  beside: t("compared run"),
};

/** A line, and the names in it. */
type Shown = Line & { of: readonly string[] };

const happened = (line: Line): Shown => ({ ...line, of: [line.instance] });
const planned = ({ time, kind, text }: PlannedEvent): Shown => ({ time, instance: "", text: `${kind} ${text}`, kind: "event", of: text.split(/[ .]/) });

function Lines({ lines, label }: { lines: readonly Shown[]; label: string }) {
  return (
    <ol className="timeline" aria-label={label}>
      {lines.map((line, i) => (
        <li key={lines.length - i} className={`line-${line.kind}`}>
          <time>{line.time.toFixed(3)} s</time> <bdi>{line.instance}</bdi> <bdi>{line.text}</bdi>
        </li>
      ))}
    </ol>
  );
}

export function Timeline({ lines, system: { components, plan, time } }: { lines: readonly Line[]; system: SystemState }) {
  const [kind, setKind] = useStated("kind");
  const [of, setOf] = useStated("of");
  const [filter, setFilter] = useStated("words");
  const words = filter.toLowerCase().split(/\s+/);
  const isShown = (line: Shown): boolean =>
    (!kind || line.kind === kind) && (!of || line.of.includes(of)) && words.every((word) => `${line.instance} ${line.text}`.toLowerCase().includes(word));
  const begun = plan.findIndex((each) => each.time > time.now);
  const passed = begun < 0 ? plan : plan.slice(0, begun);
  const all = [...lines.map(happened), ...passed.map(planned)];
  const next = plan.slice(passed.length).map(planned).filter(isShown);
  const instances = [...new Set([...components.map((each) => each.instance), ...lines.map((each) => each.instance), of])].filter(Boolean).sort();
  // Changes of the compared run arrive slightly later than they happened.
  const shown = all.filter(isShown).sort((a, b) => a.time - b.time).reverse();
  return (
    <>
      <div className="toolbar" role="group" aria-label={t("Filter of the timeline")}>
        <select aria-label={t("Kind")} value={Object.hasOwn(KINDS, kind) ? kind : ""} onChange={(e) => setKind(e.target.value)}>
          <option value="">{t("all kinds")}</option>
          {Object.entries(KINDS).map(([each, name]) => (
            <option key={each} value={each}>
              {name}
            </option>
          ))}
        </select>
        <select aria-label={t("Component")} value={of} onChange={(e) => setOf(e.target.value)}>
          <option value="">{t("all components")}</option>
          {instances.map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
        </select>
        <input type="search" className="grow" aria-label={t("Words")} placeholder={t("Words")} value={filter} onChange={(e) => setFilter(e.target.value)} />
      </div>
      {next[0] && (
        <details>
          <summary>{t("{count} planned, the next one at {time} s", { count: next.length, time: next[0].time.toFixed(3) })}</summary>
          <Lines lines={next} label={t("Planned")} />
        </details>
      )}
      {!shown.length && <p className="empty">{all.length ? t("The filter leaves none of {count} {count:line|lines}.", { count: all.length }) : t("Nothing has happened yet.")}</p>}
      <Lines lines={shown} label={t("Timeline")} />
    </>
  );
}

/** What has happened in the run, the latest first: of a kind, of a component, or with words. */

import { useStated } from "./address.ts";
import type { Line } from "./store.ts";
import { t } from "./texts.ts";

const KINDS: Readonly<Record<Line["kind"], string>> = {
  state: t("states"),
  error: t("errors"),
  event: t("events"),
  beside: t("compared run"),
};

export function Timeline({ lines }: { lines: readonly Line[] }) {
  const [kind, setKind] = useStated("kind");
  const [of, setOf] = useStated("of");
  const [filter, setFilter] = useStated("words");
  const words = filter.toLowerCase().split(/\s+/);
  const isShown = (line: Line): boolean =>
    (!kind || line.kind === kind) && (!of || line.instance === of) && words.every((word) => `${line.instance} ${line.text}`.toLowerCase().includes(word));
  const instances = [...new Set([...lines.map(({ instance }) => instance), of])].filter(Boolean).sort();
  // Changes of the compared run arrive slightly later than they happened.
  const shown = lines.filter(isShown).sort((a, b) => a.time - b.time).reverse();
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
      {!shown.length && <p className="empty">{lines.length ? t("The filter leaves none of {count} lines.", { count: lines.length }) : t("Nothing has happened yet.")}</p>}
      <ol className="timeline" aria-label={t("Timeline")}>
        {shown.map((line, i) => (
          <li key={shown.length - i} className={`line-${line.kind}`}>
            <time>{line.time.toFixed(3)} s</time> <bdi>{line.instance}</bdi> <bdi>{line.text}</bdi>
          </li>
        ))}
      </ol>
    </>
  );
}

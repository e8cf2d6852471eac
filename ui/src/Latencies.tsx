/** Latencies of samples along chains of connections. */

import type { Subject } from "./Inspector.tsx";
import { duration } from "./numbers.ts";
import type { Chain, Connection, SystemState } from "./protocol/Ui.ts";
import { t } from "./texts.ts";

/** Chains are listed up to this number. */
const MOST = 6;

const end = ({ instance, port }: Connection["source"]) => `${instance}.${port}`;

export const times = ({ samples, median, late, greatest }: Chain): string =>
  samples ? t("median {median}, 99 % {late}, at most {greatest}, {samples} {samples:sample|samples}", { median: duration(median), late: duration(late), greatest: duration(greatest), samples }) : t("no sample has come through yet");

/** The chains that go along a connection. */
export function chainsOf(chains: readonly Chain[], { source, target }: Connection): Chain[] {
  const [from, to] = [end(source), end(target)];
  return chains.filter(({ ports }) => ports.some((each, i) => each === from && ports[i + 1] === to));
}

export function Latencies({ chains, system, select }: { chains: readonly Chain[]; system: SystemState; select: (subject: Subject) => void }) {
  const through = chains.filter((each) => each.samples > 0n);
  if (!through.length) return null;
  /** The first connection of a chain, whose inspector has the rest. */
  const first = (chain: Chain) => system.connections.find((each) => chainsOf([chain], each).length);
  return (
    <section aria-label={t("Latency")} className="card">
      <h2>{t("Latency")}</h2>
      <ul className="plainlist">
        {through.slice(0, MOST).map((each) => {
          const wire = first(each);
          return (
            <li key={each.name}>
              {wire ? (
                <button type="button" className="link plain" onClick={() => select({ kind: "wire", name: wire.name })}>
                  <bdi>{each.name}</bdi>
                </button>
              ) : (
                <bdi>{each.name}</bdi>
              )}
              <small>{times(each)}</small>
            </li>
          );
        })}
      </ul>
    </section>
  );
}

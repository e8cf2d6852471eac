/** Why two ports are not connected: a card at the port, with the rows in which their types differ. */

import { X } from "lucide-react";
import { useId, useLayoutEffect, useRef } from "react";
import { Above } from "./kit/Above.tsx";
import { Button } from "./kit/Button.tsx";
import type { Component, PortAddress } from "./protocol/Ui.ts";
import { t } from "./texts.ts";

/** The reason in words. */
export const sentence = (reason: string): string => reason.split("\n", 1)[0]!;

/** The rows of two types side by side that differ, which the server has marked. */
export function differences(reason: string): [string, string][] {
  return reason
    .split("\n")
    .slice(1)
    .flatMap((row): [string, string][] => {
      const [, left, right = ""] = /^! (.*?) *\|(?: (.*))?$/.exec(row) ?? [];
      return left === undefined ? [] : [[left, right]];
    });
}

export interface Unfit {
  ends: readonly [PortAddress, PortAddress];
  reason: string;
  /** The port [px of the page]. */
  at: DOMRect;
}

/** Two ports in the order in which the server compares them: the OutPort or the consumer first. */
export function ordered(components: readonly Component[], here: PortAddress, there: PortAddress): [PortAddress, PortAddress] {
  const port = ({ instance, port }: PortAddress) => components.find((each) => each.instance === instance)?.ports.find((each) => each.name === port);
  const [one, other] = [port(here), port(there)];
  const isFirst = one?.kind === "PORT_OUT" || (one?.interfaces.some((each) => !each.provided) && other?.interfaces.some((each) => each.provided));
  return isFirst ? [here, there] : [there, here];
}

/** Distance between the port and the card [px]. */
const GAP = 6;
const MARGIN = 8;

export function UnfitCard({ unfit: { ends, reason, at }, close }: { unfit: Unfit; close: () => void }) {
  const card = useRef<HTMLElement>(null);
  const before = useRef(document.activeElement);
  const id = useId();
  useLayoutEffect(() => {
    const { offsetWidth, offsetHeight, style } = card.current!;
    const below = at.bottom + GAP;
    const top = below + offsetHeight + MARGIN <= window.innerHeight ? below : at.top - GAP - offsetHeight;
    style.left = `${Math.max(MARGIN, Math.min(at.left + at.width / 2 - offsetWidth / 2, window.innerWidth - offsetWidth - MARGIN))}px`;
    style.top = `${Math.max(MARGIN, top)}px`;
    card.current!.focus({ preventScroll: true });
  }, [at]);
  const end = () => {
    close();
    (before.current as HTMLElement | null)?.focus();
  };
  const rows = differences(reason);
  return (
    <Above>
      <section
        ref={card}
        className="card unfit"
        role="dialog"
        aria-labelledby={id}
        aria-describedby={rows.length ? `${id}-rows` : undefined}
        tabIndex={-1}
        onKeyDown={(e) => {
          e.stopPropagation();
          if (e.key === "Escape") end();
        }}
        onBlur={(e) => e.currentTarget.contains(e.relatedTarget) || close()}
      >
        <div className="title">
          <h2 id={id}>{sentence(reason)}</h2>
          <Button look="plain" className="icon" aria-label={t("Close the reason")} onClick={end}>
            <X size={16} aria-hidden />
          </Button>
        </div>
        {rows.length > 0 && (
          <table id={`${id}-rows`}>
            <thead>
              <tr>
                {ends.map((each, i) => (
                  <th key={i} scope="col">
                    {`${each.instance}.${each.port}`}
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>
              {rows.map((row, i) => (
                <tr key={i}>
                  {row.map((each, side) => (
                    <td key={side}>
                      <bdi>{each}</bdi>
                    </td>
                  ))}
                </tr>
              ))}
            </tbody>
          </table>
        )}
      </section>
    </Above>
  );
}

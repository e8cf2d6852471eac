/** Calls to TECS boards: octets of request and reply, and a histogram of round trips. */

import { useState } from "react";
import { briefly, duration } from "./numbers.ts";
import type { BoardCall } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";
import { hexadecimal } from "./traffic.ts";

const BINS = 12;
/** The share of round trips in front of the last bin. */
const USUAL = 0.95;
const SHOWN = 100;

const printable = (octets: Uint8Array): string => [...octets].map((each) => (each > 31 && each < 127 ? String.fromCharCode(each) : "·")).join("");
// A value stays beside its name, a unit beside its number.
const listed = (values: BoardCall["request_values"]): string => values.map((each) => `${each.name}\u00A0=\u00A0${each.text}`).join(", ");

/** Calls with their octets and decoded values. */
export function CallTable({ calls }: { calls: readonly BoardCall[] }) {
  return (
    <div className="rows" tabIndex={0}>
      <table className="calls" aria-label={t("Calls to the board")}>
        <thead>
          <tr>
            <th scope="col">{t("time [s]")}</th>
            <th scope="col">{t("octets")}</th>
            <th scope="col">{t("meaning")}</th>
          </tr>
        </thead>
        {calls.map((call, i) => (
          <tbody key={i}>
            <tr>
              <th scope="rowgroup" rowSpan={2}>
                {call.time.toFixed(3)}
              </th>
              <td className="octets">{hexadecimal(call.request)}</td>
              <td className="text" title={listed(call.request_values)}>
                {call.function ? <strong>{call.function}</strong> : t("request")} <bdi>{briefly(listed(call.request_values))}</bdi>
              </td>
            </tr>
            <tr>
              <td className="octets">{hexadecimal(call.reply)}</td>
              <td className="text" title={listed(call.reply_values)}>
                {call.error ? <span className="reason">{call.error}</span> : briefly(listed(call.reply_values)) || (call.function ? t("no values") : printable(call.reply))}
              </td>
            </tr>
          </tbody>
        ))}
      </table>
    </div>
  );
}

/** Counts of round trips [s] in bins of equal width; the last one also contains the few much longer ones. */
export function histogram(trips: readonly number[]): { edges: number[]; counts: number[] } {
  const sorted = [...trips].sort((a, b) => a - b);
  const [least, usual, most] = [0, USUAL, 1].map((part) => sorted[Math.floor(part * (sorted.length - 1))]!) as [number, number, number];
  if (least === most) return { edges: [least, most], counts: [trips.length] };
  const width = (usual - least || most - least) / (BINS - 1);
  const edges = [...Array.from({ length: BINS }, (_, i) => least + i * width), Math.max(most, least + BINS * width)];
  const counts = Array<number>(BINS).fill(0);
  for (const trip of trips) counts[Math.min(Math.floor((trip - least) / width), BINS - 1)]! += 1;
  return { edges, counts };
}

/** The measured round trips of calls. */
export function Histogram({ calls }: { calls: readonly BoardCall[] }) {
  const trips = calls.map((each) => each.round_trip).filter((each) => each >= 0);
  if (!trips.length) return null;
  const { edges, counts } = histogram(trips);
  const highest = Math.max(...counts);
  const mean = trips.reduce((sum, each) => sum + each, 0) / trips.length;
  const spread = Math.sqrt(trips.reduce((sum, each) => sum + (each - mean) ** 2, 0) / trips.length);
  const width = 360 / counts.length;
  return (
    <figure>
      <svg className="histogram" viewBox="0 0 360 130" role="img" aria-label={t("Round trips of {count} {count:call|calls}, mean {mean}", { count: trips.length, mean: duration(mean) })}>
        {counts.map((count, i) => {
          const height = (count / highest) * 100;
          return (
            <g key={i}>
              <rect x={i * width + 1} y={112 - height} width={width - 2} height={height}>
                <title>{t("{least} to {most}: {count}", { least: duration(edges[i]!), most: duration(edges[i + 1]!), count })}</title>
              </rect>
              {count > 0 && (
                <text x={(i + 0.5) * width} y={109 - height} textAnchor="middle">
                  {count}
                </text>
              )}
            </g>
          );
        })}
        <text x="0" y="126">
          {duration(edges[0]!)}
        </text>
        <text x="360" y="126" textAnchor="end">
          {counts.length > 1 && t("from {least} to {most}", { least: duration(edges.at(-2)!), most: duration(edges.at(-1)!) })}
        </text>
      </svg>
      <figcaption>
        {t("Round trips of {count} {count:call|calls}: mean {mean}, spread {spread}, least {least}, most {most}", { count: trips.length, mean: duration(mean), spread: duration(spread), least: duration(edges[0]!), most: duration(edges.at(-1)!) })}
      </figcaption>
    </figure>
  );
}

export function Board() {
  const [chosen, choose] = useState("");
  const { calls } = store.traffic;
  if (!calls.length) return <p>{t("No board has been called yet.")}</p>;
  const functions = [...new Set(calls.map((each) => each.function))].filter(Boolean).sort();
  const shown = functions.includes(chosen) ? calls.filter((each) => each.function === chosen) : calls;
  return (
    <>
      <label>
        {t("Function")}
        <select value={chosen} onChange={(e) => choose(e.target.value)}>
          <option value="">{t("all")}</option>
          {functions.map((each) => (
            <option key={each} value={each}>{each}</option>
          ))}
        </select>
      </label>
      <Histogram calls={shown} />
      <CallTable calls={shown.slice(-SHOWN).reverse()} />
    </>
  );
}

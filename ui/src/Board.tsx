/** Calls to TECS boards: octets of request and reply, and a histogram of round trips. */

import type { BoardCall } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { hexadecimal } from "./traffic.ts";

const BINS = 12;
const SHOWN = 100;

const printable = (octets: Uint8Array): string => [...octets].map((each) => (each > 31 && each < 127 ? String.fromCharCode(each) : "·")).join("");
const listed = (values: BoardCall["request_values"]): string => values.map((each) => `${each.name} = ${each.text}`).join(", ");

export function CallTable({ calls }: { calls: readonly BoardCall[] }) {
  return (
    <div className="rows">
      <table aria-label="Calls to the board">
        <thead>
          <tr>
            <th scope="col">time [s]</th>
            <th scope="col">octets</th>
            <th scope="col">meaning</th>
          </tr>
        </thead>
        <tbody>
          {calls.map((call, i) => (
            <tr key={i}>
              <td>{call.time.toFixed(3)}</td>
              <td className="octets">
                → {hexadecimal(call.request)}
                <br />← {hexadecimal(call.reply)}
              </td>
              <td className="meaning">
                {call.function} {listed(call.request_values)}
                <br />
                {call.error ? <span className="reason">{call.error}</span> : listed(call.reply_values) || printable(call.reply)}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** Counts of round trips [s] in bins of equal width. */
export function histogram(trips: readonly number[]): { least: number; width: number; counts: number[] } {
  const least = Math.min(...trips);
  const width = (Math.max(...trips) - least) / BINS;
  const counts = Array<number>(width > 0 ? BINS : 1).fill(0);
  for (const trip of trips) {
    const bin = width > 0 ? Math.min(Math.floor((trip - least) / width), BINS - 1) : 0;
    counts[bin] = (counts[bin] ?? 0) + 1;
  }
  return { least, width, counts };
}

const micro = (seconds: number): string => `${Number((seconds * 1e6).toPrecision(3))}`;

function Histogram({ trips }: { trips: readonly number[] }) {
  const { least, width, counts } = histogram(trips);
  const most = Math.max(...counts);
  const mean = trips.reduce((sum, each) => sum + each, 0) / trips.length;
  return (
    <figure>
      <svg className="histogram" viewBox="0 0 360 130" role="img" aria-label={`Round trips of ${trips.length} calls, mean ${micro(mean)} µs`}>
        {counts.map((count, i) => {
          const height = (count / most) * 100;
          const x = (i * 360) / counts.length;
          return (
            <g key={i}>
              <rect x={x + 1} y={112 - height} width={360 / counts.length - 2} height={height}>
                <title>{`${micro(least + i * width)} to ${micro(least + (i + 1) * width)} µs: ${count}`}</title>
              </rect>
              {count > 0 && (
                <text x={x + 180 / counts.length} y={109 - height} textAnchor="middle">
                  {count}
                </text>
              )}
            </g>
          );
        })}
        <text x="0" y="126">{`${micro(least)} µs`}</text>
        <text x="360" y="126" textAnchor="end">{`${micro(least + width * counts.length)} µs`}</text>
      </svg>
      <figcaption>
        Round trips of {trips.length} calls, mean {micro(mean)} µs
      </figcaption>
    </figure>
  );
}

export function Board() {
  const { calls } = store.traffic;
  const trips = calls.map((each) => each.round_trip).filter((each) => each >= 0);
  if (!calls.length) return <p>No board has been called yet.</p>;
  return (
    <>
      {trips.length > 0 && <Histogram trips={trips} />}
      <CallTable calls={calls.slice(-SHOWN).reverse()} />
    </>
  );
}

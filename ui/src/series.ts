/** Time series whose older values are thinned out when there are too many. */

import { MAX_SAMPLES } from "./protocol/Ui.ts";

/** Whether a series is full; then it keeps its newest half, and of the older one values at even distances in time. */
export const isFull = (series: readonly unknown[]): boolean => series.length >= MAX_SAMPLES;

/** Thins out a series by its times; `rows` are its values. */
export function thin(times: number[], rows: readonly unknown[][]): void {
  const half = times.length >> 1;
  const [first, last] = [times[0]!, times[half]!];
  const part = (i: number) => Math.floor(((half >> 1) * (times[i]! - first)) / (last - first || 1));
  const older = [...Array(half).keys()].filter((i) => !i || part(i) !== part(i - 1));
  for (const row of [...rows, times]) row.splice(0, half, ...older.map((i) => row[i]));
}

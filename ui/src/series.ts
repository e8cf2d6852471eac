/** Time series whose older values are thinned out when there are too many. */

import { MAX_SAMPLES } from "./protocol/Ui.ts";

/** Whether a series is full; then it keeps its newest half and every second older value. */
export const isFull = (series: readonly unknown[]): boolean => series.length >= MAX_SAMPLES;

export function thin<T>(series: T[]): void {
  const half = series.length >> 1;
  const old = series.slice(0, half).filter((_, i) => i % 2 === 0);
  series.splice(0, half, ...old);
}

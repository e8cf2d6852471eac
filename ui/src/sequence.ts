/** Sequences of frames with the time of each since the start. */

import type { SendFrame } from "./protocol/Ui.ts";
import { t } from "./texts.ts";
import { octetsOf } from "./traffic.ts";

export interface Step {
  /** Time since the start of the sequence [s]. */
  time: number;
  frame: Omit<SendFrame, "bus">;
}

const MAX_STEPS = 1000;

/** Parses `id#octets` or `id#R` in the format of candump; ids of more than three digits are extended. */
export function frameOf(text: string): Step["frame"] | undefined {
  const found = /^([\da-f]{1,8})#(r|[\da-f ]*)$/i.exec(text.trim());
  const data = found?.[2]?.toLowerCase() === "r" ? new Uint8Array() : octetsOf(found?.[2] ?? "-");
  if (!found?.[1] || !data || data.length > 8) return undefined;
  const can_id = parseInt(found[1], 16);
  return { can_id, extended: found[1].length > 3, remote: found[2]?.toLowerCase() === "r", data, period: 0 };
}

/** Parses lines `time frame`; returns a string that names an invalid line. */
export function stepsOf(text: string): Step[] | string {
  const lines = text.split("\n").map((each) => each.trim());
  const steps: Step[] = [];
  for (const [i, line] of lines.entries()) {
    if (!line) continue;
    const [time = "", rest = ""] = [line.replace(/\s.*/, ""), line.replace(/^\S+\s*/, "")];
    const frame = frameOf(rest);
    if (!frame || !/^\d+(\.\d+)?$/.test(time)) return t("line {number}: a time in seconds and a frame are needed, as 0.5 181#0102", { number: i + 1 });
    steps.push({ time: Number(time), frame });
  }
  if (steps.length > MAX_STEPS) return t("at most {count} {count:frame|frames}", { count: MAX_STEPS });
  return steps.sort((a, b) => a.time - b.time);
}

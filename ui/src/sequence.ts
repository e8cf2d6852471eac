/** Frames that are sent one after the other, each at its time since the beginning. */

import type { SendFrame } from "./protocol/Ui.ts";
import { octetsOf } from "./traffic.ts";

export interface Step {
  /** [s] since the beginning of the sequence. */
  time: number;
  frame: Omit<SendFrame, "bus">;
}

const MAX_STEPS = 1000;

/** `id#octets` or `id#R`, all hexadecimal, ids of more than three digits extended, as candump writes. */
export function frameOf(text: string): Step["frame"] | undefined {
  const found = /^([\da-f]{1,8})#(r|[\da-f ]*)$/i.exec(text.trim());
  const data = found?.[2]?.toLowerCase() === "r" ? new Uint8Array() : octetsOf(found?.[2] ?? "-");
  if (!found?.[1] || !data || data.length > 8) return undefined;
  const can_id = parseInt(found[1], 16);
  return { can_id, extended: found[1].length > 3, remote: found[2]?.toLowerCase() === "r", data, period: 0 };
}

/** The steps of lines `time frame`; a string says which line is wrong. */
export function stepsOf(text: string): Step[] | string {
  const lines = text.split("\n").map((each) => each.trim());
  const steps: Step[] = [];
  for (const [i, line] of lines.entries()) {
    if (!line) continue;
    const [time = "", rest = ""] = [line.replace(/\s.*/, ""), line.replace(/^\S+\s*/, "")];
    const frame = frameOf(rest);
    if (!frame || !/^\d+(\.\d+)?$/.test(time)) return `line ${i + 1}: a time in seconds and a frame are needed, as 0.5 181#0102`;
    steps.push({ time: Number(time), frame });
  }
  if (steps.length > MAX_STEPS) return `at most ${MAX_STEPS} frames`;
  return steps.sort((a, b) => a.time - b.time);
}

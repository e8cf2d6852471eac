/** The newest traffic of buses and boards: frames, signals, loads, calls. */

import type { BoardCall, BusLoad, Frame } from "./protocol/Ui.ts";
import { isFull, thin } from "./series.ts";

const MAX_FRAMES = 1000;
const MAX_SIGNALS = 512;
const MAX_EMERGENCIES = 200;
const MAX_LOADS = 600;
const MAX_CALLS = 1000;

export interface Signal {
  bus: string;
  name: string;
  unit: string;
  times: number[];
  numbers: number[];
}

export class Traffic {
  readonly frames: Frame[] = [];
  readonly emergencies: Frame[] = [];
  /** Signals by bus and `NODE KIND.NAME`. */
  readonly signals = new Map<string, Signal>();
  readonly loads = new Map<string, BusLoad[]>();
  readonly calls: BoardCall[] = [];
  /** Texts of the frames that this page sends cyclically, by bus and identifier. */
  readonly cyclic = new Map<string, { bus: string; text: string }>();
  /** Number of all calls, including those that are no longer kept. */
  callCount = 0;

  frame(frame: Frame): void {
    append(this.frames, frame, MAX_FRAMES);
    if (frame.kind === "emcy") append(this.emergencies, frame, MAX_EMERGENCIES);
    for (const field of frame.fields) {
      if (!field.numeric) continue;
      const name = `${frame.node_id < 0 ? "" : frame.node_id} ${frame.kind}.${field.name}`;
      const key = JSON.stringify([frame.bus, name]);
      let signal = this.signals.get(key);
      if (!signal) {
        if (this.signals.size >= MAX_SIGNALS) continue;
        signal = { bus: frame.bus, name, unit: field.unit, times: [], numbers: [] };
        this.signals.set(key, signal);
      }
      if (isFull(signal.times)) for (const row of [signal.times, signal.numbers]) thin(row);
      signal.times.push(frame.time);
      signal.numbers.push(field.number);
    }
  }

  load(load: BusLoad): void {
    const loads = this.loads.get(load.bus) ?? [];
    this.loads.set(load.bus, loads);
    append(loads, load, MAX_LOADS);
  }

  call(call: BoardCall): void {
    this.callCount += 1;
    append(this.calls, call, MAX_CALLS);
  }

  /** The kept calls after the first `count`. */
  callsSince(count: number): BoardCall[] {
    return count === this.callCount ? [] : this.calls.slice(count - this.callCount);
  }
}

function append<T>(list: T[], item: T, most: number): void {
  if (list.push(item) > most) list.shift();
}

export function hexadecimal(octets: Uint8Array): string {
  return [...octets].map((each) => each.toString(16).padStart(2, "0")).join(" ");
}

/** Parses octets in pairs of hexadecimal digits; undefined for other texts. */
export function octetsOf(text: string): Uint8Array | undefined {
  const digits = text.replace(/\s+/g, "");
  if (!/^(?:[\da-f]{2})*$/i.test(digits)) return undefined;
  return Uint8Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16));
}

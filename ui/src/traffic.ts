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
  /** The newest value in words, with its unit. */
  text: string;
  times: number[];
  numbers: number[];
}

/** A frame, beside the one before it with the same identifier. */
export interface Seen {
  frame: Frame;
  /** Whether each octet differs from that of the frame before; empty for the first one. */
  changed: readonly boolean[];
  /** Time since the frame before [s]; NaN for the first one. */
  period: number;
  /** Number of frames with this identifier until now. */
  count: number;
}

export const identifierOf = (frame: Frame): string => frame.can_id.toString(16).toUpperCase().padStart(frame.extended ? 8 : 3, "0");

/** A frame in words: names, values and units. */
export const wordsOf = (frame: Frame): string => frame.text || frame.fields.map((each) => `${each.name} = ${each.text}`).join(", ");

const MAX_IDENTIFIERS = 4096;

export class Traffic {
  readonly frames: Seen[] = [];
  /** The newest frame of each bus and identifier. */
  readonly newest = new Map<string, Seen>();
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
    const own = `${identifierOf(frame)} ${frame.bus}`;
    const before = this.newest.get(own);
    const seen = {
      frame,
      changed: before ? [...frame.data].map((octet, i) => octet !== before.frame.data[i]) : [],
      period: before ? frame.time - before.frame.time : NaN,
      count: (before?.count ?? 0) + 1,
    };
    append(this.frames, seen, MAX_FRAMES);
    if (before || this.newest.size < MAX_IDENTIFIERS) this.newest.set(own, seen);
    if (frame.kind === "emcy") append(this.emergencies, frame, MAX_EMERGENCIES);
    for (const field of frame.fields) {
      if (!field.numeric) continue;
      const name = `${frame.node_id < 0 ? "" : frame.node_id} ${frame.kind}.${field.name}`;
      const key = JSON.stringify([frame.bus, name]);
      let signal = this.signals.get(key);
      if (!signal) {
        if (this.signals.size >= MAX_SIGNALS) continue;
        signal = { bus: frame.bus, name, unit: field.unit, text: field.text, times: [], numbers: [] };
        this.signals.set(key, signal);
      }
      if (isFull(signal.times)) thin(signal.times, [signal.numbers]);
      signal.text = field.text;
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

/** State of the page: the system as described by the events of the server. */

import { ClientMessage, ServerMessage, VERSION } from "./protocol/Ui.ts";
import type { Chain, Channel, Command, Component, Connection, Event, Flow, Result, SystemState } from "./protocol/Ui.ts";
import { CdrError, decode, deserialize, encode } from "./protocol/_cdr.ts";
import { TypeTable } from "./protocol/table.ts";
import { isFull, thin } from "./series.ts";
import { Traffic } from "./traffic.ts";
import { language, t } from "./texts.ts";
import { token } from "./token.ts";

export interface Line {
  time: number;
  instance: string;
  text: string;
  /** What the line is about, by which its mark on the time line is drawn. */
  kind: "state" | "error" | "event" | "beside";
}

/** A line of the console. */
export interface Said {
  number: number;
  /** Time of the day. */
  when: string;
  kind: string;
  text: string;
}

export interface Statistics {
  ticks: bigint;
  overruns: bigint;
  lost: bigint;
  awaited: string;
  impaired: string;
}

/** The newest value of a channel, and its numbers over time. */
export interface Track {
  value: unknown;
  times: number[];
  numbers: Map<string, number[]>;
  /** The newest values, and some of the older ones. */
  fresh: unknown[];
  /** Number of all values received. */
  count: number;
  /** Whether older values are left out. */
  thinned: boolean;
  /** Why the newest sample could not be read; empty: it could. */
  refused: string;
}

export interface Page {
  link: "connecting" | "live" | "lost" | "refused";
  full: boolean;
  system: SystemState | undefined;
  statistics: ReadonlyMap<string, Statistics>;
  lines: readonly Line[];
  said: readonly Said[];
  /** States in the compared run, by instance. */
  beside: ReadonlyMap<string, string>;
  /** The counts of samples, by connection. */
  flows: ReadonlyMap<string, Flow>;
  /** How many samples were lost, by connections that lose some: the same map while no more are lost. */
  lost: ReadonlyMap<string, bigint>;
  /** The latencies of chains of connections. */
  chains: readonly Chain[];
  notice: string;
  /** The last change of the wiring as text, for screen readers. */
  announced: string;
  /** The duration shown by plots [s]; 0: the whole run. */
  span: number;
  /** Whether plots show the difference to the compared run. */
  differs: boolean;
  /** The times that plots are zoomed to [s]. */
  zoom: readonly [number, number] | undefined;
  /** Whether a recording is played. */
  playing: boolean;
}

/** The step by which one looks back, or on in a recording [s]. */
export const STEP = 0.1;

/** The kinds of lines of the console, in words. */
const KINDS: Readonly<Record<string, string>> = {
  asked: t("asked"),
  call: t("call"),
  end: t("end"),
  error: t("error"),
  found: t("found"),
  lost: t("lost"),
  notice: t("notice"),
  overrun: t("overrun"),
  refused: t("refused"),
  skipped: t("skipped"),
  waiting: t("waiting"),
  warning: t("warning"),
};
export const kindOf = (kind: string): string => (Object.hasOwn(KINDS, kind) ? KINDS[kind]! : kind);

/** Kinds of notices that are failures. */
const FAILURES = ["error", "end", "lost", "overrun"];
const MAX_LINES = 500;
const RECONNECT_AFTER = 1000;

const unavailable: Page = {
  link: "connecting",
  full: false,
  system: undefined,
  statistics: new Map(),
  lines: [],
  said: [],
  beside: new Map(),
  flows: new Map(),
  lost: new Map(),
  chains: [],
  notice: "",
  announced: "",
  span: 0,
  differs: false,
  zoom: undefined,
  playing: false,
};

/** The id of the first channel; each run assigns new ones. */
const begun = (system: SystemState | undefined) => system?.channels[0]?.id;

export class Store {
  page: Page = unavailable;
  readonly tracks = new Map<number, Track>();
  types = new TypeTable();
  traffic = new Traffic();
  private server = "";
  private socket: WebSocket | undefined;
  private request = 0;
  private readonly waiting = new Map<number, (result: Result) => void>();
  private readonly listeners = new Set<() => void>();
  private watched: number[] = [];
  private readonly watches = new Set<readonly number[]>();
  private subscribing = false;
  /** The time to request next, while a request is pending. */
  private wanted: number | undefined;
  private looking = false;
  /** Whether the current events describe the past, which is not announced. */
  private retelling = false;

  subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  snapshot = (): Page => this.page;

  private change(part: Partial<Page>): void {
    if (part.notice && part.notice !== this.page.notice) this.say("notice", part.notice);
    this.page = { ...this.page, ...part };
    for (const listener of this.listeners) listener();
  }

  connect(): void {
    const address = `ws://${location.host}/socket?token=${encodeURIComponent(token())}&language=${language}`;
    const socket = new WebSocket(address, "rtgen-ui.1");
    socket.binaryType = "arraybuffer";
    socket.onmessage = (message) => {
      const { events } = decode(ServerMessage, new Uint8Array(message.data as ArrayBuffer));
      this.retelling = events.some((each) => each.case === "whole");
      for (const event of events) this.take(event);
      this.change({});
    };
    socket.onclose = (closed) => {
      for (const settle of this.waiting.values())
        settle({ done: false, message: t("the connection to the server is lost") } as Result);
      this.waiting.clear();
      if (closed.code === 4401 || closed.code === 4403) {
        this.change({ link: "refused", notice: t("The server refuses this address: its token is not valid. Open the address that `rtgen ui` has printed.") });
        return;
      }
      this.change({ link: "lost", notice: t("The server has ended. Looking for it again.") });
      setTimeout(() => this.connect(), RECONNECT_AFTER);
    };
    this.socket = socket;
  }

  private said = 0;

  private say(kind: string, text: string): void {
    const line = { number: this.said++, when: new Date().toLocaleTimeString(), kind, text };
    this.page = { ...this.page, said: [...this.page.said, line].slice(-MAX_LINES) };
  }

  /** Sends a command; events describe its effects, the result its success. */
  ask(asked: Command): Promise<Result> {
    const request = ++this.request;
    return new Promise<Result>((settle) => {
      if (this.socket?.readyState !== WebSocket.OPEN) {
        settle({ done: false, message: t("there is no connection to the server") } as Result);
        return;
      }
      this.waiting.set(request, settle);
      this.socket.send(encode(ClientMessage, { request, asked }) as Uint8Array<ArrayBuffer>);
    });
  }

  /** Sends a command and shows the reason if it is refused. */
  async order(asked: Command): Promise<Result> {
    if (asked.case !== "looked" && asked.case !== "injected") this.say("asked", `${asked.case} ${words(asked.value)}`);
    const result = await this.ask(asked);
    this.change({ notice: reasonOf(result) });
    return result;
  }

  /** Sends a command; the result is the reason if it is refused, which its sender shows where it was given. */
  async attempt(asked: Command): Promise<string> {
    this.say("asked", `${asked.case} ${words(asked.value)}`);
    const reason = reasonOf(await this.ask(asked));
    this.refuse(reason);
    return reason;
  }

  /** Puts the reason of a refusal into the console. */
  refuse(reason: string): void {
    if (reason) this.say("refused", reason);
    this.change({});
  }

  /** Subscribes to channels until the result is called; for new ones the server also sends past samples. */
  watch(channels: readonly number[]): () => void {
    this.watches.add(channels);
    this.subscribeAll();
    return () => {
      this.watches.delete(channels);
      this.subscribeAll();
    };
  }

  /** Sends what all views of the page watch, once for the changes of a moment. */
  private subscribeAll(): void {
    if (this.subscribing) return;
    this.subscribing = true;
    queueMicrotask(() => {
      this.subscribing = false;
      const channels = [...new Set([...this.watches].flat())];
      if (channels.join() === this.watched.join()) return;
      for (const each of channels) if (!this.watched.includes(each)) this.tracks.delete(each);
      this.watched = channels;
      void this.ask({ case: "channels", value: channels });
    });
  }

  /** Shows the run as of a time; negative: the present. Of several requests only the last one is sent. */
  async look(time: number): Promise<void> {
    this.wanted = time;
    if (time >= 0) this.system((system) => ({ time: { ...system.time, now: time, past: true, playing: false } }));
    this.change({});
    if (this.looking) return;
    this.looking = true;
    while (this.wanted !== undefined) {
      const next = this.wanted;
      this.wanted = undefined;
      await this.order({ case: "looked", value: next });
    }
    this.looking = false;
  }

  /** Plays a recording, at its end from its beginning, or stops it. */
  play(playing: boolean): void {
    const time = this.page.system?.time;
    if (playing && time && time.now >= time.last) void this.look(time.first);
    this.change({ playing });
  }

  /** Stops a recording, and moves in it by a time [s]. */
  step(by: number): void {
    const time = this.page.system?.time;
    if (!time) return;
    this.change({ playing: false });
    void this.look(Math.min(Math.max(time.now + by, time.first), time.last));
  }

  span(seconds: number): void {
    this.change({ span: seconds, zoom: undefined });
  }

  differ(differs: boolean): void {
    this.change({ differs });
  }

  zoom(times: readonly [number, number] | undefined): void {
    this.change({ zoom: times });
  }

  notify(notice: string): void {
    this.change({ notice });
  }

  private system(part: (system: SystemState) => Partial<SystemState>): void {
    const system = this.page.system;
    if (system) this.page = { ...this.page, system: { ...system, ...part(system) } };
  }

  private component(instance: string, part: (component: Component) => Partial<Component>): void {
    this.system((system) => ({
      components: system.components.map((each) =>
        each.instance === instance ? { ...each, ...part(each) } : each,
      ),
    }));
  }

  /** Whether the ERROR of a component is the end of its work, in the compared run as in this one. */
  private finishes(instance: string): boolean {
    return this.page.system?.components.find((each) => each.instance === instance)?.finishes ?? false;
  }

  private line(time: number, instance: string, text: string, kind: Line["kind"]): void {
    this.page = {
      ...this.page,
      lines: [...this.page.lines, { time, instance, text, kind }].slice(-MAX_LINES),
    };
  }

  /** Leaves out the report of a failure that a change of state tells as its reason. */
  private forgetReport(instance: string, reason: string): void {
    const at = this.page.lines.findLastIndex((each) => each.instance === instance);
    const last = this.page.lines[at];
    if (last?.kind === "error" && last.text.endsWith(`: ${reason}`)) this.page = { ...this.page, lines: this.page.lines.toSpliced(at, 1) };
  }

  private announce(what: string, connection: Connection | undefined): void {
    if (!connection || this.retelling) return;
    const { source, target } = connection;
    this.page = { ...this.page, announced: t("{source} to {target}: {what}", { source: `${source.instance}.${source.port}`, target: `${target.instance}.${target.port}`, what }) };
  }

  private take(event: Event): void {
    switch (event.case) {
      case "greeting":
        if (event.value.server !== this.server) {
          this.types = new TypeTable();
          this.tracks.clear();
        }
        // A server with another version has another page.
        if (event.value.version !== VERSION && this.server) location.reload();
        this.server = event.value.server;
        this.page = { ...unavailable, link: "live", full: event.value.full, span: this.page.span, differs: this.page.differs, zoom: this.page.zoom, said: this.page.said };
        break;
      case "whole":
        this.types.add(0, event.value.types);
        this.tracks.clear();
        this.traffic = new Traffic();
        if (event.value.time.past || this.page.system?.time.past || begun(event.value) !== begun(this.page.system)) this.page = { ...this.page, lines: [], statistics: new Map(), beside: new Map(), flows: new Map(), lost: new Map(), chains: [] };
        if (event.value.edits.file !== this.page.system?.edits.file) this.page = { ...this.page, zoom: undefined };
        this.page = { ...this.page, system: event.value, notice: "" };
        if (this.wanted !== undefined) {
          const now = this.wanted;
          this.system(({ time }) => ({ time: { ...time, now: now < 0 ? time.now : now } }));
        }
        if (this.watched.length && !this.looking) void this.ask({ case: "channels", value: this.watched });
        break;
      case "types":
        this.types.add(event.value.first, event.value.nodes);
        break;
      case "described": {
        const component = event.value;
        this.system((system) => ({ components: replaced(system.components, component, (c) => c.instance) }));
        break;
      }
      case "removed":
        this.system((system) => ({
          components: system.components.filter((each) => each.instance !== event.value),
          channels: system.channels.filter((each) => each.beside || each.port.instance !== event.value),
        }));
        break;
      case "connected": {
        const connection = event.value;
        this.announce(t("connected"), connection);
        this.system((system) => ({ connections: replaced(system.connections, connection, (c: Connection) => c.name) }));
        break;
      }
      case "cut":
        this.announce(t("cut"), this.page.system?.connections.find((each) => each.name === event.value));
        this.system((system) => ({
          connections: system.connections.filter((each) => each.name !== event.value),
        }));
        break;
      case "change": {
        const { time, instance, after, reason } = event.value;
        this.component(instance, () => ({ current: after, reason }));
        if (reason) this.forgetReport(instance, reason);
        const name = stateOf({ current: after, finishes: this.finishes(instance) });
        this.line(time, instance, name + (reason ? `: ${reason}` : ""), name === "ERROR" ? "error" : "state");
        break;
      }
      case "other": {
        const { time, instance, after, reason } = event.value;
        const state = stateOf({ current: after, finishes: this.finishes(instance) });
        this.page = { ...this.page, beside: new Map(this.page.beside).set(instance, state) };
        this.line(time, instance, `${t("beside: {state}", { state })}${reason ? `: ${reason}` : ""}`, "beside");
        break;
      }
      case "statistics":
        this.page = {
          ...this.page,
          statistics: new Map([
            ...this.page.statistics,
            ...event.value.map((each) => [each.instance, each] as const),
          ]),
        };
        break;
      case "setting": {
        const { instance, set, parameter, text } = event.value;
        this.component(instance, (component) => ({
          configuration_sets: component.configuration_sets.map((each) =>
            each.name === set ? { ...each, values: replaced(each.values, { name: parameter, text }, (v) => v.name) } : each,
          ),
        }));
        break;
      }
      case "activated":
        this.component(event.value.instance, () => ({ active_set: event.value.set }));
        break;
      case "opened": {
        const channel = event.value;
        this.system((system) => ({ channels: replaced(system.channels, channel, (c) => c.id) }));
        break;
      }
      case "samples":
        for (const { channel, time, data } of event.value) this.sample(channel, time, data);
        for (const track of this.tracks.values()) track.thinned ||= isFull(track.times);
        break;
      case "clock":
        if (!this.looking) this.system(() => ({ time: event.value }));
        break;
      case "outcome":
        this.waiting.get(event.value.request)?.(event.value);
        this.waiting.delete(event.value.request);
        break;
      case "place":
        this.component(event.value.instance, () => ({ placed: true, where: event.value.where }));
        break;
      case "edited":
        this.system(() => ({ edits: event.value }));
        break;
      case "reported":
        this.say(event.value.kind, [event.value.instance, event.value.text].filter(Boolean).join(": "));
        this.line(event.value.time, event.value.instance, `${kindOf(event.value.kind)}: ${event.value.text}`, FAILURES.includes(event.value.kind) ? "error" : "event");
        break;
      case "less":
        this.page = { ...this.page, notice: t("This page is slow: {count} {count:message was|messages were} left out.", { count: event.value.dropped }) };
        break;
      case "reason":
        this.page = { ...this.page, notice: event.value };
        break;
      case "chains":
        this.page = { ...this.page, chains: event.value };
        break;
      case "flows":
        this.page = { ...this.page, flows: new Map(event.value.map((each) => [each.name, each])), lost: lostOf(event.value, this.page.lost) };
        break;
      case "traffic":
        for (const frame of event.value) this.traffic.frame(frame);
        break;
      case "described_bus": {
        const bus = event.value;
        this.system((system) => ({ buses: replaced(system.buses, bus, (each) => each.name) }));
        break;
      }
      case "naming": {
        const naming = event.value;
        this.system(() => ({ naming }));
        break;
      }
      case "carried":
        this.traffic.load(event.value);
        break;
      case "call":
        this.traffic.call(event.value);
        break;
    }
  }

  /** Throws CdrError, or SyntaxError for invalid JSON. */
  private read({ type_number }: Channel, data: Uint8Array): unknown {
    return type_number < 0 ? JSON.parse(new TextDecoder().decode(data)) : deserialize(this.types.codec(type_number), data);
  }

  private sample(id: number, time: number, data: Uint8Array): void {
    const channel = this.page.system?.channels.find((each) => each.id === id);
    if (!channel) return;
    let track = this.tracks.get(id);
    if (!track || time < (track.times.at(-1) ?? 0)) {
      track = { value: undefined, times: [], numbers: new Map(), fresh: [], count: 0, thinned: false, refused: "" };
      this.tracks.set(id, track);
    }
    try {
      track.value = this.read(channel, data);
    } catch (error) {
      if (!(error instanceof CdrError || error instanceof SyntaxError)) throw error;
      track.refused = error.message;
      return;
    }
    track.refused = "";
    if (isFull(track.times)) {
      track.thinned = true;
      thin(track.times, [track.fresh, ...track.numbers.values()]);
    }
    track.fresh.push(track.value);
    track.count += 1;
    const before = track.times.push(time) - 1;
    const found = new Map(leaves(track.value).flatMap(([path, leaf]): [string, number][] => (typeof leaf === "number" || typeof leaf === "boolean" ? [[path, Number(leaf)]] : [])));
    for (const name of found.keys())
      if (!track.numbers.has(name)) track.numbers.set(name, Array<number>(before).fill(NaN));
    for (const [name, row] of track.numbers) row.push(found.get(name) ?? NaN);
  }
}

/** Why a command was refused; empty if it was not. */
export const reasonOf = ({ done, message, hint }: Result): string => (done ? "" : [message, hint].filter(Boolean).join(": "));

/** A value of a command in words. */
/** The counts of lost samples by connection; the map before if none has changed. */
function lostOf(flows: readonly Flow[], before: Page["lost"]): Page["lost"] {
  const after = new Map(flows.filter(({ lost }) => lost > 0n).map(({ name, lost }) => [name, lost]));
  return after.size === before.size && [...after].every(([name, lost]) => before.get(name) === lost) ? before : after;
}

const words = (value: unknown): string =>
  value && typeof value === "object" && !ArrayBuffer.isView(value)
    ? Object.values(value)
        .map(words)
        .filter(Boolean)
        .join(" ")
    : typeof value === "boolean"
      ? ""
      : String(value);

function replaced<T>(list: readonly T[], item: T, key: (item: T) => unknown): T[] {
  const at = list.findIndex((each) => key(each) === key(item));
  return at < 0 ? [...list, item] : list.map((each, i) => (i === at ? item : each));
}

const MAX_LEAVES = 64;

/** The values in a sample with their paths, up to a maximum number. */
export function leaves(value: unknown, path = "", found: [string, unknown][] = []): [string, unknown][] {
  if (found.length >= MAX_LEAVES) return found;
  if (Array.isArray(value) || ArrayBuffer.isView(value)) {
    const items = value as unknown as ArrayLike<unknown>;
    for (let i = 0; i < items.length && found.length < MAX_LEAVES; i++) leaves(items[i], `${path}[${i}]`, found);
  } else if (value instanceof Map) {
    for (const [key, item] of value) leaves(item, `${path}[${String(key)}]`, found);
  } else if (value && typeof value === "object") {
    for (const [name, item] of Object.entries(value)) leaves(item, path ? `${path}.${name}` : name, found);
  } else {
    found.push([path || "value", typeof value === "bigint" ? Number(value) : value]);
  }
  return found;
}

/** The state of a component as people read it: that of one that ends in ERROR as planned is FINISHED. */
export const stateOf = ({ current, finishes }: Pick<Component, "current" | "finishes">): string =>
  finishes && current === "STATE_ERROR" ? "FINISHED" : stateName(current);

/** The class of the colours of a state. */
export const stateClass = (component: Pick<Component, "current" | "finishes">): string =>
  stateOf(component) === "FINISHED" ? "FINISHED" : component.current;

/** Why a command for all components can do nothing; empty if it can. */
export const obstacleToAll = ({ components }: Pick<SystemState, "components">): string =>
  !components.length ? t("The system has no components yet.") : components.every((each) => each.place) ? t("Components of other processes are controlled one by one.") : "";

export const stateName = (state: Component["current"]): string => state.replace("STATE_", "");

export const store = new Store();

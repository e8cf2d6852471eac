/** A joystick: travel commands by mouse, touch, keyboard and gamepad. */

import { useEffect, useMemo, useRef, useState } from "react";
import { MapView } from "./MapView.tsx";
import type { PortAddress, SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";
import type { Command, Velocity } from "./velocity.ts";
import { REST, command } from "./velocity.ts";

/** Interval of commands while the stick is held [ms]. */
const EVERY = 50;
/** The longest time between two tries of a zero command [ms]. */
const LONGEST_PAUSE = 1000;
const DEAD = 0.12;
const RADIUS = 55;

interface Target {
  address: PortAddress;
  name: string;
  command: Command;
}

/** The ports for travel commands: InPorts, then OutPorts, which send them to all receivers. */
function targets(system: SystemState): Target[] {
  const found = system.components.flatMap(({ instance, place, ports }) =>
    ports.flatMap((port) => {
      // OutPorts of other processes cannot be driven.
      const takes = port.kind === "PORT_IN" || (port.kind === "PORT_OUT" && !place);
      const made = takes && port.type_number >= 0 ? command(store.types, port.type_number) : undefined;
      const name = `${instance}.${port.name}`;
      return made ? [{ address: { instance, port: port.name }, name, command: made, sends: port.kind === "PORT_OUT" }] : [];
    }),
  );
  return [...found.filter((each) => !each.sends), ...found.filter((each) => each.sends)];
}

/** Deflections (-1 to 1) by key. */
const KEYS: Record<string, Partial<Velocity>> = {
  ArrowUp: { forward: 1 },
  KeyW: { forward: 1 },
  ArrowDown: { forward: -1 },
  KeyS: { forward: -1 },
  ArrowLeft: { turn: 1 },
  KeyA: { turn: 1 },
  ArrowRight: { turn: -1 },
  KeyD: { turn: -1 },
  KeyQ: { left: 1 },
  KeyE: { left: -1 },
};

const within = (value: number): number => Math.min(Math.max(value, -1), 1);
const live = (value = 0): number => (Math.abs(value) < DEAD ? 0 : within(value));
const isRest = ({ forward, left, turn }: Velocity): boolean => !forward && !left && !turn;

/** The sum of deflections, limited to -1 to 1. */
function sum(parts: readonly Partial<Velocity>[]): Velocity {
  const of = (name: keyof Velocity) => within(parts.reduce((total, each) => total + (each[name] ?? 0), 0));
  return { forward: of("forward"), left: of("left"), turn: of("turn") };
}

/** Left stick: forward and turning, right stick: sideways, by the standard layout of the Gamepad API. */
function gamepad(): Velocity {
  const pad = navigator.getGamepads().find((each) => each?.connected);
  return pad ? { forward: -live(pad.axes[1]) || 0, turn: -live(pad.axes[0]) || 0, left: -live(pad.axes[2]) || 0 } : REST;
}

/**
 * Sends commands while a deflection is held, and a zero command when it is released.
 *
 * A zero command that is refused, or lost with the connection, is sent again until the server has taken it.
 */
class Stick {
  private moving = false;
  private last = 0;
  /** The number of releases and commands; a new one ends the repetition of a zero command. */
  private turn = 0;
  pointer: Partial<Velocity> = {};
  readonly keys = new Set<string>();

  constructor(
    private readonly target: Target,
    private readonly limits: () => { speed: number; rate: number },
  ) {}

  deflection(): Velocity {
    return sum([this.pointer, gamepad(), ...[...this.keys].map((each) => KEYS[each] ?? {})]);
  }

  /** Called often; `now` in ms. */
  tick(now: number): void {
    const held = this.deflection();
    if (isRest(held)) {
      this.rest();
    } else if (!this.moving || now - this.last >= EVERY) {
      this.last = now;
      this.moving = true;
      this.turn++;
      const { speed, rate } = this.limits();
      void this.send({ forward: held.forward * speed, left: held.left * speed, turn: held.turn * rate });
    }
  }

  /** Releases all inputs, and stops the robot at once if it was driven. */
  stop(): void {
    this.keys.clear();
    this.pointer = {};
    this.rest();
  }

  private rest(): void {
    if (this.moving) void this.sendRest(++this.turn);
    this.moving = false;
  }

  private async sendRest(turn: number): Promise<void> {
    for (let pause = EVERY; !(await this.send(REST)); pause = Math.min(2 * pause, LONGEST_PAUSE)) {
      await new Promise((resume) => setTimeout(resume, pause));
      if (turn !== this.turn || !this.exists()) return;
    }
  }

  /** Whether the port may take commands, as far as the page knows. */
  private exists(): boolean {
    const { instance, port } = this.target.address;
    const { link, system } = store.page;
    const component = system?.components.find((each) => each.instance === instance);
    return link !== "refused" && (!system || component?.ports.some((each) => each.name === port) === true);
  }

  /** Returns whether the server has taken the command. */
  private async send(velocity: Velocity): Promise<boolean> {
    const { address, command: made, name } = this.target;
    const data = made.sample(velocity) as Uint8Array<ArrayBuffer>;
    const result = await store.ask({ case: "injected", value: { port: address, data } });
    if (!result.done) store.notify(`${name}: ${result.message}`);
    return result.done;
  }
}

function Pad({ target, speed, rate }: { target: Target; speed: number; rate: number }) {
  const limits = useRef({ speed, rate });
  limits.current = { speed, rate };
  const [held, show] = useState(REST);
  const stick = useMemo(() => new Stick(target, () => limits.current), [target]);

  useEffect(() => {
    const stop = () => stick.stop();
    const onHide = () => document.hidden && stop();
    // A timer instead of animation frames: it also runs, more slowly, while nothing is painted.
    const timer = setInterval(() => {
      if (!document.hidden && document.hasFocus()) stick.tick(performance.now());
      else stick.stop();
      const now = stick.deflection();
      show((before) => (before.forward === now.forward && before.left === now.left && before.turn === now.turn ? before : now));
    }, EVERY / 2);
    window.addEventListener("blur", stop);
    window.addEventListener("pagehide", stop);
    document.addEventListener("visibilitychange", onHide);
    return () => {
      clearInterval(timer);
      window.removeEventListener("blur", stop);
      window.removeEventListener("pagehide", stop);
      document.removeEventListener("visibilitychange", onHide);
      stop();
    };
  }, [stick]);

  const pointed = (e: React.PointerEvent<HTMLElement>) => {
    const box = e.currentTarget.getBoundingClientRect();
    const across = within((e.clientX - box.x - box.width / 2) / RADIUS);
    const forward = within(-(e.clientY - box.y - box.height / 2) / RADIUS);
    const sideways = e.shiftKey && target.command.sideways;
    stick.pointer = { forward: live(forward), [sideways ? "left" : "turn"]: -live(across) || 0 };
  };
  const release = () => {
    stick.pointer = {};
    stick.tick(performance.now());
  };
  return (
    <>
      <div
        className="stick"
        role="application"
        tabIndex={0}
        aria-label={t("Joystick of {name}", { name: target.name })}
        aria-describedby="stick-help"
        onPointerDown={(e) => {
          e.currentTarget.setPointerCapture(e.pointerId);
          pointed(e);
        }}
        onPointerMove={(e) => e.currentTarget.hasPointerCapture(e.pointerId) && pointed(e)}
        onPointerUp={release}
        onPointerCancel={release}
        onLostPointerCapture={release}
        onKeyDown={(e) => {
          if (e.code === "Space" || e.code === "Escape") {
            e.preventDefault();
            stick.stop();
          }
          if (!(e.code in KEYS) || e.ctrlKey || e.altKey || e.metaKey) return;
          e.preventDefault();
          stick.keys.add(e.code);
        }}
        onKeyUp={(e) => {
          stick.keys.delete(e.code);
          stick.tick(performance.now());
        }}
        onBlur={() => stick.stop()}
      >
        <span className="knob" style={{ transform: `translate(${-(held.turn || held.left) * RADIUS}px, ${-held.forward * RADIUS}px)` }} />
      </div>
      <output aria-label={t("Command")}>
        {t("{speed} m/s forward", { speed: (held.forward * speed).toFixed(2) })}
        {target.command.sideways && t(", {speed} m/s left", { speed: (held.left * speed).toFixed(2) })}, {(held.turn * rate).toFixed(2)} rad/s
      </output>
    </>
  );
}

function Limit({ label, unit, value, set }: { label: string; unit: string; value: number; set: (value: number) => void }) {
  return (
    <label>
      {label}
      <input
        type="number"
        min={0}
        max={10}
        step={0.05}
        value={value}
        onChange={(e) => Number.isFinite(e.target.valueAsNumber) && set(Math.min(Math.max(e.target.valueAsNumber, 0), 10))}
      />
      {unit}
    </label>
  );
}

/** `map`: whether the map is below the stick, since it is not seen elsewhere. */
export function Drive({ system, full, map, plot }: { system: SystemState; full: boolean; map: boolean; plot: () => void }) {
  const [name, choose] = useState("");
  const [speed, setSpeed] = useState(0.3);
  const [rate, setRate] = useState(0.5);
  // Descriptions of components change with their states; the ports that can be driven do not.
  const shape = system.components.map((each) => each.instance).join("\n");
  const known = useMemo(() => targets(system), [shape]);
  const target = known.find((each) => each.name === name);
  return (
    <>
      <label>
        {t("Port")}
        <select aria-label={t("Driven port")} value={target?.name ?? ""} disabled={!full} onChange={(e) => choose(e.target.value)}>
          <option value="">{t("none")}</option>
          {known.map((each) => (
            <option key={each.name} value={each.name}>{each.name}</option>
          ))}
        </select>
      </label>
      <div className="buttons">
        <Limit label={t("Speed")} unit="m/s" value={speed} set={setSpeed} />
        <Limit label={t("Turn")} unit="rad/s" value={rate} set={setRate} />
      </div>
      {!full ? (
        <p>{t("This page may only look.")}</p>
      ) : target ? (
        <>
          <Pad key={target.name} target={target} speed={speed} rate={rate} />
          <p>
            <small id="stick-help">
              {t("Pull the stick, or focus it and hold arrow keys or W A S D, Q E (Shift and the mouse) sideways; Space stops. A gamepad drives while this view is open.")}
            </small>
          </p>
        </>
      ) : (
        <p>{known.length ? t("Choose the port that gets the commands.") : t("No port takes travel commands.")}</p>
      )}
      {map && <MapView system={system} plot={plot} />}
    </>
  );
}

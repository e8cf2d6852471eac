/** The time line: play, pause, step, speed, setting time, and looking back, with marks of what happened and what is planned. */

import { GitCompareArrows, Pause, Play, Rewind, StepForward } from "lucide-react";
import { memo, useEffect, useRef, useState } from "react";
import { Button, IconButton } from "./kit/Button.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import { Menu } from "./Menu.tsx";
import type { Place } from "./Menu.tsx";
import type { PlannedEvent, SystemState } from "./protocol/Ui.ts";
import type { Line } from "./store.ts";
import { STEP, store } from "./store.ts";
import { t } from "./texts.ts";

/** Minimum step of the slider [s], and its number of steps. */
const MIN_STEP = 0.001;
const STEPS = 1000;
/** The part of a recording that is played in one step [s]. */
const FRAME = 0.1;
const SPEEDS = [0.1, 0.5, 1, 2, 5, 10, 0];
/** What one button looks back [s]. */
const BACK = 10;
/** Marks nearer than this to the mouse are told, and a finger means those nearer than that [px]. */
const NEAR = 6;
const TOUCHED = 16;

/** Chooses a speed of the time; 0: as fast as possible. */
function Speed({ speeds, speed, disabled, choose }: { speeds: readonly number[]; speed: number; disabled: boolean; choose: (speed: number) => void }) {
  return (
    <label>
      <span className="announced">{t("Speed")}</span>
      <select aria-label={t("Speed")} title={t("Speed")} disabled={disabled} value={speed} onChange={(e) => choose(Number(e.target.value))}>
        {[...new Set([...speeds, speed])].map((each) => (
          <option key={each} value={each}>
            {each ? `${each}×` : t("fastest")}
          </option>
        ))}
      </select>
    </label>
  );
}

/** Plays a recording, first as fast as it was recorded. */
function Player({ now, first, last, playing }: { now: number; first: number; last: number; playing: boolean }) {
  const [speed, setSpeed] = useState(1);
  const over = now >= last;
  useEffect(() => {
    if (!playing) return;
    if (over) {
      store.play(false);
      return;
    }
    const next = setTimeout(() => void store.look(Math.min(now + FRAME * speed, last)), 1000 * FRAME);
    return () => clearTimeout(next);
  }, [playing, speed, over, now, last]);
  return (
    <>
      <IconButton
        icon={playing ? Pause : Play}
        look="primary"
        label={playing ? t("Pause") : t("Play")}
        keys="Space"
        disabled={last <= first}
        onClick={() => store.play(!playing)}
      />
      <IconButton icon={StepForward} label={t("Step")} keys="." disabled={over} onClick={() => store.step(STEP)} />
      <Speed speeds={SPEEDS.filter(Boolean)} speed={speed} disabled={last <= first} choose={setSpeed} />
    </>
  );
}

interface Mark {
  time: number;
  kind: Line["kind"] | "plan";
  text: string;
}

const ORDER = ["plan", "beside", "event", "state", "error"] as const;

interface Marked {
  marks: readonly Mark[];
  first: number;
  end: number;
}

/** The marks near a place, the nearest first. */
function near({ marks, first, end }: Marked, x: number, line: Element, reach: number): Mark[] {
  const { left, width } = line.getBoundingClientRect();
  const distance = ({ time }: Mark) => Math.abs(left + (width * (time - first)) / (end - first) - x);
  return marks.filter((each) => distance(each) < reach).sort((a, b) => distance(a) - distance(b));
}

function lookAt(mark: Mark | undefined): void {
  if (mark && mark.kind !== "plan") void store.look(mark.time);
}

/** Marks over the whole line, drawn as one path for each kind. */
const Marks = memo(function Marks(marked: Marked) {
  const { marks, first, end } = marked;
  const at = (time: number) => (1000 * (time - first)) / (end - first);
  return (
    <svg
      className="marks"
      viewBox="0 0 1000 10"
      preserveAspectRatio="none"
      aria-hidden
      onMouseMove={(e) => {
        const lines = near(marked, e.clientX, e.currentTarget, NEAR).map((each) => `${each.time.toFixed(3)} s ${each.text}`);
        e.currentTarget.querySelector("title")!.textContent = lines.slice(0, 12).join("\n");
      }}
      onClick={(e) => lookAt(near(marked, e.clientX, e.currentTarget, NEAR)[0])}
    >
      <title />
      <rect width="1000" height="10" fill="transparent" />
      {ORDER.map((kind) => (
        <path
          key={kind}
          className={kind}
          vectorEffect="non-scaling-stroke"
          d={marks
            .filter((each) => each.kind === kind)
            .map((each) => `M${at(each.time).toFixed(2)} 0V10`)
            .join("")}
        />
      ))}
    </svg>
  );
});

/** Sets the time; what is no time is refused at the field. */
function Go({ full }: { full: boolean }) {
  const [goal, setGoal] = useState("");
  const [refused, refuse] = useState("");
  const go = async () => {
    const time = goal.trim() ? Number(goal) : NaN;
    refuse(Number.isFinite(time) ? await store.attempt({ case: "time", value: time }) : t("{text} is not a number", { text: JSON.stringify(goal) }));
  };
  return (
    <form
      className="group"
      onSubmit={(e) => {
        e.preventDefault();
        void go();
      }}
    >
      <Refusable reason={refused}>
        {(said) => (
          <input
            {...said}
            aria-label={t("Go to time in seconds")}
            placeholder={t("time [s]")}
            inputMode="decimal"
            size={6}
            value={goal}
            disabled={!full}
            onChange={(e) => {
              setGoal(e.target.value);
              refuse("");
            }}
          />
        )}
      </Refusable>
      <Button type="submit" disabled={!full}>
        {t("Go")}
      </Button>
    </form>
  );
}

/** Opens a recording beside the run. */
function Compare({ beside }: { beside: string }) {
  const [menu, show] = useState<Place>();
  const [files, list] = useState<readonly string[]>([]);
  const find = async ({ x, y }: { x: number; y: number }) => {
    const { files = [] } = await store.ask({ case: "listed", value: true });
    if (!files.length && !beside) store.notify(t("There is no recording here: `rtgen run --record FILE.mcap` writes one."));
    else {
      list(files);
      show({ label: t("Compare with a recording"), x, y });
    }
  };
  const compare = (file: string) => () => void store.order({ case: "compared", value: file });
  return (
    <>
      <IconButton icon={GitCompareArrows} label={t("Compare with a recording")} onClick={(e) => void find(e.currentTarget.getBoundingClientRect())} />
      {menu && (
        <Menu place={menu} items={[...(beside ? [{ name: t("Compare with nothing"), act: compare("") }] : []), ...files.map((name) => ({ name, act: compare(name) }))]} close={() => show(undefined)} />
      )}
    </>
  );
}

/** Marks of what has happened within the kept time, `first` to `now`, and of what is planned. */
function marksOf(lines: readonly Line[], plan: readonly PlannedEvent[], first: number, now: number): Mark[] {
  const marks = [
    ...lines.map(({ time, kind, instance, text }) => ({ time, kind, text: `${instance} ${text}` })),
    ...plan.map(({ time, kind, text }) => ({ time, kind: time > now ? ("plan" as const) : ("event" as const), text: `${kind} ${text}` })),
  ];
  return marks.filter((each) => each.time >= first);
}

/** `brief`: what a phone has room for below another view. */
export function TimeBar({ system, full, lines, live, playing, brief }: { system: SystemState; full: boolean; lines: readonly Line[]; live: boolean; playing: boolean; brief: boolean }) {
  const { time, plan, components } = system;
  const pressed = useRef(0);
  const simulated = time.kind === "CLOCK_SIMULATED";
  const recording = time.kind === "CLOCK_RECORDING";
  /** Whether other processes run the system, whose next run can be compared with this one. */
  const elsewhere = time.kind === "CLOCK_REAL" && components.length > 0 && components.every((each) => each.place);
  const kept = system.keeps || system.beside !== "";
  const last = Math.max(time.last, time.first + MIN_STEP);
  const end = Math.max(last, ...plan.map((each) => each.time));
  const part = (100 * (last - time.first)) / (end - time.first);
  const marked = { marks: marksOf(lines, plan, time.first, time.last), first: time.first, end };
  return (
    <footer>
      <div className="time" role="toolbar" aria-label={t("Time")}>
      <div className="toolbar">
        {simulated && (
          <>
            {!brief && <IconButton icon={Rewind} look="plain" label={t("Look back by {seconds} s", { seconds: BACK })} disabled={time.now <= time.first} onClick={() => void store.look(Math.max(time.first, time.now - BACK))} />}
            <IconButton
              icon={time.playing ? Pause : Play}
              look="primary"
              label={time.playing ? t("Pause") : t("Play")}
              keys="Space"
              disabled={!full}
              onClick={() => store.order(time.playing ? { case: "paused", value: true } : { case: "played", value: true })}
            />
            <IconButton icon={StepForward} label={t("Step")} keys="." disabled={!full || time.playing} onClick={() => store.order({ case: "step", value: 0 })} />
          </>
        )}
        {recording && <Player now={time.now} first={time.first} last={time.last} playing={playing} />}
        <output aria-label={t("Time of the run")}>{time.now.toFixed(3)} s</output>
        {simulated && !brief && (
          <Speed speeds={SPEEDS} speed={time.speed} disabled={!full} choose={(speed) => void store.order({ case: "speed", value: speed })} />
        )}
      </div>
      {/* A finger is wider than a mark, which the slider covers. */}
      <div
        className="line"
        onPointerDown={(e) => {
          pressed.current = e.clientX;
        }}
        onPointerUp={({ pointerType, clientX, currentTarget }) => {
          const isTap = pointerType === "touch" && Math.abs(clientX - pressed.current) < NEAR;
          if (isTap) lookAt(near(marked, clientX, currentTarget.querySelector(".marks")!, TOUCHED)[0]);
        }}
      >
        <Marks {...marked} />
        <input
          type="range"
          className="past"
          style={{ width: `max(28px, ${part}%)` }}
          aria-label={t("Look at time")}
          aria-valuetext={`${time.now.toFixed(3)} s`}
          min={time.first}
          max={last}
          step={Math.max((last - time.first) / STEPS, MIN_STEP)}
          value={time.now}
          onChange={(e) => void store.look(Number(e.target.value))}
        />
        <small className="ends">
          <span>{time.first > 0 ? t("kept from {first} s on", { first: time.first.toFixed(1) }) : "0 s"}</span>
          {time.ended && !recording && <span>{t("ended")}</span>}
          <span>{end.toFixed(end < 100 ? 1 : 0)} s</span>
        </small>
      </div>
      <div className="toolbar">
        {simulated && !brief && <Go full={full} />}
        {(simulated || elsewhere) && !brief && (
            <Button
              aria-pressed={kept}
              title={[system.beside, elsewhere ? t("Show this run beside the next one") : t("Show this run beside those that begin when time is set back")].filter(Boolean).join("\n")}
              disabled={!full}
              onClick={() => store.order({ case: "kept", value: !kept })}
            >
              {system.beside ? t("Beside: {beside}", { beside: system.beside }) : t("Keep to compare")}
            </Button>
        )}
        {!recording && full && !brief && <Compare beside={system.beside} />}
        {!recording && (
          <Button className={`live ${live && !time.past ? "on" : ""}`} title={time.past ? t("Back to the present") : t("The page shows the present")} disabled={!time.past} onClick={() => void store.look(-1)}>
            {t("Live")}
          </Button>
        )}
      </div>
      </div>
    </footer>
  );
}

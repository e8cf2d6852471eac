/** Time bar: play, pause, step, speed, setting time, and looking back. */

import { useEffect, useState } from "react";
import type { SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";

/** Minimum step of the slider [s], and its number of steps. */
const MIN_STEP = 0.001;
const STEPS = 1000;
/** The part of a recording that is played in one step [s]. */
const FRAME = 0.1;
const SPEEDS = [0.1, 0.5, 1, 2, 5, 10, 0];

/** Plays a recording as fast as it was recorded. */
function Player({ now, last }: { now: number; last: number }) {
  const [playing, play] = useState(false);
  const over = now >= last;
  useEffect(() => {
    if (!playing || over) return;
    const next = setTimeout(() => void store.look(Math.min(now + FRAME, last)), 1000 * FRAME);
    return () => clearTimeout(next);
  }, [playing, over, now, last]);
  return (
    <button type="button" disabled={over} onClick={() => play(!playing)}>
      {playing && !over ? "Pause" : "Play"}
    </button>
  );
}

export function TimeBar({ system, full }: { system: SystemState; full: boolean }) {
  const { time } = system;
  const [goal, setGoal] = useState("");
  const simulated = time.kind === "CLOCK_SIMULATED";
  const recording = time.kind === "CLOCK_RECORDING";
  const kept = system.keeps || system.beside !== "";
  return (
    <div className="time" role="toolbar" aria-label="Time">
      <output aria-label="Time of the run">{time.now.toFixed(3)} s</output>
      {simulated && (
        <>
          <button
            type="button"
            disabled={!full}
            onClick={() => store.order(time.playing ? { case: "paused", value: true } : { case: "played", value: true })}
          >
            {time.playing ? "Pause" : "Play"}
          </button>
          <button type="button" disabled={!full || time.playing} onClick={() => store.order({ case: "step", value: 0 })}>
            Step
          </button>
          <label>
            Speed
            <select disabled={!full} value={time.speed} onChange={(e) => store.order({ case: "speed", value: Number(e.target.value) })}>
              {[...new Set([...SPEEDS, time.speed])].map((speed) => (
                <option key={speed} value={speed}>
                  {speed ? `${speed}×` : "fastest"}
                </option>
              ))}
            </select>
          </label>
          <form
            onSubmit={(e) => {
              e.preventDefault();
              if (goal.trim() && Number.isFinite(Number(goal))) void store.order({ case: "time", value: Number(goal) });
            }}
          >
            <input aria-label="Go to time in seconds" placeholder="time [s]" inputMode="decimal" size={6} value={goal} onChange={(e) => setGoal(e.target.value)} disabled={!full} />
            <button type="submit" disabled={!full}>
              Go
            </button>
          </form>
        </>
      )}
      {simulated && (
        <button
          type="button"
          aria-pressed={kept}
          title={[system.beside, "Show this run beside those that begin when time is set back"].filter(Boolean).join("\n")}
          disabled={!full}
          onClick={() => store.order({ case: "kept", value: !kept })}
        >
          {system.beside ? `Beside: ${system.beside}` : "Keep beside"}
        </button>
      )}
      {time.ended && !recording && <span>ended</span>}
      {recording && <Player now={time.now} last={time.last} />}
      <input
        type="range"
        className="past"
        aria-label="Look at time"
        aria-valuetext={`${time.now.toFixed(3)} s`}
        min={time.first}
        max={Math.max(time.last, time.first + MIN_STEP)}
        step={Math.max((time.last - time.first) / STEPS, MIN_STEP)}
        value={time.now}
        onChange={(e) => void store.look(Number(e.target.value))}
      />
      {time.first > 0 && <small>kept from {time.first.toFixed(1)} s on</small>}
      {!recording && (
        <button type="button" disabled={!time.past} onClick={() => void store.look(-1)}>
          Live
        </button>
      )}
    </div>
  );
}

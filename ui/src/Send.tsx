/** Form to send frames once, cyclically, or as a sequence. */

import { useEffect, useState } from "react";
import { Refusable } from "./kit/Refusable.tsx";
import { frameOf, stepsOf } from "./sequence.ts";
import type { Step } from "./sequence.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";

const LOOK_AGAIN = 10;

export function Send({ bus, full }: { bus: string; full: boolean }) {
  const [text, setText] = useState("");
  const [period, setPeriod] = useState("0.1");
  const [lines, setLines] = useState("");
  const [refused, refuse] = useState({ frame: "", period: "", lines: "" });
  const [waiting, wait] = useState<{ begin: number; steps: Step[] }>();
  const { cyclic } = store.traffic;
  const send = async (text: string, period: number) => {
    const frame = frameOf(text);
    const said = {
      frame: frame ? "" : t("A frame is written id#octets in hexadecimal digits, as 181#0102; id#R asks for one."),
      period: period >= 0 ? "" : t("The period is not a number of seconds."),
      lines: "",
    };
    if (frame && !said.period) said.frame = await store.attempt({ case: "frame", value: { ...frame, bus, period } });
    refuse(said);
    if (!frame || said.frame || said.period) return;
    const key = `${bus} ${frame.can_id} ${frame.extended}`;
    if (period) cyclic.set(key, { bus, text: text.trim() });
    else cyclic.delete(key);
  };
  const begin = () => {
    const steps = stepsOf(lines);
    refuse({ frame: "", period: "", lines: typeof steps === "string" ? steps : "" });
    if (typeof steps !== "string" &&  steps.length) wait({ begin: store.page.system?.time.now ?? 0, steps });
  };
  // Times are those of the run, so a sequence pauses with it.
  useEffect(() => {
    if (!waiting) return undefined;
    const rest = [...waiting.steps];
    const timer = setInterval(() => {
      const now = store.page.system?.time.now ?? 0;
      while (rest[0] && waiting.begin + rest[0].time <= now) void store.order({ case: "frame", value: { ...rest.shift()!.frame, bus } });
      if (!rest.length || now < waiting.begin) wait(undefined);
    }, LOOK_AGAIN);
    return () => clearInterval(timer);
  }, [waiting, bus]);
  return (
    <section aria-label={t("Send frames")}>
      <h2>{t("Send")}</h2>
      <form
        className="buttons"
        onSubmit={(e) => {
          e.preventDefault();
          void send(text, 0);
        }}
      >
        <Refusable reason={refused.frame}>
          {(said) => (
            <label>
              {t("Frame")}
              <input size={18} {...said} placeholder="181#0102" value={text} disabled={!full} onChange={(e) => setText(e.target.value)} />
            </label>
          )}
        </Refusable>
        <button type="submit" disabled={!full}>
          {t("Send once")}
        </button>
        <Refusable reason={refused.period}>
          {(said) => (
            <label>
              {t("Period [s]")}
              <input size={5} {...said} inputMode="decimal" value={period} disabled={!full} onChange={(e) => setPeriod(e.target.value)} />
            </label>
          )}
        </Refusable>
        <button type="button" disabled={!full} onClick={() => void send(text, Number(period) || NaN)}>
          {t("Send cyclically")}
        </button>
      </form>
      {[...cyclic.values()]
        .filter((each) => each.bus === bus)
        .map((each) => (
          <button key={each.text} type="button" disabled={!full} aria-label={t("End {text}", { text: each.text })} onClick={() => void send(each.text, 0)}>
            {each.text} ×
          </button>
        ))}
      <Refusable reason={refused.lines}>
        {(said) => (
          <label className="sequence">
            {t("Sequence")}
            <textarea rows={3} {...said} placeholder={"0 181#0102\n0.5 181#0000"} value={lines} disabled={!full} onChange={(e) => setLines(e.target.value)} />
          </label>
        )}
      </Refusable>
      <button type="button" disabled={!full} onClick={() => (waiting ? wait(undefined) : begin())}>
        {waiting ? t("Stop the sequence") : t("Send the sequence")}
      </button>
    </section>
  );
}

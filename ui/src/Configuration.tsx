/** Configuration sets: parameters edited by the widgets that their definitions name. */

import { useState } from "react";
import { Elsewhere } from "./Elsewhere.tsx";
import { Name } from "./kit/Name.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import type { Refused } from "./kit/Refusable.tsx";
import type { Component, Parameter, SystemState } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";

/** The limits of a constraint `a<=x<=b`, and the choices of `(a,b)`. */
export function limits(constraint: string): { min?: number; max?: number; choices?: string[] } {
  const choices = /^\(([^()]*)\)$/.exec(constraint.trim());
  if (choices) return { choices: items(choices[1]!) };
  const range = /^(?:([-+.\deE]+)\s*<=?\s*)?x(?:\s*<=?\s*([-+.\deE]+))?$/.exec(constraint.trim());
  const least = /^x\s*>=?\s*([-+.\deE]+)$/.exec(constraint.trim());
  const [min, max] = [range?.[1] ?? least?.[1], range?.[2]];
  return { ...(min && { min: Number(min) }), ...(max && { max: Number(max) }) };
}

/** A constraint as it is read: `1.0<=x<=5.0` as 1.0 to 5.0; nothing for choices, which the field has. */
export function inWords(constraint: string): string {
  if (limits(constraint).choices) return "";
  const [, low, above, below, high] = /^\s*(?:([-+.\deE]+)\s*(<=?)\s*)?x(?:\s*(<=?)\s*([-+.\deE]+))?\s*$/.exec(constraint) ?? [];
  const [, sign, end] = /^\s*x\s*(>=?)\s*([-+.\deE]+)\s*$/.exec(constraint) ?? [];
  if (sign) return `${sign === ">=" ? "≥" : ">"} ${end}`;
  if (above === "<=" && below === "<=") return t("{low} to {high}", { low: low!, high: high! });
  return [above && `${above === "<=" ? "≥" : ">"} ${low}`, below && `${below === "<=" ? "≤" : "<"} ${high}`].filter(Boolean).join(", ") || constraint;
}

/** The items of a value that is a list. */
const items = (text: string): string[] => (text.trim() ? text.split(",").map((each) => each.trim()) : []);
const isTrue = (text: string): boolean => ["true", "1", "yes", "on"].includes(text.trim().toLowerCase());

interface Slot {
  parameter: Parameter;
  text: string;
  full: boolean;
  label: string;
  /** Sets the value; the result is the reason if it is refused. */
  set: (text: string) => Promise<string>;
}

/** Whether a parameter is edited by a slider, which has the limits at its ends. */
function isSlider({ widget, constraint }: Parameter): boolean {
  const { min, max } = limits(constraint);
  return /^slider\b/.test(widget) && min !== undefined && max !== undefined;
}

/** A value edited by text field or slider, and sent when it is complete; what is refused stays until Escape or a valid value. */
function Entry({ parameter, text, full, label, set }: Slot) {
  const [edited, edit] = useState<string>();
  const [refused, refuse] = useState<{ text: string; reason: string }>();
  const { min, max } = limits(parameter.constraint);
  const [kind, step] = [/^\w*/.exec(parameter.widget)![0], Number(/\.(.+)/.exec(parameter.widget)?.[1])];
  const range = isSlider(parameter);
  const isRefused = edited !== undefined && edited === refused?.text;
  const commit = async () => {
    if (edited === undefined || edited === text) return edit(undefined);
    const reason = await set(edited);
    if (reason) refuse({ text: edited, reason });
    else edit((now) => (now === edited ? undefined : now));
  };
  const field = (said: Refused) => (
    <input
      {...said}
      aria-label={label}
      title={[text, parameter.doc].filter(Boolean).join("\n")}
      disabled={!full}
      type={range ? "range" : kind === "spin" ? "number" : "text"}
      min={min}
      max={max}
      step={range ? step || (max! - min!) / 100 : (kind === "spin" && step) || "any"}
      value={edited ?? text}
      onChange={(e) => edit(e.target.value)}
      onBlur={() => isRefused || void commit()}
      onPointerUp={range ? () => void commit() : undefined}
      onKeyUp={range ? () => void commit() : undefined}
      onKeyDown={(e) => {
        if (e.key === "Enter") void commit();
        if (e.key === "Escape") edit(undefined);
      }}
    />
  );
  return (
    <Refusable reason={isRefused ? refused.reason : ""}>
      {(said) =>
        range ? (
          <div className="slider">
            {field(said)}
            <small>{min}</small>
            <output>{edited ?? text}</output>
            <small>{max}</small>
          </div>
        ) : (
          field(said)
        )
      }
    </Refusable>
  );
}

interface Several extends Slot {
  choices: readonly string[];
  /** The id of the reason why a choice is refused. */
  description: string | undefined;
}

/** One choice, or any number of choices if the value is a list. */
function Choices({ parameter, text, full, label, set, choices, description }: Several) {
  const several = parameter.widget === "checkbox";
  const chosen = several ? items(text) : [text.trim()];
  return (
    <fieldset className="choices" aria-label={label} aria-describedby={description} title={parameter.doc} disabled={!full}>
      {choices.map((each) => (
        <label key={each}>
          <input
            type={several ? "checkbox" : "radio"}
            name={label}
            checked={chosen.includes(each)}
            onChange={() => void set(several ? choices.filter((one) => chosen.includes(one) !== (one === each)).join() : each)}
          />
          {each}
        </label>
      ))}
    </fieldset>
  );
}

/** An ordered list of choices, each of which can occur several times. */
function OrderedList({ parameter, text, full, label, set, choices, description }: Several) {
  const chosen = items(text);
  const swapped = (i: number) => chosen.with(i - 1, chosen[i]!).with(i, chosen[i - 1]!);
  return (
    <fieldset className="choices ordered" aria-label={label} aria-describedby={description} title={parameter.doc} disabled={!full}>
      <ol>
        {chosen.map((each, i) => (
          <li key={i}>
            <bdi>{each}</bdi>{" "}
            <button type="button" aria-label={t("Move {item} up", { item: each })} disabled={i === 0} onClick={() => void set(swapped(i).join())}>
              ↑
            </button>
            <button type="button" aria-label={t("Remove {item}, number {number}", { item: each, number: i + 1 })} onClick={() => void set(chosen.filter((_, at) => at !== i).join())}>
              −
            </button>
          </li>
        ))}
      </ol>
      <select aria-label={t("Add to {label}", { label })} value="" onChange={(e) => void set([...chosen, e.target.value].join())}>
        <option value="">{t("add …")}</option>
        {choices.map((each) => (
          <option key={each} value={each}>{each}</option>
        ))}
      </select>
    </fieldset>
  );
}

/** The widget named by the definition, else one that fits the type and the constraint. */
function Field(slot: Slot) {
  const { parameter, text } = slot;
  const [refused, refuse] = useState<{ before: string; reason: string }>();
  const { choices } = limits(parameter.constraint);
  const isSwitch = /^bool(ean)?$/.test(parameter.type) && parameter.widget !== "text" && parameter.widget !== "radio";
  if (!isSwitch && (!choices || parameter.widget === "text")) return <Entry {...slot} />;
  const set = async (wanted: string) => {
    const reason = await slot.set(wanted);
    refuse(reason ? { before: text, reason } : undefined);
    return reason;
  };
  return <Refusable reason={refused?.before === text ? refused.reason : ""}>{(said) => <Choice {...slot} set={set} said={said} choices={isSwitch ? undefined : choices} />}</Refusable>;
}

/** A value that is chosen; without choices, true or false. */
function Choice({ choices, said, ...slot }: Slot & { choices: readonly string[] | undefined; said: Refused }) {
  const { parameter, text, full, label, set } = slot;
  if (!choices) return <input {...said} type="checkbox" aria-label={label} title={parameter.doc} disabled={!full} checked={isTrue(text)} onChange={(e) => void set(String(e.target.checked))} />;
  const description = said["aria-describedby"];
  if (parameter.widget === "radio" || parameter.widget === "checkbox") return <Choices {...slot} choices={choices} description={description} />;
  if (/^ordere?d_list$/.test(parameter.widget)) return <OrderedList {...slot} choices={choices} description={description} />;
  return (
    <select {...said} aria-label={label} title={parameter.doc} disabled={!full} value={text} onChange={(e) => void set(e.target.value)}>
      {[...new Set([text, ...choices])].map((each) => (
        <option key={each} value={each}>{each}</option>
      ))}
    </select>
  );
}

export function Configuration({ system, component, full, select }: { system: SystemState; component: Component; full: boolean; select: (instance: string) => void }) {
  const [shown, show] = useState("");
  const [fresh, setFresh] = useState("");
  const [refused, refuse] = useState({ name: "", reason: "" });
  const name = component.configuration_sets.some((each) => each.name === shown) ? shown : component.active_set;
  const set = component.configuration_sets.find((each) => each.name === name);
  const [first] = component.parameters;
  if (!first) return <Elsewhere reason={t("This component has no parameters.")} system={system} has={(each) => each.parameters.length > 0} select={select} />;
  const valueOf = (parameter: Parameter) => set?.values.find((each) => each.name === parameter.name)?.text ?? parameter.default_value;
  const put = (set: string, parameter: Parameter, text: string) =>
    store.attempt({ case: "setting", value: { instance: component.instance, set, parameter: parameter.name, text } });
  return (
    <>
      <form
        className="sets"
        onSubmit={(e) => {
          e.preventDefault();
          // Setting a parameter of a new set creates the set.
          const made = fresh.trim();
          if (!made) return;
          void put(made, first, valueOf(first)).then((reason) => {
            refuse({ name: made, reason });
            if (reason) return;
            show(made);
            setFresh("");
          });
        }}
      >
        <label>
          {t("Set")}
          <select value={name} onChange={(e) => show(e.target.value)}>
            {component.configuration_sets.map((each) => (
              <option key={each.name} value={each.name}>
                <bdi>{each.name}</bdi>
                {each.name === component.active_set ? t(" (active)") : ""}
              </option>
            ))}
          </select>
        </label>
        <button
          type="button"
          disabled={!full || name === component.active_set}
          onClick={() => store.order({ case: "chosen", value: { instance: component.instance, set: name } })}
        >
          {t("Use this set")}
        </button>
        <Refusable reason={refused.name === fresh.trim() ? refused.reason : ""}>
          {(said) => (
            <span className="group">
              <input {...said} aria-label={t("Name of a new set")} placeholder={t("new set")} size={8} disabled={!full} value={fresh} onChange={(e) => setFresh(e.target.value)} onKeyDown={(e) => e.key === "Escape" && setFresh("")} />
              <button type="submit" disabled={!full || !fresh.trim()}>
                {t("Add set")}
              </button>
            </span>
          )}
        </Refusable>
      </form>
      <table className="parameters">
        <tbody>
          {component.parameters.map((parameter) => (
            <tr key={`${name} ${parameter.name}`}>
              <th scope="row" title={parameter.doc}>
                <Name text={parameter.name} />
              </th>
              <td className="text">
                <Field
                  parameter={parameter}
                  full={full}
                  label={`${component.instance}.${parameter.name}`}
                  text={valueOf(parameter)}
                  set={(text) => put(name, parameter, text)}
                />
              </td>
              <td className="text">
                <bdi>{parameter.unit}</bdi> {!isSlider(parameter) && <small>{inWords(parameter.constraint)}</small>}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

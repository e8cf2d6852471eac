/** Fields for a value of a type of the table. */

import { createContext, useContext } from "react";
import type { Chosen, Draft, DraftError } from "./draft.ts";
import { draft, range } from "./draft.ts";
import { Refusable } from "./kit/Refusable.tsx";
import type { Refused } from "./kit/Refusable.tsx";
import type { TypeMember } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";

interface Slot {
  type: number;
  value: Draft;
  /** The path of the value, for screen readers. */
  label: string;
  change: (value: Draft) => void;
}

/** Why a value of the form is refused, and which one. */
export const Refusal = createContext<DraftError | undefined>(undefined);

export function Form(slot: Slot) {
  const refused = useContext(Refusal);
  return <Refusable reason={refused?.path === slot.label ? refused.message : ""}>{(said) => <Fields {...slot} said={said} />}</Refusable>;
}

function Fields({ said, ...slot }: Slot & { said: Refused }) {
  const node = store.types.nodes[slot.type];
  const { value, label, change } = slot;
  const common = { "aria-label": label };
  if (!node) return null;
  switch (node.kind) {
    case "TYPE_BOOLEAN":
      return <input type="checkbox" {...common} checked={value === true} onChange={(e) => change(e.target.checked)} />;
    case "TYPE_ENUM":
      return (
        <select {...common} value={String(value)} onChange={(e) => change(e.target.value)}>
          {node.members.map((each) => (
            <option key={each.name} value={each.name}>{each.name}</option>
          ))}
        </select>
      );
    case "TYPE_STRUCT": {
      const parts = value as { [name: string]: Draft };
      return (
        <fieldset className="struct">
          {node.members.map((member) => (
            <Member key={member.name} member={member} value={parts[member.name] ?? null} label={label} change={(part) => change({ ...parts, [member.name]: part })} />
          ))}
        </fieldset>
      );
    }
    case "TYPE_UNION": {
      const chosen = value as Chosen;
      const member = node.members.find((each) => each.name === chosen.branch);
      return (
        <div>
          <select
            aria-label={t("{label}, branch", { label })}
            value={chosen.branch}
            onChange={(e) => {
              const next = node.members.find((each) => each.name === e.target.value);
              if (next) change({ branch: next.name, value: draft(store.types, next.type) });
            }}
          >
            {node.members.map((each) => (
              <option key={each.name} value={each.name}>{each.name}</option>
            ))}
          </select>
          {member && <Form type={member.type} value={chosen.value} label={`${label}.${member.name}`} change={(part) => change({ branch: member.name, value: part })} />}
        </div>
      );
    }
    case "TYPE_ARRAY":
      return <Elements slot={slot} type={node.element} />;
    case "TYPE_SEQUENCE":
      return <Elements slot={slot} type={node.element} bound={node.bound} fresh={() => draft(store.types, node.element)} />;
    case "TYPE_MAP":
      return <Elements slot={slot} type={node.element} keys={node.key} bound={node.bound} fresh={() => [draft(store.types, node.key), draft(store.types, node.element)]} />;
    default: {
      const limits = range(node);
      const hint = limits ? t("{low} to {high}", { low: limits[0], high: limits[1] }) : undefined;
      return <input {...common} {...said} title={hint} type="text" inputMode={limits ? "numeric" : undefined} value={String(value)} onChange={(e) => change(e.target.value)} />;
    }
  }
}

function Member({ member, value, label, change }: { member: TypeMember; value: Draft; label: string; change: (value: Draft) => void }) {
  const path = label ? `${label}.${member.name}` : member.name;
  return (
    <div className="member">
      <span>{member.name}</span>
      {member.optional && (
        <input type="checkbox" aria-label={t("{path} is given", { path })} checked={value !== null} onChange={(e) => change(e.target.checked ? draft(store.types, member.type) : null)} />
      )}
      {!(member.optional && value === null) && <Form type={member.type} value={value} label={path} change={change} />}
    </div>
  );
}

/** Elements of an array, sequence or map; those of sequences and maps can be added up to the bound. */
function Elements({ slot, type, keys, bound = 0, fresh }: { slot: Slot; type: number; keys?: number; bound?: number; fresh?: () => Draft }) {
  const { label, change } = slot;
  const parts = slot.value as Draft[];
  const put = (i: number, part: Draft) => change(parts.map((each, at) => (at === i ? part : each)));
  return (
    <div className="elements">
      {parts.map((part, i) => {
        const name = `${label}[${i}]`;
        const pair = part as [Draft, Draft];
        return (
          <div key={i} className="member">
            {keys !== undefined && <Form type={keys} value={pair[0]} label={t("{name}, key", { name })} change={(key) => put(i, [key, pair[1]])} />}
            <Form type={type} value={keys === undefined ? part : pair[1]} label={name} change={(next) => put(i, keys === undefined ? next : [pair[0], next])} />
            {fresh && (
              <button type="button" aria-label={t("Remove {name}", { name })} onClick={() => change(parts.filter((_, at) => at !== i))}>
                −
              </button>
            )}
          </div>
        );
      })}
      {fresh && (
        <button type="button" aria-label={t("Add to {label}", { label })} disabled={bound > 0 && parts.length >= bound} onClick={() => change([...parts, fresh()])}>
          +
        </button>
      )}
    </div>
  );
}

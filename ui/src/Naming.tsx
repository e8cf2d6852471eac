/** The trees of naming services: contexts, and components with their states. */

import type { Binding, Component, SystemState } from "./protocol/Ui.ts";
import { stateClass, stateOf, store } from "./store.ts";
import { t } from "./texts.ts";

interface Branch {
  binding: Binding;
  name: string;
  inside: Branch[];
}

/** The parts of a path; `\` escapes separators within a name. */
const parts = (path: string): string[] => path.match(/(?:\\.|[^\\/])+/g) ?? [];

/** The names of a service as a tree; each name follows its context. */
export function tree(bindings: readonly Binding[]): Branch[] {
  const top: Branch[] = [];
  const open: Branch[] = [];
  for (const binding of bindings) {
    const names = parts(binding.path);
    const branch = { binding, name: names.at(-1) ?? binding.path, inside: [] };
    open.length = Math.min(open.length, names.length - 1);
    (open.at(-1)?.inside ?? top).push(branch);
    open.push(branch);
  }
  return top;
}

interface Shown {
  components: ReadonlyMap<string, Component>;
  selected: string;
  select: (instance: string) => void;
}

function Names({ branches, ...shown }: Shown & { branches: readonly Branch[] }) {
  return (
    <ul>
      {branches.map(({ binding, name, inside }) => (
        <li key={binding.path}>
          {binding.kind === "BINDING_CONTEXT" ? (
            <details open>
              <summary>{name}</summary>
              <Names branches={inside} {...shown} />
            </details>
          ) : (
            <Name binding={binding} name={name} {...shown} />
          )}
        </li>
      ))}
    </ul>
  );
}

function Name({ binding, name, components, selected, select }: Shown & { binding: Binding; name: string }) {
  const component = components.get(binding.instance);
  const dead = binding.kind === "BINDING_DEAD";
  const state = dead ? t("does not answer") : component ? stateOf(component) : "";
  const mark = state && <small className={dead ? "reason" : `state ${component ? stateClass(component) : ""}`}>{state}</small>;
  if (!component)
    return (
      <span className={dead ? "dead" : ""}>
        <bdi>{name}</bdi> {mark}
      </span>
    );
  return (
    <button
      type="button"
      className={dead ? "dead" : ""}
      aria-pressed={selected === component.instance}
      aria-label={`${component.instance}, ${component.type}, ${state}`}
      title={component.silent || component.type}
      onClick={() => select(component.instance)}
    >
      <bdi>{name}</bdi> {mark}
    </button>
  );
}

export function Naming(props: { system: SystemState; full: boolean; selected: string; select: (instance: string) => void }) {
  const { system, full, selected, select } = props;
  if (!system.naming.length) return null;
  const known = new Map(system.components.map((each) => [each.instance, each]));
  return (
    <section className="naming" aria-label={t("Naming services")}>
      <h2>{t("Naming services")}</h2>
      {system.foreign.length > 0 && (
        <button type="button" disabled={!full} title={t("Connections, parameters and active sets of other processes, as the file of the system has them")} onClick={() => store.order({ case: "reset", value: true })}>
          {t("Restore from file")}
        </button>
      )}
      {system.naming.map((service) => (
        <details open key={service.address}>
          <summary>{service.address}</summary>
          {service.silent && <p className="reason">{service.silent}</p>}
          {!service.silent && !service.bindings.length && <p>{t("No names.")}</p>}
          <Names branches={tree(service.bindings)} components={known} selected={selected} select={select} />
        </details>
      ))}
    </section>
  );
}

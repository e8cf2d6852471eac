/** Renames an instance, or what a definition names; shows what changes before it does. */

import { useEffect, useState } from "react";
import { Changes } from "./Changes.tsx";
import { Button } from "./kit/Button.tsx";
import { Dialog } from "./kit/Dialog.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import type { FileChange, Rename as Asked, SystemState } from "./protocol/Ui.ts";
import { reasonOf, store } from "./store.ts";
import { t } from "./texts.ts";

type Subject = Pick<Asked, "kind" | "part"> & { name: string; label: string };

export function Rename({ system, instance, close, select }: { system: SystemState; instance: string; close: () => void; select: (instance: string) => void }) {
  const component = system.components.find((each) => each.instance === instance);
  const subjects: Subject[] = component
    ? [
        { kind: "RENAME_INSTANCE", part: "", name: instance, label: t("instance {instance}", { instance }) },
        { kind: "RENAME_COMPONENT", part: "", name: component.type, label: t("component {type}", { type: component.type }) },
        ...component.ports.map((each): Subject => ({ kind: "RENAME_PORT", part: each.name, name: each.name, label: t("port {name}", { name: each.name }) })),
        ...component.parameters.map((each): Subject => ({ kind: "RENAME_PARAMETER", part: each.name, name: each.name, label: t("parameter {name}", { name: each.name }) })),
      ]
    : [];
  const [chosen, choose] = useState(0);
  const [name, setName] = useState(instance);
  const [changes, show] = useState<readonly FileChange[]>();
  const [refused, refuse] = useState("");
  const [busy, wait] = useState(false);
  const subject = subjects[chosen];
  useEffect(() => {
    show(undefined);
    refuse("");
  }, [chosen, name]);
  if (!subject) return null;
  const order = async (carried_out: boolean) => {
    wait(true);
    const { kind, part } = subject;
    const result = await store.ask({ case: "renamed", value: { kind, part, instance, name: name.trim(), carried_out } });
    wait(false);
    if (!result.done) {
      refuse(reasonOf(result));
      return;
    }
    show(result.renamed);
    if (!carried_out) return;
    if (kind === "RENAME_INSTANCE") select(name.trim());
    close();
  };
  const isNew = name.trim() !== "" && name.trim() !== subject.name;
  return (
    <Dialog title={t("Rename")} close={close} className="rename">
      <form
        onSubmit={(e) => {
          e.preventDefault();
          if (isNew && !busy) void order(changes !== undefined);
        }}
      >
        <label>
          {t("What")}
          <select
            aria-label={t("What is renamed")}
            value={chosen}
            onChange={(e) => {
              choose(Number(e.target.value));
              setName(subjects[Number(e.target.value)]!.name);
            }}
          >
            {subjects.map((each, i) => (
              <option key={each.label} value={i}>
                {each.label}
              </option>
            ))}
          </select>
        </label>
        <Refusable reason={refused}>
          {(said) => (
            <label>
              {t("New name")}
              <input autoFocus value={name} {...said} onFocus={(e) => e.target.select()} onChange={(e) => setName(e.target.value)} />
            </label>
          )}
        </Refusable>
        {changes && (
          <section aria-label={t("What changes")} className="changes" tabIndex={0}>
            <p>
              {t("{count} {count:file changes|files change}, what is generated follows, and the run begins again. Undo takes it back.", { count: changes.length })}
            </p>
            <Changes changes={changes} />
          </section>
        )}
        <div className="answers">
          <Button onClick={close}>{t("Cancel")}</Button>
          <Button type="submit" look="primary" disabled={!isNew || busy}>
            {changes ? t("Rename") : t("Show what changes")}
          </Button>
        </div>
      </form>
    </Dialog>
  );
}

/** Where there is something, while a view of a component has nothing to show. */

import type { Component, SystemState } from "./protocol/Ui.ts";
import { t } from "./texts.ts";

interface Props {
  /** Why the view is empty. */
  reason: string;
  system: SystemState;
  has: (component: Component) => boolean;
  select: (instance: string) => void;
}

export function Elsewhere({ reason, system, has, select }: Props) {
  const others = system.components.filter(has);
  return (
    <>
      <p>{reason}</p>
      <p>{others.length ? t("Others have some:") : t("No other one has any.")}</p>
      {others.length > 0 && (
        <ul className="ends" aria-label={t("Components with something here")}>
          {others.map(({ instance }) => (
            <li key={instance}>
              <button type="button" className="link plain" onClick={() => select(instance)}>
                {instance}
              </button>
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

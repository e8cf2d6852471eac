/** Panes beside each other, with grips; the sizes are remembered. Below each other where there is no room. */

import { Group, Panel, Separator, useDefaultLayout } from "react-resizable-panels";
import type { ReactNode } from "react";
import { Fragment, useSyncExternalStore } from "react";

export interface Pane {
  id: string;
  /** Sizes as CSS lengths. */
  size?: string;
  least: string;
  content: ReactNode;
}

const roomy = matchMedia("(min-width: 1001px)");
const whenRoomChanges = (listener: () => void) => {
  roomy.addEventListener("change", listener);
  return () => roomy.removeEventListener("change", listener);
};

/** Whether the window has room for panes beside each other. */
export const useRoom = (): boolean => useSyncExternalStore(whenRoomChanges, () => roomy.matches);

export function Split({ id, panes, className = "" }: { id: string; panes: readonly Pane[]; className?: string }) {
  const isWide = useRoom();
  const layout = useDefaultLayout({ id, panelIds: panes.map((each) => each.id), storage: localStorage });
  if (!isWide)
    return (
      <div className={`stack ${className}`}>
        {panes.map((each) => (
          <Fragment key={each.id}>{each.content}</Fragment>
        ))}
      </div>
    );
  return (
    <Group id={id} className={className} {...layout}>
      {panes.map((each, i) => (
        <Fragment key={each.id}>
          {i > 0 && <Separator className="grip" aria-label={`Width of ${each.id}`} />}
          <Panel id={each.id} minSize={each.least} {...(each.size && { defaultSize: each.size })}>
            {each.content}
          </Panel>
        </Fragment>
      ))}
    </Group>
  );
}

/** How wide the window is. */

import { useSyncExternalStore } from "react";

const asked = (query: string) => {
  const list = matchMedia(query);
  return {
    get: () => list.matches,
    subscribe: (listener: () => void) => {
      list.addEventListener("change", listener);
      return () => list.removeEventListener("change", listener);
    },
  };
};

/** Whether there is room for panes beside each other. */
export const ROOM = asked("(min-width: 1001px)");
/** Whether the head of the page has no room for its buttons. */
export const PHONE = asked("(max-width: 600px)");

export const useWidth = (of: typeof ROOM): boolean => useSyncExternalStore(of.subscribe, of.get);

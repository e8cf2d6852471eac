/** Where the focus goes when a window closes. */

import { useEffect, useRef } from "react";

/** Gives the focus back to what had it: dialogs do so only if a button of theirs has opened them. */
export function useFocusBack(): void {
  const before = useRef(document.activeElement);
  useEffect(() => () => (before.current as HTMLElement | null)?.focus(), []);
}

/** Keys open a select instead of changing its value at once, as for a select-only combobox (ARIA APG): an option has its effect when it is chosen. */

import type { KeyboardEvent } from "react";

/** Keys that change the value of a closed select in some browsers. */
const MOVES = ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Home", "End", "PageUp", "PageDown"];

export function openPicker(e: KeyboardEvent): void {
  const { target, key } = e;
  // Keys in an open list are not commands for the wiring.
  if (target instanceof HTMLOptionElement) e.stopPropagation();
  if (!(target instanceof HTMLSelectElement) || e.ctrlKey || e.metaKey || e.altKey || !("showPicker" in target)) return;
  if (MOVES.includes(key)) e.preventDefault();
  // The opened list receives a typed character.
  else if (key.length > 1 || key === " ") return;
  target.showPicker();
}

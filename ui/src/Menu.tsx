/** A context menu, by mouse and by keyboard. */

import { useLayoutEffect, useRef } from "react";
import { Above } from "./kit/Above.tsx";

export interface Item {
  name: string;
  act: () => void;
  /** Why it cannot be chosen; empty if it can. */
  obstacle?: string;
  /** Whether it begins a group. */
  begins?: boolean;
}

/** The subject of a menu, and its position [px of the page]. */
export interface Place {
  label: string;
  x: number;
  y: number;
}

export function Menu({ place, items, close }: { place: Place; items: readonly Item[]; close: () => void }) {
  const menu = useRef<HTMLDivElement>(null);
  const before = useRef(document.activeElement);
  useLayoutEffect(() => {
    const box = menu.current!;
    box.style.left = `${Math.max(0, Math.min(place.x, window.innerWidth - box.offsetWidth))}px`;
    box.style.top = `${Math.max(0, Math.min(place.y, window.innerHeight - box.offsetHeight))}px`;
    (box.firstElementChild as HTMLElement).focus();
  }, [place]);
  const end = () => {
    close();
    (before.current as HTMLElement | null)?.focus();
  };
  return (
    <Above>
      <div
        ref={menu}
        className="menu"
        role="menu"
        aria-label={place.label}
        onKeyDown={(e) => {
          const each = [...e.currentTarget.children] as HTMLElement[];
          const at = each.indexOf(e.target as HTMLElement);
          const next = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: -1 }[e.key];
          e.stopPropagation();
          if (next !== undefined) each.at(next % each.length)!.focus();
          else if (e.key === "Escape" || e.key === "Tab") end();
          else return;
          e.preventDefault();
        }}
        onBlur={(e) => e.currentTarget.contains(e.relatedTarget) || close()}
      >
        {items.map(({ name, act, obstacle = "", begins }) => (
          <button
            key={name}
            type="button"
            role="menuitem"
            className={begins ? "begins" : ""}
            aria-disabled={obstacle !== ""}
            title={obstacle}
            onClick={() => {
              if (obstacle) return;
              end();
              act();
            }}
          >
            {name}
            {obstacle && <small>{obstacle}</small>}
          </button>
        ))}
      </div>
    </Above>
  );
}

/** Views of which one is shown; arrow keys change it (ARIA APG). The tab of the view that is shown is the one that Tab reaches, whatever has opened it. */

import type { ReactNode } from "react";
import { useId } from "react";

interface Props<Name extends string> {
  label: string;
  names: readonly Name[];
  /** The name as people read it. */
  title?: (name: Name) => string;
  shown: Name;
  show: (name: Name) => void;
  children: ReactNode;
}

export function Tabs<Name extends string>({ label, names, title = String, shown, show, children }: Props<Name>) {
  const id = useId();
  return (
    <>
      <div
        role="tablist"
        aria-label={label}
        className="tabs"
        onKeyDown={(e) => {
          const at = names.indexOf(shown);
          const next = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: -1 }[e.key];
          if (next === undefined) return;
          e.preventDefault();
          show(names.at(next % names.length)!);
          ([...e.currentTarget.children].at(next % names.length) as HTMLElement).focus();
        }}
      >
        {names.map((name) => (
          <button key={name} type="button" role="tab" aria-selected={shown === name} {...(shown === name && { "aria-controls": id })} tabIndex={shown === name ? 0 : -1} onClick={() => show(name)}>
            {title(name)}
          </button>
        ))}
      </div>
      <div role="tabpanel" id={id} tabIndex={-1} aria-label={title(shown)}>
        {children}
      </div>
    </>
  );
}

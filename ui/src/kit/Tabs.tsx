/** Views of which one is shown; arrow keys change it. */

import { Tabs as Base } from "radix-ui";
import type { ReactNode } from "react";

interface Props<Name extends string> {
  label: string;
  names: readonly Name[];
  shown: Name;
  show: (name: Name) => void;
  children: ReactNode;
}

export function Tabs<Name extends string>({ label, names, shown, show, children }: Props<Name>) {
  return (
    <Base.Root value={shown} onValueChange={(name) => show(name as Name)}>
      <Base.List className="tabs" aria-label={label} loop>
        {names.map((name) => (
          <Base.Trigger key={name} value={name}>
            {name}
          </Base.Trigger>
        ))}
      </Base.List>
      <Base.Content value={shown} tabIndex={-1} aria-label={shown} aria-labelledby={undefined}>
        {children}
      </Base.Content>
    </Base.Root>
  );
}

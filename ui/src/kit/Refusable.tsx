/** A field whose value can be refused: the reason is below it, and is its description. */

import type { ReactNode } from "react";
import { useId } from "react";

/** What the field says of itself; of a group of fields, the description alone. */
export interface Refused {
  "aria-invalid"?: true;
  "aria-describedby"?: string;
}

export function Refusable({ reason, children }: { reason: string | undefined; children: (refused: Refused) => ReactNode }) {
  const id = useId();
  return (
    <>
      {children(reason ? { "aria-invalid": true, "aria-describedby": id } : {})}
      {reason && (
        <p id={id} className="reason refused" role="alert">
          {reason}
        </p>
      )}
    </>
  );
}

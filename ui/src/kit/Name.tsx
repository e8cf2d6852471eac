/** Names that break between their parts, not inside of words. */

import { Fragment } from "react";

/** Longer parts are broken all the same. */
const LONGEST = 18;

/** The parts of a name, as `PositionInput0_1`, between which a line may end. */
export const partsOf = (name: string): string[] => (name.split(/(?<=[a-z\d])(?=[A-Z])|(?<=[_./:-])(?=[^_./:-])/).flatMap((part) => part.match(new RegExp(`.{1,${LONGEST}}`, "gsu")) ?? []));

export function Name({ text }: { text: string }) {
  return partsOf(text).map((part, i) => (
    <Fragment key={i}>
      {i > 0 && <wbr />}
      {part}
    </Fragment>
  ));
}

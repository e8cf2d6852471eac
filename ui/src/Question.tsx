/** A question that must be answered before anything else. */

import type { ReactNode } from "react";
import { useEffect, useId, useRef } from "react";

interface Props {
  text: string;
  /** What `yes` does, as the name of its button. */
  name: string;
  yes: () => void;
  close: () => void;
  /** Fields, which must be valid for `yes`. */
  children?: ReactNode;
}

export function Question({ text, name, yes, close, children }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  const id = useId();
  useEffect(() => dialog.current!.showModal(), []);
  return (
    <dialog ref={dialog} className="question" role="alertdialog" aria-labelledby={id} onClose={close}>
      <p id={id}>{text}</p>
      <form method="dialog">
        {children}
        <button type="submit" onClick={(e) => e.currentTarget.form!.checkValidity() && yes()}>
          {name}
        </button>
        <button type="submit" formNoValidate autoFocus={!children}>
          Cancel
        </button>
      </form>
    </dialog>
  );
}

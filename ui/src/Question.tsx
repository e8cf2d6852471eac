/** A question that must be answered before anything else. */

import { useEffect, useId, useRef } from "react";

interface Props {
  text: string;
  /** What `yes` does, as the name of its button. */
  name: string;
  yes: () => void;
  close: () => void;
}

export function Question({ text, name, yes, close }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  const id = useId();
  useEffect(() => dialog.current!.showModal(), []);
  return (
    <dialog ref={dialog} className="question" role="alertdialog" aria-labelledby={id} onClose={close}>
      <p id={id}>{text}</p>
      <form method="dialog">
        <button type="submit" onClick={yes}>
          {name}
        </button>
        <button type="submit" autoFocus>
          Cancel
        </button>
      </form>
    </dialog>
  );
}

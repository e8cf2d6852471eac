/** A question that must be answered before anything else. */

import type { FormEvent, ReactNode } from "react";
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
  const end = () => {
    dialog.current!.close(); // it gives the focus back
    close();
  };
  const answer = (event: FormEvent) => {
    event.preventDefault();
    yes();
    end();
  };
  return (
    <dialog ref={dialog} className="question" role="alertdialog" aria-labelledby={id} onClose={close}>
      <p id={id}>{text}</p>
      <form onSubmit={answer}>
        {children}
        <button type="submit">{name}</button>
        <button type="button" autoFocus={!children} onClick={end}>
          Cancel
        </button>
      </form>
    </dialog>
  );
}

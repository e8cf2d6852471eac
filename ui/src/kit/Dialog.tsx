/** Dialogs: a window over the page, and a question that must be answered before anything else. */

import * as AlertDialog from "@radix-ui/react-alert-dialog";
import * as Window from "@radix-ui/react-dialog";
import { X } from "lucide-react";
import type { FormEvent, ReactNode } from "react";
import { Button } from "./Button.tsx";
import { useFocusBack } from "./focus.ts";
import { t } from "../texts.ts";

export function Dialog({ title, close, children, className = "" }: { title: string; close: () => void; children: ReactNode; className?: string }) {
  useFocusBack();
  return (
    <Window.Root open onOpenChange={(open) => open || close()}>
      <Window.Portal>
        <Window.Overlay className="veil" />
        <Window.Content className={`dialog ${className}`} aria-describedby={undefined}>
          <Window.Title>{title}</Window.Title>
          {children}
          <Button look="plain" className="icon close" aria-label={t("Close {title}", { title })} onClick={close}>
            <X size={16} aria-hidden />
          </Button>
        </Window.Content>
      </Window.Portal>
    </Window.Root>
  );
}

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
  useFocusBack();
  const answer = (event: FormEvent) => {
    event.preventDefault();
    yes();
    close();
  };
  return (
    <AlertDialog.Root open onOpenChange={(open) => open || close()}>
      <AlertDialog.Portal>
        <AlertDialog.Overlay className="veil" />
        <AlertDialog.Content className="dialog" aria-describedby={undefined} onOpenAutoFocus={(e) => children && e.preventDefault()}>
          <AlertDialog.Title asChild>
            <p>{text}</p>
          </AlertDialog.Title>
          <form onSubmit={answer}>
            {children}
            <div className="answers">
              <AlertDialog.Cancel asChild>
                <Button>{t("Cancel")}</Button>
              </AlertDialog.Cancel>
              <Button type="submit" look="primary">
                {name}
              </Button>
            </div>
          </form>
        </AlertDialog.Content>
      </AlertDialog.Portal>
    </AlertDialog.Root>
  );
}

/** Buttons: with a text, or with an icon whose name and keys a tip shows. */

import * as Tooltip from "@radix-ui/react-tooltip";
import type { LucideIcon } from "lucide-react";
import type { ButtonHTMLAttributes, ReactNode, Ref } from "react";

export type Look = "quiet" | "primary" | "danger" | "plain";

interface Common extends ButtonHTMLAttributes<HTMLButtonElement> {
  ref?: Ref<HTMLButtonElement>;
  icon?: LucideIcon;
  look?: Look;
}

export function Button({ icon: Icon, look = "quiet", className = "", children, ...rest }: Common & { children: ReactNode }) {
  return (
    <button type="button" className={`${look} ${className}`} {...rest}>
      {Icon && <Icon size={16} aria-hidden />}
      {children}
    </button>
  );
}

/** A button that keeps the focus, and its tip, when it is disabled. */
export function IconButton({ icon: Icon, look = "quiet", label, tip, keys, disabled, onClick, className = "", ...rest }: Common & { icon: LucideIcon; label: string; tip?: string; keys?: string }) {
  return (
    <Tooltip.Root>
      <Tooltip.Trigger asChild>
        <button type="button" className={`icon ${look} ${className}`} aria-label={label} aria-disabled={disabled} onClick={disabled ? undefined : onClick} {...rest}>
          <Icon size={16} aria-hidden />
        </button>
      </Tooltip.Trigger>
      <Tooltip.Portal>
        <Tooltip.Content className="tip" sideOffset={6} collisionPadding={8}>
          {tip || label} {keys && <kbd>{keys}</kbd>}
        </Tooltip.Content>
      </Tooltip.Portal>
    </Tooltip.Root>
  );
}

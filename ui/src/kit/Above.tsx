/** What stands above all panes: within one of them, a grip between panes would take the presses on it. */

import type { ReactNode } from "react";
import { createPortal } from "react-dom";

export const Above = ({ children }: { children: ReactNode }) => createPortal(children, document.querySelector("main") ?? document.body);

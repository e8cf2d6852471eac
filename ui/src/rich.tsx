/** Texts of the page that have elements in them. */

import type { ReactNode } from "react";
import { filled } from "./texts.ts";

/** A text with elements in the places of their names. */
export const rich = (english: string, values: Readonly<Record<string, ReactNode>>): ReactNode => (
  <>{...filled(english, (name) => values[name])}</>
);

/** What the address says of the page behind its #: the panes, the selected component, the view of a narrow page, the filter of the timeline. */

import { useEffect, useState } from "react";

type Name = "panes" | "component" | "view" | "kind" | "of" | "words";

function parts(): Map<string, string> {
  const pairs = location.hash
    .slice(1)
    .split("&")
    .map((each) => /^(\w+)=(.*)$/.exec(each))
    .filter((each) => each !== null);
  return new Map(pairs.map(([, name, text]) => [name!, text!]));
}

/** Whether the page of all components is shown, which needs no server. */
export const isGallery = (): boolean => location.hash === "#components";

export function stated(name: Name): string {
  try {
    return decodeURIComponent(parts().get(name) ?? "");
  } catch {
    return ""; // a text that nobody has written by `state`
  }
}

/** States a part of the page in its address; nothing for an empty text. */
export function state(name: Name, text: string): void {
  const all = parts();
  if (text) all.set(name, encodeURIComponent(text).replace(/%2[CF8B]|%29|%2a/gi, decodeURIComponent));
  else all.delete(name);
  const hash = [...all].map(([name, text]) => `${name}=${text}`).join("&");
  history.replaceState(null, "", `${location.pathname}${location.search}${hash && `#${hash}`}`);
}

/** A part of the page that is kept in its address. */
export function useStated(name: Name): readonly [string, (text: string) => void] {
  const [text, setText] = useState(() => stated(name));
  useEffect(() => {
    const follow = () => setText(stated(name));
    window.addEventListener("hashchange", follow);
    return () => window.removeEventListener("hashchange", follow);
  }, [name]);
  return [
    text,
    (text) => {
      setText(text);
      state(name, text);
    },
  ];
}

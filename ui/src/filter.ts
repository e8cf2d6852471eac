/**
 * The language of filters of frames: words, comparisons as `id:180-1FF`, `node=2` and `velocity>0.5`;
 * all must hold, `|` joins alternatives, `!` negates, brackets group, quotes keep blanks.
 */

import type { Frame } from "./protocol/Ui.ts";
import { t } from "./texts.ts";
import { hexadecimal, identifierOf, wordsOf } from "./traffic.ts";

export type Test = (frame: Frame) => boolean;

class FilterError extends Error {}

const TOKEN = /\s*(?:([()|!&])|((?:"[^"]*"?|[^\s()|&"])+))/gy;
const COMPARISON = /^([A-Za-z_][\w.]*)(!=|<=|>=|[:=<>])(.*)$/s;

function tokensOf(text: string): string[] {
  const found: string[] = [];
  TOKEN.lastIndex = 0;
  for (let at = TOKEN.exec(text); at; at = TOKEN.exec(text)) found.push(at[1] ?? at[2]!);
  return found;
}

const bare = (word: string): string => word.replaceAll('"', "");

/** The text in which words are looked for. */
const textOf = (frame: Frame): string => `${identifierOf(frame)} ${frame.kind} node${frame.node_id} ${wordsOf(frame)}`.toLowerCase();

/** A text in which `*` stands for any characters. */
function pattern(text: string): RegExp {
  const parts = text.split("*").map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${parts.join(".*")}$`, "i");
}

type Relation = ":" | "=" | "!=" | "<" | "<=" | ">" | ">=";

function holds(value: number, relation: Relation, other: number): boolean {
  switch (relation) {
    case "<":
      return value < other;
    case "<=":
      return value <= other;
    case ">":
      return value > other;
    case ">=":
      return value >= other;
    case "!=":
      return value !== other;
    default:
      return value === other;
  }
}

/** Compares a number with one, or with a range `a-b`; `read` reads them. */
function numeric(key: string, relation: Relation, text: string, read: (text: string) => number): (value: number) => boolean {
  const [first, last] = text.split(/(?<=.)-(?=.)/).map(read);
  if (first === undefined || Number.isNaN(first) || (last !== undefined && Number.isNaN(last))) throw new FilterError(t("{key}{relation} needs a number, not {text}", { key, relation, text: text || t("nothing") }));
  if (last === undefined) return (value) => holds(value, relation, first);
  if (relation !== ":" && relation !== "=" && relation !== "!=") throw new FilterError(t("{key}{relation} needs one number, not a range", { key, relation }));
  return (value) => (value >= first && value <= last) !== (relation === "!=");
}

const decimal = (text: string): number => (text.trim() ? Number(text) : NaN);
const hexadecimalNumber = (text: string): number => (/^(?:0x)?[\da-f]+$/i.test(text) ? parseInt(text, 16) : NaN);

function comparison(key: string, relation: Relation, text: string): Test {
  switch (key.toLowerCase()) {
    case "id": {
      const fits = numeric(key, relation, text, hexadecimalNumber);
      return (frame) => fits(frame.can_id);
    }
    case "node": {
      const fits = numeric(key, relation, text, decimal);
      return (frame) => fits(frame.node_id);
    }
    case "len": {
      const fits = numeric(key, relation, text, decimal);
      return (frame) => fits(frame.data.length);
    }
    case "time": {
      const fits = numeric(key, relation, text, decimal);
      return (frame) => fits(frame.time);
    }
    case "kind": {
      const wanted = pattern(text);
      return (frame) => wanted.test(frame.kind) !== (relation === "!=");
    }
    case "data": {
      const wanted = pattern(text.replace(/\s/g, "") + (text.includes("*") ? "" : "*"));
      return (frame) => wanted.test(hexadecimal(frame.data).replaceAll(" ", "")) !== (relation === "!=");
    }
    default: {
      // A field of that name: of the node's object, whatever comes before its last dot.
      const name = key.toLowerCase();
      const value = decimal(text);
      const wanted = pattern(text);
      return (frame) =>
        frame.fields.some((field) => {
          if (!field.name.toLowerCase().includes(name)) return false;
          if (field.numeric && !Number.isNaN(value)) return holds(field.number, relation, value);
          return (relation === ":" || relation === "=" || relation === "!=") && wanted.test(field.text) !== (relation === "!=");
        });
    }
  }
}

/** Compiles a filter; without words it takes all frames. Returns what is wrong with it, if something is. */
export function filterOf(text: string): Test | string {
  const tokens = tokensOf(text);
  let at = 0;
  const alternatives = (): Test => {
    const found = [all()];
    while (tokens[at] === "|") {
      at += 1;
      found.push(all());
    }
    return (frame) => found.some((each) => each(frame));
  };
  const all = (): Test => {
    const found: Test[] = [];
    while (at < tokens.length && tokens[at] !== "|" && tokens[at] !== ")") {
      if (tokens[at] === "&") at += 1;
      else found.push(one());
    }
    if (!found.length && tokens.length) throw new FilterError(t("nothing stands beside |, or between brackets"));
    return (frame) => found.every((each) => each(frame));
  };
  const one = (): Test => {
    const token = tokens[at++];
    if (token === undefined) throw new FilterError(t("nothing follows !"));
    if (token === "!") {
      const negated = one();
      return (frame) => !negated(frame);
    }
    if (token === "(") {
      const inner = alternatives();
      if (tokens[at++] !== ")") throw new FilterError(t("a bracket is not closed"));
      return inner;
    }
    if (")|&".includes(token)) throw new FilterError(t("nothing stands before {token}", { token }));
    if (token.startsWith("!")) {
      tokens.splice(at, 0, token.slice(1));
      const negated = one();
      return (frame) => !negated(frame);
    }
    const compared = COMPARISON.exec(token);
    if (compared) return comparison(compared[1]!, compared[2] as Relation, bare(compared[3]!));
    const word = bare(token).toLowerCase();
    return (frame) => textOf(frame).includes(word);
  };
  try {
    const test = alternatives();
    if (at < tokens.length) throw new FilterError(t("a bracket is closed that is not open"));
    return test;
  } catch (error) {
    if (!(error instanceof FilterError)) throw error;
    return error.message;
  }
}

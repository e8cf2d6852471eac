/** Values of forms: texts until they are validated against their type. */

import type { TypeMember, TypeNode } from "./protocol/Ui.ts";
import type { TypeTable } from "./protocol/table.ts";
import { t } from "./texts.ts";

/** Text or boolean for a scalar; null for a missing optional member. */
export type Draft = string | boolean | null | Draft[] | Chosen | { [name: string]: Draft };

/** The selected branch of a union, and its value. */
export interface Chosen {
  branch: string;
  value: Draft;
}

export class DraftError extends Error {
  override name = "DraftError";
  /** That of the value, as fields have it; empty: it is about none. */
  readonly path: string;

  constructor(message: string, path = "") {
    super(path ? `${path}: ${message}` : message);
    this.path = path;
  }
}

const INTEGERS: Partial<Record<TypeNode["kind"], readonly [bigint, bigint]>> = {
  TYPE_OCTET: [0n, 255n],
  TYPE_INT8: [-128n, 127n],
  TYPE_SHORT: [-32768n, 32767n],
  TYPE_USHORT: [0n, 65535n],
  TYPE_LONG: [-2147483648n, 2147483647n],
  TYPE_ULONG: [0n, 4294967295n],
  TYPE_LONGLONG: [-(1n << 63n), (1n << 63n) - 1n],
  TYPE_ULONGLONG: [0n, (1n << 64n) - 1n],
};

const MAX_ELEMENTS = 256;

/** The least and greatest value of an integer type or bitmask; undefined for other types. */
export function range(node: TypeNode): readonly [bigint, bigint] | undefined {
  return node.kind === "TYPE_BITMASK" ? [0n, (1n << BigInt(node.bound)) - 1n] : INTEGERS[node.kind];
}

export function isNumber(node: TypeNode): boolean {
  return node.kind === "TYPE_FLOAT" || node.kind === "TYPE_DOUBLE" || range(node) !== undefined;
}

function node(table: TypeTable, type: number): TypeNode {
  const found = table.nodes[type];
  if (!found) throw new DraftError(t("there is no type {type}", { type }));
  return found;
}

/** The initial value of a form. Throws DraftError if a form does not support the type. */
export function draft(table: TypeTable, type: number): Draft {
  checkLengths(table, type);
  return drafted(table, type, table.codec(type).initial());
}

/** Throws DraftError for a type with an array that is too long for a form. */
function checkLengths(table: TypeTable, type: number): void {
  const each = node(table, type);
  const length = each.dimensions.reduce((product, one) => product * one, 1);
  if (length > MAX_ELEMENTS) throw new DraftError(t("an array of {length} elements is too long for a form", { length }));
  if (each.kind === "TYPE_ARRAY") checkLengths(table, each.element);
  if (each.kind === "TYPE_STRUCT") each.members.forEach((one) => one.optional || checkLengths(table, one.type));
}

/** Converts a value to a draft. */
function drafted(table: TypeTable, type: number, value: unknown): Draft {
  const each = node(table, type);
  switch (each.kind) {
    case "TYPE_BOOLEAN":
      return value === true;
    case "TYPE_CHAR":
    case "TYPE_WCHAR":
      return value === "\0" ? " " : String(value);
    case "TYPE_SEQUENCE":
    case "TYPE_ARRAY":
      return items(value, each.dimensions.length).map((one) => drafted(table, each.element, one));
    case "TYPE_MAP":
      return [...(value as Map<unknown, unknown>)].map(([k, v]) => [drafted(table, each.key, k), drafted(table, each.element, v)]);
    case "TYPE_STRUCT": {
      const parts = value as Record<string, unknown>;
      return Object.fromEntries(
        each.members.map((one) => {
          const part = parts[one.name];
          return [one.name, one.optional && part === null ? null : drafted(table, one.type, part)];
        }),
      );
    }
    case "TYPE_UNION": {
      const { case: branch, value: part } = value as { case: string | null; value: unknown };
      const member = each.members.find((one) => one.name === branch);
      if (member) return { branch: member.name, value: drafted(table, member.type, part) };
      const first = each.members[0];
      return { branch: first?.name ?? "", value: first ? draft(table, first.type) : null };
    }
    default:
      return String(value);
  }
}

/** The elements of a list, octets or characters; those of all dimensions in a row. */
function items(value: unknown, dimensions: number): unknown[] {
  const list = [...(value as Iterable<unknown>)];
  return dimensions > 1 ? list.flatMap((one) => items(one, dimensions - 1)) : list;
}

/** Converts a draft to a value. Throws DraftError, whose message begins with the path. */
export function finish(table: TypeTable, type: number, value: Draft, path = ""): unknown {
  const each = node(table, type);
  const fail = (text: string): never => {
    throw new DraftError(text, path);
  };
  const inner = (one: number, part: Draft, step: string) => finish(table, one, part, path ? `${path}${step}` : step.replace(/^\./, ""));
  const limits = range(each);
  if (limits) return integer(each, String(value).trim(), limits, fail);
  switch (each.kind) {
    case "TYPE_FLOAT":
    case "TYPE_DOUBLE": {
      const text = String(value).trim();
      return text === "" || Number.isNaN(Number(text)) ? fail(t("{text} is not a number", { text: JSON.stringify(text) })) : Number(text);
    }
    case "TYPE_CHAR":
    case "TYPE_WCHAR":
      return String(value).length === 1 ? value : fail(t("one character is needed"));
    case "TYPE_STRING":
    case "TYPE_WSTRING":
      return each.bound && String(value).length > each.bound ? fail(t("at most {count} {count:character|characters}", { count: each.bound })) : value;
    case "TYPE_SEQUENCE": {
      const parts = value as Draft[];
      if (each.bound && parts.length > each.bound) fail(t("at most {count} {count:element|elements}", { count: each.bound }));
      const found = parts.map((part, i) => inner(each.element, part, `[${i}]`));
      const kind = node(table, each.element).kind;
      if (kind === "TYPE_OCTET") return Uint8Array.from(found as number[]);
      return kind === "TYPE_CHAR" ? found.join("") : found;
    }
    case "TYPE_ARRAY": {
      const found = (value as Draft[]).map((part, i) => inner(each.element, part, `[${i}]`));
      return nested(found, each.dimensions, node(table, each.element).kind);
    }
    case "TYPE_MAP": {
      const pairs = value as [Draft, Draft][];
      return new Map(pairs.map(([k, v], i) => [finish(table, each.key, k, t("{name}, key", { name: `${path}[${i}]` })), inner(each.element, v, `[${i}]`)]));
    }
    case "TYPE_STRUCT": {
      const parts = value as { [name: string]: Draft };
      return Object.fromEntries(
        each.members.map((one) => {
          const part = parts[one.name] ?? null;
          return [one.name, one.optional && part === null ? null : inner(one.type, part, `.${one.name}`)];
        }),
      );
    }
    case "TYPE_UNION": {
      const { branch, value: part } = value as Chosen;
      const member = each.members.find((one) => one.name === branch);
      if (!member) return fail(t("there is no branch {branch}", { branch }));
      const made = { case: branch, value: inner(member.type, part, `.${branch}`) };
      return member.labels.length ? made : { ...made, discriminator: otherLabel(table, each, fail) };
    }
    default:
      return value;
  }
}

function integer(each: TypeNode, text: string, [least, most]: readonly [bigint, bigint], fail: (text: string) => never): unknown {
  if (!/^-?\d+$|^0x[\da-f]+$/i.test(text)) return fail(t("{text} is not a whole number", { text: JSON.stringify(text) }));
  const number = BigInt(text);
  if (number < least || number > most) return fail(t("{number} is not between {least} and {most}", { number, least, most }));
  const wide = each.kind === "TYPE_LONGLONG" || each.kind === "TYPE_ULONGLONG" || (each.kind === "TYPE_BITMASK" && each.bound > 32);
  return wide ? number : Number(number);
}

/** Elements in the dimensions of their array; the innermost of octets and chars are one value. */
function nested(elements: unknown[], dimensions: readonly number[], kind: TypeNode["kind"]): unknown {
  if (dimensions.length <= 1) {
    if (kind === "TYPE_OCTET") return Uint8Array.from(elements as number[]);
    return kind === "TYPE_CHAR" ? elements.join("") : elements;
  }
  const [first = 0, ...rest] = dimensions;
  const size = elements.length / first;
  return Array.from({ length: first }, (_, i) => nested(elements.slice(i * size, (i + 1) * size), rest, kind));
}

/** A discriminator without a label, which selects the branch `default`. */
function otherLabel(table: TypeTable, union: TypeNode, fail: (text: string) => never): unknown {
  const taken = new Set(union.members.flatMap((one: TypeMember) => one.labels));
  const element = node(table, union.element);
  if (element.kind === "TYPE_ENUM") {
    const free = element.members.find((one) => !taken.has(one.labels[0] ?? 0n));
    return free?.name ?? fail(t("each label has a branch of its own"));
  }
  let free = 0n;
  while (taken.has(free)) free += 1n;
  switch (element.kind) {
    case "TYPE_BOOLEAN":
      return free === 1n;
    case "TYPE_CHAR":
    case "TYPE_WCHAR":
      return String.fromCharCode(Number(free));
    case "TYPE_LONGLONG":
    case "TYPE_ULONGLONG":
      return free;
    default:
      return Number(free);
  }
}

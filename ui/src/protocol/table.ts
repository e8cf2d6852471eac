/** Codecs of the types of samples, requests and replies, made of the table that the server sends. */

import type { TypeMember, TypeNode } from "./Ui.ts";
import * as cdr from "./_cdr.ts";

type Codec = cdr.CdrType<unknown>;

const BASIC: Partial<Record<TypeNode["kind"], Codec>> = {
  TYPE_BOOLEAN: cdr.boolean as Codec,
  TYPE_CHAR: cdr.char as Codec,
  TYPE_WCHAR: cdr.wchar as Codec,
  TYPE_OCTET: cdr.octet as Codec,
  TYPE_INT8: cdr.int8 as Codec,
  TYPE_SHORT: cdr.short as Codec,
  TYPE_USHORT: cdr.ushort as Codec,
  TYPE_LONG: cdr.long as Codec,
  TYPE_ULONG: cdr.ulong as Codec,
  TYPE_LONGLONG: cdr.longlong as Codec,
  TYPE_ULONGLONG: cdr.ulonglong as Codec,
  TYPE_FLOAT: cdr.float as Codec,
  TYPE_DOUBLE: cdr.double as Codec,
};

/** The table of types of one server: nodes are added, and never change. */
export class TypeTable {
  readonly nodes: TypeNode[] = [];
  private readonly codecs = new Map<number, Codec>();
  private readonly building = new Set<number>();

  /** Add the nodes whose first has the number `first`; what is known already is not changed. */
  add(first: number, nodes: readonly TypeNode[]): void {
    nodes.forEach((node, i) => {
      this.nodes[first + i] ??= node;
    });
  }

  /** The codec of a type by its number. Throws CdrError for an unknown number. */
  codec(number: number): Codec {
    const known = this.codecs.get(number);
    if (known) return known;
    const node = this.nodes[number];
    if (!node) throw new cdr.CdrError(`there is no type ${number}`);
    // A type inside its own definition is found when a value is read or written.
    if (this.building.has(number)) return cdr.lazy(node.name, () => this.codec(number));
    this.building.add(number);
    try {
      const type = this.make(node);
      const { initial } = node;
      const made = initial.length ? cdr.initially(type, () => cdr.decode(type, initial, true, 2)) : type;
      this.codecs.set(number, made);
      return made;
    } finally {
      this.building.delete(number);
    }
  }

  /** Whether the page has a codec of a type. */
  reads(number: number): boolean {
    try {
      return Boolean(this.codec(number));
    } catch (error) {
      if (error instanceof cdr.CdrError) return false;
      throw error;
    }
  }

  private make(node: TypeNode): Codec {
    const basic = BASIC[node.kind];
    if (basic) return basic;
    switch (node.kind) {
      case "TYPE_STRING":
        return cdr.string(node.bound) as Codec;
      case "TYPE_WSTRING":
        return cdr.wstring(node.bound) as Codec;
      case "TYPE_SEQUENCE": {
        const kind = this.nodes[node.element]?.kind;
        if (kind === "TYPE_OCTET") return cdr.octets(node.bound) as Codec;
        if (kind === "TYPE_CHAR") return cdr.chars(node.bound) as Codec;
        return cdr.sequence(this.codec(node.element), node.bound) as Codec;
      }
      case "TYPE_ARRAY":
        return cdr.array(this.codec(node.element), ...node.dimensions);
      case "TYPE_MAP":
        return cdr.map(this.codec(node.key), this.codec(node.element), node.bound) as Codec;
      case "TYPE_ENUM": {
        const numbers = node.members.map((each) => [each.name, Number(each.labels[0])] as const);
        return cdr.enumeration(node.name, Object.fromEntries(numbers), node.bound) as Codec;
      }
      case "TYPE_BITMASK":
        return (
          node.bound > 32 ? cdr.bitmask64(node.name) : cdr.bitmask(node.name, node.bound)
        ) as Codec;
      case "TYPE_UNION":
        return this.union(node);
      default: {
        const fields = node.members.map((each) =>
          cdr.field(each.name, this.codec(each.type), each.optional),
        );
        return cdr.struct(node.name, fields, node.appendable) as Codec;
      }
    }
  }

  private union(node: TypeNode): Codec {
    const branches = node.members.map((each) =>
      cdr.branch(each.name, this.codec(each.type), this.labels(node, each), each.is_default),
    );
    const discriminator = this.codec(node.element);
    return cdr.union(node.name, discriminator, branches, node.appendable) as Codec;
  }

  /** The labels of a branch as the codec of the discriminator has them. */
  private labels(node: TypeNode, member: TypeMember): (string | number | bigint | boolean)[] {
    const element = this.nodes[node.element];
    return member.labels.map((label) => {
      switch (element?.kind) {
        case "TYPE_ENUM":
          return element.members.find((each) => each.labels[0] === label)?.name ?? "";
        case "TYPE_BOOLEAN":
          return label !== 0n;
        case "TYPE_CHAR":
        case "TYPE_WCHAR":
          return String.fromCharCode(Number(label));
        case "TYPE_LONGLONG":
        case "TYPE_ULONGLONG":
          return label;
        default:
          return Number(label);
      }
    });
  }
}

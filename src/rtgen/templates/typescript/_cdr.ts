/**
 * Codecs of XCDR (DDS-XTypes 1.3, 7.4), made from descriptions of IDL types.
 *
 * Supports version 1 (PLAIN_CDR, which equals classic CDR except for wide characters and short enums)
 * and version 2 (PLAIN_CDR2, DELIMITED_CDR) in both byte orders. Does not depend on a browser; it
 * only needs the types to be erased.
 */

/** A value is invalid for its type, or octets cannot be decoded. */
export class CdrError extends Error {
  override name = "CdrError";
}

export type Version = 1 | 2;

/** A type of IDL: its initial value, and how values are read and written. */
export interface CdrType<T> {
  readonly name: string;
  /** A lower bound of the size of a value in octets. */
  readonly least: number;
  /** Whether sequences and arrays of the type have no DHEADER in version 2 (7.4.3.5). */
  readonly primitive: boolean;
  initial(): T;
  read(reader: Reader): T;
  write(writer: Writer, value: T): void;
}

/** The type of the values of a description. */
export type ValueOf<C> = C extends CdrType<infer T> ? T : never;

const MAX_DEPTH = 128;
const MAX_EMPTY_ELEMENTS = 1 << 16;

/** Reads the body of a value from its beginning. */
export class Reader {
  readonly octets: Uint8Array;
  readonly view: DataView;
  readonly littleEndian: boolean;
  readonly version: Version;
  offset = 0;
  end: number;
  /** The type of the whole body, until its value is read. */
  outermost: unknown;
  private depth = 0;

  constructor(octets: Uint8Array, littleEndian = true, version: Version = 1) {
    this.octets = octets;
    this.view = new DataView(octets.buffer, octets.byteOffset, octets.byteLength);
    this.littleEndian = littleEndian;
    this.version = version;
    this.end = octets.byteLength;
  }

  /** Consumes a scalar of a size; returns its offset. */
  take(size: number): number {
    const align = this.version === 2 && size > 4 ? 4 : size;
    const start = this.offset + ((align - (this.offset % align)) % align);
    if (start + size > this.end) {
      throw new CdrError(`truncated: ${size} octets are needed at ${start} of ${this.end}`);
    }
    this.offset = start + size;
    return start;
  }

  ulong(): number {
    return this.view.getUint32(this.take(4), this.littleEndian);
  }

  /** Reads the number of elements of a sequence or map; `least` is the minimum size of one. */
  count(least: number, bound: number): number {
    const count = this.ulong();
    if (bound && count > bound) throw new CdrError(`a length of ${count} beyond ${bound}`);
    if (least ? count * least > this.end - this.offset : count > MAX_EMPTY_ELEMENTS) {
      throw new CdrError(`a length of ${count}, and ${this.end - this.offset} octets are left`);
    }
    return count;
  }

  /** Reads octets, which share the memory of the message. */
  bytes(count: number): Uint8Array {
    if (count > this.end - this.offset) {
      throw new CdrError(`truncated: ${count} octets are needed at ${this.offset} of ${this.end}`);
    }
    this.offset += count;
    return this.octets.subarray(this.offset - count, this.offset);
  }

  /** Reads a value with a DHEADER, and skips unread octets up to its end. */
  delimited<T>(read: () => T): T {
    const size = this.ulong();
    if (size > this.end - this.offset) throw new CdrError(`a DHEADER of ${size} octets`);
    const outer = this.end;
    this.end = this.offset + size;
    const value = read();
    this.offset = this.end;
    this.end = outer;
    return value;
  }

  /** Reads a value that may contain values of its own type. */
  nested<T>(read: () => T): T {
    if (++this.depth > MAX_DEPTH) throw new CdrError(`nested deeper than ${MAX_DEPTH}`);
    const value = read();
    this.depth--;
    return value;
  }
}

/** Writes the body of a value. */
export class Writer {
  readonly littleEndian: boolean;
  readonly version: Version;
  view: DataView;
  offset = 0;
  private octets = new Uint8Array(256);

  constructor(littleEndian = true, version: Version = 1) {
    this.littleEndian = littleEndian;
    this.version = version;
    this.view = new DataView(this.octets.buffer);
  }

  /** Reserves space for a scalar of a size; returns its offset. */
  put(size: number): number {
    const align = this.version === 2 && size > 4 ? 4 : size;
    const start = this.offset + ((align - (this.offset % align)) % align);
    this.grow(start + size);
    this.offset = start + size;
    return start;
  }

  ulong(value: number): void {
    const at = this.put(4); // may replace the view
    this.view.setUint32(at, value, this.littleEndian);
  }

  count(count: number, bound: number): void {
    if (bound && count > bound) throw new CdrError(`a length of ${count} beyond ${bound}`);
    this.ulong(count);
  }

  bytes(octets: Uint8Array): void {
    this.grow(this.offset + octets.length);
    this.octets.set(octets, this.offset);
    this.offset += octets.length;
  }

  /** Writes a value after a DHEADER with its size. */
  delimited(write: () => void): void {
    const header = this.put(4);
    write();
    this.view.setUint32(header, this.offset - header - 4, this.littleEndian);
  }

  result(): Uint8Array {
    return this.octets.slice(0, this.offset);
  }

  private grow(size: number): void {
    if (size <= this.octets.length) return;
    const larger = new Uint8Array(Math.max(size, 2 * this.octets.length));
    larger.set(this.octets.subarray(0, this.offset));
    this.octets = larger;
    this.view = new DataView(larger.buffer);
  }
}

/** Encodes the body of a value. Throws CdrError. */
export function encode<T>(
  type: CdrType<T>,
  value: T,
  littleEndian = true,
  version: Version = 1,
): Uint8Array {
  const writer = new Writer(littleEndian, version);
  type.write(writer, value);
  return writer.result();
}

/** Decodes a body. Throws CdrError. */
export function decode<T>(
  type: CdrType<T>,
  octets: Uint8Array,
  littleEndian = true,
  version: Version = 1,
): T {
  const reader = new Reader(octets, littleEndian, version);
  reader.outermost = type;
  const value = type.read(reader);
  const rest = reader.end - reader.offset;
  if (rest) throw new CdrError(`${type.name}: ${rest} octets too many`);
  return value;
}

/** Encodes a payload: encapsulation header (DDSI-RTPS 2.5, 10.2) and body, version 1. */
export function serialize<T>(type: CdrType<T>, value: T): Uint8Array {
  const body = encode(type, value);
  const payload = new Uint8Array(4 + body.length);
  payload[1] = 1;
  payload.set(body, 4);
  return payload;
}

/** Decodes a payload with its encapsulation header. Throws CdrError. */
export function deserialize<T>(type: CdrType<T>, payload: Uint8Array): T {
  if (payload.length < 4) throw new CdrError(`${type.name}: the encapsulation header is truncated`);
  const kind = (payload[0]! << 8) | payload[1]!;
  const version = kind < 2 ? 1 : kind >= 6 && kind <= 9 ? 2 : 0;
  if (!version) throw new CdrError(`${type.name}: 0x${kind.toString(16)} is not PLAIN_CDR`);
  const end = Math.max(payload.length - (payload[3]! & 3), 4);
  return decode(type, payload.subarray(4, end), (kind & 1) === 1, version);
}

// Basic types.

/** A type whose members start with another value: the default of a typedef. */
export function initially<T>(type: CdrType<T>, initial: () => T): CdrType<T> {
  return { ...type, initial };
}

function scalar<T>(
  name: string,
  size: number,
  initial: T,
  get: (view: DataView, at: number, little: boolean) => T,
  set: (view: DataView, at: number, value: T, little: boolean) => void,
  check: (value: T) => boolean,
): CdrType<T> {
  return {
    name,
    least: size,
    primitive: true,
    initial: () => initial,
    read: (reader) => get(reader.view, reader.take(size), reader.littleEndian),
    write: (writer, value) => {
      if (!check(value)) throw new CdrError(`${String(value)} is not a value of ${name}`);
      const at = writer.put(size);
      set(writer.view, at, value, writer.littleEndian);
    },
  };
}

function within(least: number, greatest: number): (value: number) => boolean {
  return (value) => Number.isInteger(value) && least <= value && value <= greatest;
}

function within64(least: bigint, greatest: bigint): (value: bigint) => boolean {
  return (value) => typeof value === "bigint" && least <= value && value <= greatest;
}

const isNumber = (value: number): boolean => typeof value === "number";
const isFloat = (value: number): boolean =>
  isNumber(value) && (!Number.isFinite(value) || Number.isFinite(Math.fround(value)));

export const int8 = scalar<number>(
  "int8", 1, 0, (v, at) => v.getInt8(at), (v, at, x) => v.setInt8(at, x), within(-0x80, 0x7f));
export const octet = scalar<number>(
  "octet", 1, 0, (v, at) => v.getUint8(at), (v, at, x) => v.setUint8(at, x), within(0, 0xff));
export const short = scalar<number>(
  "short", 2, 0, (v, at, le) => v.getInt16(at, le), (v, at, x, le) => v.setInt16(at, x, le),
  within(-0x8000, 0x7fff));
export const ushort = scalar<number>(
  "unsigned short", 2, 0, (v, at, le) => v.getUint16(at, le),
  (v, at, x, le) => v.setUint16(at, x, le), within(0, 0xffff));
export const long = scalar<number>(
  "long", 4, 0, (v, at, le) => v.getInt32(at, le), (v, at, x, le) => v.setInt32(at, x, le),
  within(-0x80000000, 0x7fffffff));
export const ulong = scalar<number>(
  "unsigned long", 4, 0, (v, at, le) => v.getUint32(at, le),
  (v, at, x, le) => v.setUint32(at, x, le), within(0, 0xffffffff));
export const longlong = scalar<bigint>(
  "long long", 8, 0n, (v, at, le) => v.getBigInt64(at, le),
  (v, at, x, le) => v.setBigInt64(at, x, le), within64(-(1n << 63n), (1n << 63n) - 1n));
export const ulonglong = scalar<bigint>(
  "unsigned long long", 8, 0n, (v, at, le) => v.getBigUint64(at, le),
  (v, at, x, le) => v.setBigUint64(at, x, le), within64(0n, (1n << 64n) - 1n));
export const float = scalar<number>(
  "float", 4, 0, (v, at, le) => v.getFloat32(at, le), (v, at, x, le) => v.setFloat32(at, x, le),
  isFloat);
export const double = scalar<number>(
  "double", 8, 0, (v, at, le) => v.getFloat64(at, le), (v, at, x, le) => v.setFloat64(at, x, le),
  isNumber);
export const boolean = scalar<boolean>(
  "boolean", 1, false,
  (v, at) => {
    const number = v.getUint8(at);
    if (number > 1) throw new CdrError(`${number} is not a value of boolean`);
    return number === 1;
  },
  (v, at, x) => v.setUint8(at, x ? 1 : 0), (x) => typeof x === "boolean");
/** A character of Latin-1. */
export const char = scalar<string>(
  "char", 1, "\0", (v, at) => String.fromCharCode(v.getUint8(at)),
  (v, at, x) => v.setUint8(at, x.charCodeAt(0)), (x) => x.length === 1 && x.charCodeAt(0) < 0x100);
/** A unit of UTF-16. */
export const wchar = scalar<string>(
  "wchar", 2, "\0", (v, at, le) => String.fromCharCode(v.getUint16(at, le)),
  (v, at, x, le) => v.setUint16(at, x.charCodeAt(0), le), (x) => x.length === 1);

// Strings.

const LONE_SURROGATE = /\p{Surrogate}/u;
const encoder = new TextEncoder();
const decoder = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });

/** `string<bound>`, the bound in octets of UTF-8; 0: none. */
export function string(bound = 0): CdrType<string> {
  return {
    name: bound ? `string<${bound}>` : "string",
    least: 4,
    primitive: false,
    initial: () => "",
    read(reader) {
      const octets = reader.bytes(reader.count(1, bound && bound + 1));
      if (octets.at(-1) !== 0) throw new CdrError("a string does not end with a zero octet");
      try {
        return decoder.decode(octets.subarray(0, -1));
      } catch {
        throw new CdrError("a string is not UTF-8");
      }
    },
    write(writer, value) {
      if (value.includes("\0")) throw new CdrError("a string contains a zero");
      if (LONE_SURROGATE.test(value)) throw new CdrError("a string contains a lone surrogate");
      const octets = encoder.encode(value);
      if (bound && octets.length > bound) throw new CdrError(`a string longer than ${bound}`);
      writer.ulong(octets.length + 1);
      writer.bytes(octets);
      writer.bytes(new Uint8Array(1));
    },
  };
}

/** `wstring<bound>`, the bound in units of UTF-16; 0: none. */
export function wstring(bound = 0): CdrType<string> {
  return {
    name: bound ? `wstring<${bound}>` : "wstring",
    least: 4,
    primitive: false,
    initial: () => "",
    read(reader) {
      const size = reader.count(1, 2 * bound);
      if (size % 2) throw new CdrError("half a character of a wide string");
      const start = reader.offset;
      reader.bytes(size);
      let text = "";
      for (let at = start; at < start + size; at += 2) {
        text += String.fromCharCode(reader.view.getUint16(at, reader.littleEndian));
      }
      if (LONE_SURROGATE.test(text)) throw new CdrError("a wide string is not UTF-16");
      return text;
    },
    write(writer, value) {
      if (bound && value.length > bound) throw new CdrError(`a wide string longer than ${bound}`);
      if (LONE_SURROGATE.test(value)) throw new CdrError("a wide string contains a lone surrogate");
      writer.ulong(2 * value.length);
      for (let i = 0; i < value.length; i++) {
        const at = writer.put(2);
        writer.view.setUint16(at, value.charCodeAt(i), writer.littleEndian);
      }
    },
  };
}

function latin(octets: Uint8Array): string {
  let text = "";
  for (const octet of octets) text += String.fromCharCode(octet);
  return text;
}

function latinOctets(text: string): Uint8Array {
  return Uint8Array.from(text, (c) => {
    if (c.length !== 1 || c.charCodeAt(0) > 0xff) throw new CdrError(`${c} is not a char`);
    return c.charCodeAt(0);
  });
}

// Collections.

function collection<T>(element: CdrType<unknown>, plain: CdrType<T>): CdrType<T> {
  if (element.primitive) return plain;
  return {
    ...plain,
    read: (r) => (r.version === 2 ? r.delimited(() => plain.read(r)) : plain.read(r)),
    write: (w, v) => (w.version === 2 ? w.delimited(() => plain.write(w, v)) : plain.write(w, v)),
  };
}

/** `sequence<T, bound>`; 0: no bound. */
export function sequence<T>(element: CdrType<T>, bound = 0): CdrType<T[]> {
  return collection(element, {
    name: bound ? `sequence<${element.name},${bound}>` : `sequence<${element.name}>`,
    least: 4,
    primitive: false,
    initial: () => [],
    read(reader) {
      const count = reader.count(element.least, bound);
      const found: T[] = [];
      for (let i = 0; i < count; i++) found.push(element.read(reader));
      return found;
    },
    write(writer, values) {
      writer.count(values.length, bound);
      for (const value of values) element.write(writer, value);
    },
  });
}

/** `sequence<octet, bound>`. */
export function octets(bound = 0): CdrType<Uint8Array> {
  return {
    name: bound ? `sequence<octet,${bound}>` : "sequence<octet>",
    least: 4,
    primitive: false,
    initial: () => new Uint8Array(),
    read: (reader) => reader.bytes(reader.count(1, bound)),
    write(writer, value) {
      writer.count(value.length, bound);
      writer.bytes(value);
    },
  };
}

/** `sequence<char, bound>`. */
export function chars(bound = 0): CdrType<string> {
  const inner = octets(bound);
  return {
    ...inner,
    name: inner.name.replace("octet", "char"),
    initial: () => "",
    read: (reader) => latin(inner.read(reader)),
    write: (writer, value) => inner.write(writer, latinOctets(value)),
  };
}

/** `octet name[length]`. */
function octetArray(length: number, first = 0): CdrType<Uint8Array> {
  return {
    name: `octet[${length}]`,
    least: length,
    primitive: false,
    initial: () => new Uint8Array(length).fill(first),
    read: (reader) => reader.bytes(length),
    write(writer, value) {
      if (value.length !== length) throw new CdrError(`${value.length} octets for ${length}`);
      writer.bytes(value);
    },
  };
}

/** `char name[length]`. */
function charArray(length: number, first: string): CdrType<string> {
  const inner = octetArray(length);
  return {
    ...inner,
    name: `char[${length}]`,
    initial: () => first.repeat(length),
    read: (reader) => latin(inner.read(reader)),
    write: (writer, value) => inner.write(writer, latinOctets(value)),
  };
}

function rows<T>(element: CdrType<T>, length: number): CdrType<T[]> {
  return {
    name: `${element.name}[${length}]`,
    least: length * element.least,
    primitive: false,
    initial: () => Array.from({ length }, () => element.initial()),
    read(reader) {
      const found: T[] = [];
      for (let i = 0; i < length; i++) found.push(element.read(reader));
      return found;
    },
    write(writer, values) {
      if (values.length !== length) throw new CdrError(`${values.length} elements for ${length}`);
      for (const value of values) element.write(writer, value);
    },
  };
}

/** `T name[a][b]`, the dimensions outermost first; the value is nested arrays. */
export function array<T>(element: CdrType<unknown>, ...dimensions: number[]): CdrType<T> {
  const outer = [...dimensions];
  let made: CdrType<unknown> = element;
  if (element.primitive && element.name === octet.name) {
    made = octetArray(outer.pop()!, element.initial() as number) as CdrType<unknown>;
  } else if (element.primitive && element.name === char.name) {
    made = charArray(outer.pop()!, element.initial() as string) as CdrType<unknown>;
  }
  for (const length of outer.toReversed()) made = rows(made, length);
  return collection(element, made) as CdrType<T>;
}

/** `map<K, V, bound>`; 0: no bound. */
export function map<K, V>(key: CdrType<K>, value: CdrType<V>, bound = 0): CdrType<Map<K, V>> {
  const both = { ...value, primitive: key.primitive && value.primitive };
  return collection(both as CdrType<unknown>, {
    name: `map<${key.name},${value.name}>`,
    least: 4,
    primitive: false,
    initial: () => new Map<K, V>(),
    read(reader) {
      const count = reader.count(Math.max(key.least + value.least, 1), bound);
      const found = new Map<K, V>();
      for (let i = 0; i < count; i++) {
        const each = key.read(reader);
        if (found.has(each)) throw new CdrError("a key of a map occurs twice");
        found.set(each, value.read(reader));
      }
      return found;
    },
    write(writer, values) {
      writer.count(values.size, bound);
      for (const [k, v] of values) {
        key.write(writer, k);
        value.write(writer, v);
      }
    },
  });
}

// Declared types.

function unsigned(bits: number): CdrType<number> {
  return bits <= 8 ? octet : bits <= 16 ? ushort : ulong;
}

/** An enum: its enumerators with their numbers; values are the names, and start with the first. */
export function enumeration<E extends string>(
  name: string,
  members: Readonly<Record<E, number>>,
  bits = 32,
  initial?: E,
): CdrType<E> {
  const numbers = new Map(Object.entries(members) as [E, number][]);
  const names = new Map([...numbers].map(([each, number]) => [number, each]));
  const signed = [...numbers.values()].some((number) => number < 0);
  const whole = signed ? (bits <= 8 ? int8 : bits <= 16 ? short : long) : unsigned(bits);
  const [first] = numbers.keys();
  return {
    name,
    least: whole.least,
    primitive: false,
    initial: () => initial ?? (first as E),
    read(reader) {
      const number = whole.read(reader);
      const found = names.get(number);
      if (found === undefined) throw new CdrError(`${number} is not a value of ${name}`);
      return found;
    },
    write(writer, value) {
      const number = numbers.get(value);
      if (number === undefined) throw new CdrError(`${value} is not a value of ${name}`);
      whole.write(writer, number);
    },
  };
}

/** A bitmask of at most 32 bits, as the number whose bits are the flags. */
export function bitmask(name: string, bits: number): CdrType<number> {
  return { ...unsigned(bits), name, primitive: false };
}

/** A bitmask of up to 64 bits. */
export function bitmask64(name: string): CdrType<bigint> {
  return { ...ulonglong, name, primitive: false };
}

export interface Field {
  readonly name: string;
  readonly type: CdrType<unknown>;
  readonly optional: boolean;
  initial(): unknown;
}

/** A member of a struct with its default, if it is not that of its type; an optional one is null. */
export function field<T>(
  name: string,
  type: CdrType<T>,
  optional = false,
  initial: () => T = type.initial,
): Field {
  const start = optional ? () => null : initial;
  return { name, type: type as CdrType<unknown>, optional, initial: start };
}

/** A struct with its members in wire order, those of its base first. */
export function struct<T extends object>(
  name: string,
  fields: readonly Field[],
  appendable = false,
): CdrType<T> {
  checkNames(name, fields);
  const least = fields.reduce((sum, each) => sum + (each.optional ? 1 : each.type.least), 0);
  const read = (reader: Reader, evolves: boolean): T => {
    const value: Record<string, unknown> = {};
    for (const each of fields) {
      if (evolves && reader.offset >= reader.end) {
        value[each.name] = each.initial();
      } else if (each.optional) {
        requireVersion2(reader, name);
        value[each.name] = boolean.read(reader) ? each.type.read(reader) : null;
      } else {
        value[each.name] = each.type.read(reader);
      }
    }
    if (evolves) reader.offset = reader.end;
    return value as T;
  };
  const write = (writer: Writer, value: T): void => {
    for (const each of fields) {
      const part = (value as Record<string, unknown>)[each.name];
      if (each.optional) {
        requireVersion2(writer, name);
        boolean.write(writer, part !== null && part !== undefined);
        if (part === null || part === undefined) continue;
      } else if (part === undefined) {
        throw new CdrError(`${name} has no ${each.name}`);
      }
      each.type.write(writer, part);
    }
  };
  return composite(name, least, appendable, read, write, () => {
    const value: Record<string, unknown> = {};
    for (const each of fields) value[each.name] = each.initial();
    return value as T;
  });
}

type Label = number | bigint | boolean | string;

export interface Branch {
  readonly name: string;
  readonly type: CdrType<unknown>;
  readonly labels: readonly Label[];
  readonly isDefault: boolean;
  initial(): unknown;
}

/** A branch of a union, with its default, if it is not that of its type. */
export function branch<T>(
  name: string,
  type: CdrType<T>,
  labels: readonly Label[],
  isDefault = false,
  initial: () => T = type.initial,
): Branch {
  return { name, type: type as CdrType<unknown>, labels, isDefault, initial };
}

/** A value of a union: the selected branch (null: none) and the discriminator. */
interface Selected {
  readonly case: string | null;
  readonly value?: unknown;
  readonly discriminator?: Label;
}

/** A union; without `discriminator` a value has the first label of its branch. */
export function union<T extends object>(
  name: string,
  discriminator: CdrType<unknown>,
  branches: readonly Branch[],
  appendable = false,
): CdrType<T> {
  checkNames(name, branches);
  const byLabel = new Map<Label, Branch>();
  for (const each of branches) for (const label of each.labels) byLabel.set(label, each);
  const byName = new Map(branches.map((each) => [each.name, each]));
  const rest = branches.find((each) => each.isDefault);
  const selected = (label: Label): Branch | undefined => byLabel.get(label) ?? rest;
  const read = (reader: Reader, evolves: boolean): T => {
    const label = discriminator.read(reader) as Label;
    const found = selected(label);
    if (!found) return { case: null, discriminator: label } as T;
    const isMissing = evolves && reader.version === 2 && reader.offset >= reader.end;
    const part = isMissing ? found.initial() : found.type.read(reader);
    return { case: found.name, value: part, discriminator: label } as T;
  };
  const write = (writer: Writer, given: T): void => {
    const value = given as Selected;
    const found = value.case === null ? undefined : byName.get(value.case);
    if (value.case !== null && !found) throw new CdrError(`${name} has no branch ${value.case}`);
    const label = value.discriminator ?? found?.labels[0];
    if (label === undefined) throw new CdrError(`${name} needs a discriminator`);
    if (selected(label) !== found) {
      throw new CdrError(`${name}: ${String(label)} does not select ${String(value.case)}`);
    }
    discriminator.write(writer, label);
    found?.type.write(writer, value.value);
  };
  return composite(name, discriminator.least, appendable, read, write, () => {
    const label = discriminator.initial() as Label;
    const found = selected(label);
    const value: Selected = found
      ? { case: found.name, value: found.initial(), discriminator: label }
      : { case: null, discriminator: label };
    return value as T;
  });
}

/** A type that is defined later, for types that contain themselves. */
export function lazy<T>(name: string, type: () => CdrType<T>): CdrType<T> {
  return {
    name,
    least: 0,
    primitive: false,
    initial: () => type().initial(),
    read: (reader) => reader.nested(() => type().read(reader)),
    write: (writer, value) => type().write(writer, value),
  };
}

/**
 * A struct or union. `read` is told whether the value may be of another version of the type: it is
 * delimited, or the whole body.
 */
function composite<T>(
  name: string,
  least: number,
  appendable: boolean,
  read: (reader: Reader, evolves: boolean) => T,
  write: (writer: Writer, value: T) => void,
  initial: () => T,
): CdrType<T> {
  const type: CdrType<T> = {
    name,
    least: appendable ? Math.min(least, 4) : least,
    primitive: false,
    initial,
    read: (r) => {
      const isWhole = r.outermost === type;
      r.outermost = undefined;
      if (appendable && r.version === 2) return r.delimited(() => read(r, true));
      return read(r, appendable && isWhole);
    },
    write: (w, v) =>
      appendable && w.version === 2 ? w.delimited(() => write(w, v)) : write(w, v),
  };
  return type;
}

function checkNames(name: string, parts: readonly { readonly name: string }[]): void {
  if (parts.some((each) => each.name === "__proto__")) {
    throw new CdrError(`${name}: a member cannot be called __proto__`);
  }
}

function requireVersion2(of: { readonly version: Version }, name: string): void {
  if (of.version !== 2) throw new CdrError(`${name}: optional members need version 2 of XCDR`);
}

// Reads a line of hexadecimal digits (AddedTypes), then lines with numbers of types; prints the initial
// value of each, and the value of a form that was not changed (null if there is no form).
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const folder = pathToFileURL(`${process.argv[2]}/`);
const { decode } = await import(new URL("protocol/_cdr.ts", folder));
const { AddedTypes } = await import(new URL("protocol/Ui.ts", folder));
const { TypeTable } = await import(new URL("protocol/table.ts", folder));
const { draft, finish } = await import(new URL("draft.ts", folder));
const table = new TypeTable();
const plain = (_, v) =>
  typeof v === "bigint" ? `${v}n` : v instanceof Uint8Array ? [...v] : v instanceof Map ? [...v] : v;
let first = true;

for await (const line of createInterface({ input: process.stdin })) {
  if (first) {
    first = false;
    const added = decode(AddedTypes, Uint8Array.from(Buffer.from(line, "hex")));
    table.add(added.first, added.nodes);
    continue;
  }
  const number = Number(line);
  const form = finish(table, number, draft(table, number));
  console.log(JSON.stringify([table.codec(number).initial(), form], plain));
}

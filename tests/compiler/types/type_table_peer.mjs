// Reads a line `FIRST HEX` (AddedTypes), then lines `NUMBER VERSION HEX`; prints what is written
// again from the value that was read.
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const folder = pathToFileURL(`${process.argv[2]}/`);
const { decode, encode } = await import(new URL("_cdr.ts", folder));
const { AddedTypes } = await import(new URL("Ui.ts", folder));
const { TypeTable } = await import(new URL("table.ts", folder));
const table = new TypeTable();
let first = true;

for await (const line of createInterface({ input: process.stdin })) {
  const words = line.split(" ");
  const octets = Uint8Array.from(Buffer.from(words.at(-1) ?? "", "hex"));
  if (first) {
    first = false;
    const added = decode(AddedTypes, octets);
    table.add(added.first, added.nodes);
    continue;
  }
  const type = table.codec(Number(words[0]));
  const value = decode(type, octets, true, Number(words[1]));
  console.log(Buffer.from(encode(type, value, true, Number(words[1]))).toString("hex"));
}

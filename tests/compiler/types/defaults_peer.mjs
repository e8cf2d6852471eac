// Reads lines `TYPE VERSION HEX`; prints the initial value of the type, and the decoded value (null
// where version 1 of XCDR is not supported).
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const folder = pathToFileURL(`${process.argv[2]}/`);
const { decode } = await import(new URL("_cdr.ts", folder));
const types = await import(new URL("R.ts", folder));
const plain = (_, v) =>
  typeof v === "bigint" ? `${v}n` : v instanceof Uint8Array ? [...v] : v instanceof Map ? [...v] : v;

for await (const line of createInterface({ input: process.stdin })) {
  const [name, version, hex] = line.split(" ");
  const type = types[name];
  let decoded = null;
  try {
    decoded = decode(type, Uint8Array.from(Buffer.from(hex, "hex")), true, Number(version));
  } catch (error) {
    if (!error.message.endsWith("optional members need version 2 of XCDR")) throw error;
  }
  console.log(JSON.stringify([type.initial(), decoded], plain));
}

// Reads lines `TYPE VERSION LITTLE HEX`; prints the value in each format, or the error.
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const folder = pathToFileURL(`${process.argv[2]}/`);
const { decode, encode, serialize, deserialize } = await import(new URL("_cdr.ts", folder));
const scopes = {};
const plain = (value) => JSON.stringify(value, (_, v) =>
  typeof v === "bigint" ? `${v}` : v instanceof Uint8Array ? Buffer.from(v).toString("hex")
    : v instanceof Map ? [...v] : v);

for await (const line of createInterface({ input: process.stdin })) {
  const [scope, name, version, little, hex] = line.split(" ");
  scopes[scope] ??= await import(new URL(`${scope}.ts`, folder));
  const type = scopes[scope][name];
  const octets = Uint8Array.from(Buffer.from(hex ?? "", "hex"));
  try {
    const value = decode(type, octets, little === "1", Number(version));
    const all = [[1, true], [1, false], [2, true], [2, false]].map(([v, le]) => {
      try {
        return Buffer.from(encode(type, value, le, v)).toString("hex");
      } catch (error) {
        return error.name;
      }
    });
    const payload = version === "1" ? plain(deserialize(type, serialize(type, value))) : "";
    const same = !payload || payload === plain(value);
    console.log(JSON.stringify({ all, same }));
  } catch (error) {
    console.log(JSON.stringify({ error: error.name }));
  }
}

// Parses schemas by Foxglove's parser; prints the names that each one declares, with their members.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const { parseIDL } = createRequire(process.argv[2])("@foxglove/omgidl-parser");
const schemas = JSON.parse(readFileSync(0, "utf8"));
const names = schemas.map((text) =>
  Object.fromEntries(
    parseIDL(text).map((type) => [
      type.name,
      (type.definitions ?? []).map((member) => member.name),
    ]),
  ),
);
process.stdout.write(JSON.stringify(names));

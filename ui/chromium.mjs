// Unpacks the Chromium of an npm package, with the libraries that it needs, for the browser tests.
// The package's own way unpacks into a fixed folder, and its libraries and fonts only on AWS Lambda.

import {
  createReadStream,
  createWriteStream,
  mkdirSync,
  renameSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pipeline } from "node:stream/promises";
import { createBrotliDecompress } from "node:zlib";
import { extract } from "tar-fs";

const [folder] = process.argv.slice(2);
const entry = createRequire(import.meta.url).resolve("@sparticuz/chromium");
const archives = join(dirname(entry), "..", "bin");
const partial = `${folder}.partial`;

async function unpack(name, target) {
  await pipeline(createReadStream(join(archives, name)), createBrotliDecompress(), target);
}

rmSync(partial, { recursive: true, force: true });
mkdirSync(partial);
await unpack("chromium.br", createWriteStream(join(partial, "chromium"), { mode: 0o755 }));
for (const name of ["al2023", "swiftshader", "fonts"]) {
  await unpack(`${name}.tar.br`, extract(partial));
}
const fonts = `<dir>${folder}/fonts</dir><cachedir>${folder}/cache</cachedir>`;
writeFileSync(join(partial, "fonts.conf"), `<fontconfig>${fonts}</fontconfig>\n`);
rmSync(folder, { recursive: true, force: true });
renameSync(partial, folder);

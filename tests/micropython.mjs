// Runs a program by MicroPython. The first argument is where its package is, the second a folder of modules; the
// standard input is JSON with the `program`, and the text `given` of the file given.txt.
import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [, , base, folder] = process.argv;
const { program, given } = JSON.parse(readFileSync(0, "utf8"));
const main = createRequire(base).resolve("@micropython/micropython-webassembly-pyscript");
const { loadMicroPython } = await import(pathToFileURL(main));
const lines = [];
const board = await loadMicroPython({
  heapsize: 16 * 1024 * 1024,
  linebuffer: true,
  stdout: (line) => lines.push(line),
});

function copy(from, to) {
  board.FS.mkdir(to);
  for (const entry of readdirSync(from, { withFileTypes: true })) {
    const [source, target] = [join(from, entry.name), `${to}/${entry.name}`];
    if (entry.isDirectory()) copy(source, target);
    else board.FS.writeFile(target, readFileSync(source));
  }
}

copy(folder, "/board");
board.FS.writeFile("given.txt", given);
board.runPython("import sys\nsys.path.insert(0, '/board')");
try {
  board.runPython(program);
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
}
process.stdout.write(lines.map((line) => `${line}\n`).join(""));

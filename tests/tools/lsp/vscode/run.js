// Activates the extension of the path given, runs the commands named, and deactivates it; prints
// what came of it.

const { asked, registered } = require("vscode");
const extension = require(process.argv[2]);

async function main() {
  const context = { subscriptions: [] };
  await extension.activate(context);
  const client = context.subscriptions.find((each) => each.server !== undefined);
  const pages = asked.pages.length;
  for (const name of process.argv.slice(3)) {
    await registered[name]();
    const asynchronous = name === "rtgen.explain";
    while (asynchronous && asked.pages.length === pages && asked.errors.length === 0) {
      await new Promise(setImmediate);
    }
  }
  await extension.deactivate();
  const { server, options, answers, exit = null } = client;
  const commands = Object.keys(registered);
  console.log(
    JSON.stringify({ asked, commands, server, selector: options.documentSelector, answers, exit }),
  );
}

main();

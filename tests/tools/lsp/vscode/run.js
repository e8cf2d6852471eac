// Activates and deactivates the extension of the path given; prints what came of it.

const { asked } = require("vscode");
const extension = require(process.argv[2]);

async function main() {
  const context = { subscriptions: [] };
  await extension.activate(context);
  const [client] = context.subscriptions;
  await extension.deactivate();
  const { server, options, answers, exit = null } = client;
  console.log(JSON.stringify({ asked, server, selector: options.documentSelector, answers, exit }));
}

main();

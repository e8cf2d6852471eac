// Starts `rtgen lsp` and connects it with the editor.

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const WATCHED = "**/*.{idl,inc,cdl,cde,h,eds,dcf,toml,xml,yaml,yml}";

let client;

async function activate(context) {
  const [command, ...args] = workspace.getConfiguration("rtgen").get("command");
  client = new LanguageClient(
    "rtgen",
    "rtgen",
    { command, args },
    {
      documentSelector: [
        { scheme: "file", language: "idl" },
        { scheme: "file", language: "cdl" },
        { scheme: "file", language: "eds" },
        { scheme: "file", pattern: "**/*.{toml,xml,yaml,yml}" },
      ],
      synchronize: { fileEvents: workspace.createFileSystemWatcher(WATCHED) },
    },
  );
  context.subscriptions.push(client);
  await client.start();
}

function deactivate() {
  return client === undefined ? undefined : client.stop();
}

module.exports = { activate, deactivate };

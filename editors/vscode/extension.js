// Starts `rtgen lsp` and connects it with the editor.

const { window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const WATCHED = "**/*.{idl,inc,cdl,cde,h,eds,dcf,xdd,xdc,toml,xml,yaml,yml}";

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
        { scheme: "file", pattern: "**/*.{xdd,xdc,toml,xml,yaml,yml}" },
      ],
      synchronize: { fileEvents: workspace.createFileSystemWatcher(WATCHED) },
    },
  );
  context.subscriptions.push(client);
  try {
    await client.start();
  } catch (error) {
    window.showErrorMessage(
      `${command} does not start: ${error.message}. ` +
        "It comes with pip install ./runtime '.[lsp]' in a clone of rtgen; the setting rtgen.command says where it is.",
    );
  }
}

function deactivate() {
  return client?.isRunning() ? client.stop() : undefined;
}

module.exports = { activate, deactivate };

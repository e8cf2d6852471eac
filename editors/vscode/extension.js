// Starts `rtgen lsp`, connects it with the editor, and runs commands of rtgen as tasks.

const path = require("node:path");
const { execFile } = require("node:child_process");
const {
  ProcessExecution,
  Task,
  TaskScope,
  commands,
  languages,
  tasks,
  window,
  workspace,
} = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const WATCHED = "**/*.{idl,inc,cdl,cde,h,eds,dcf,xdd,xdc,toml,xml,yaml,yml}";
const SYSTEMS = "**/*.{xml,yaml}";
const EXCLUDED = "**/{node_modules,build,.venv}/**";
const CODE = /^[A-Z]{3}\d{4}$/;
const DEFAULT = { label: "The system of rtgen.toml", path: null };

let client;

/** The program and its first arguments: the command of the server without `lsp`. */
function program() {
  const command = workspace.getConfiguration("rtgen").get("command");
  return command.at(-1) === "lsp" ? command.slice(0, -1) : command;
}

/** The folder of the rtgen.toml nearest to the open file, else that of the workspace. */
async function project() {
  const settings = await workspace.findFiles("**/rtgen.toml", EXCLUDED);
  const folders = settings.map((uri) => path.dirname(uri.fsPath));
  const file = window.activeTextEditor?.document.uri.fsPath ?? "";
  const around = folders.filter((folder) => file.startsWith(folder + path.sep));
  const nearest = around.sort((a, b) => b.length - a.length)[0];
  return nearest ?? folders.sort()[0] ?? workspace.workspaceFolders?.[0]?.uri.fsPath;
}

/** Runs a command of rtgen as a task, which shows what it prints. */
async function execute(name, ...args) {
  const cwd = await project();
  if (cwd === undefined) {
    window.showErrorMessage("rtgen: open the folder of a project first.");
    return;
  }
  const [command, ...first] = program();
  const execution = new ProcessExecution(command, [...first, ...args], { cwd });
  await tasks.executeTask(new Task({ type: "rtgen" }, TaskScope.Workspace, name, "rtgen", execution));
}

/** The arguments that name a system: the one in the editor, or one that the user picks. */
async function system() {
  const file = window.activeTextEditor?.document;
  if (file?.getText().includes("RtsProfile")) return [file.uri.fsPath];
  const found = [];
  for (const uri of await workspace.findFiles(SYSTEMS, EXCLUDED, 500)) {
    const text = Buffer.from(await workspace.fs.readFile(uri)).toString("utf8");
    if (text.slice(0, 4096).includes("RtsProfile")) {
      found.push({ label: workspace.asRelativePath(uri), path: uri.fsPath });
    }
  }
  found.sort((a, b) => (a.label < b.label ? -1 : 1));
  const picked = await window.showQuickPick([DEFAULT, ...found], { placeHolder: "System" });
  return picked && (picked.path === null ? [] : [picked.path]);
}

async function onSystem(name, ...args) {
  const chosen = await system();
  if (chosen !== undefined) await execute(name, ...args, ...chosen);
}

/** Shows the explanation of the code at the cursor, or of one that the user writes. */
async function explain() {
  const editor = window.activeTextEditor;
  const here = editor
    ? languages
        .getDiagnostics(editor.document.uri)
        .filter((each) => each.range.contains(editor.selection.active))
        .map((each) => String(each.code?.value ?? each.code))
        .filter((code) => CODE.test(code))
    : [];
  const code =
    here.length === 1
      ? here[0]
      : here.length > 1
        ? await window.showQuickPick([...new Set(here)], { placeHolder: "Code" })
        : await window.showInputBox({
            prompt: "Code of a finding, such as IDL0101",
            validateInput: (text) => (CODE.test(text) ? null : "Three capitals and four digits"),
          });
  if (code === undefined) return;
  const [command, ...first] = program();
  const options = { maxBuffer: 1 << 24 };
  execFile(command, [...first, "explain", code], options, async (error, output, messages) => {
    if (error) {
      window.showErrorMessage(`rtgen explain ${code}: ${messages.trim() || error.message}`);
      return;
    }
    const page = await workspace.openTextDocument({ content: output, language: "markdown" });
    await window.showTextDocument(page, { preview: true });
  });
}

const COMMANDS = {
  "rtgen.generate": () => execute("generate", "generate"),
  "rtgen.check": () => execute("check", "check"),
  "rtgen.run": () => onSystem("run", "run"),
  "rtgen.page": () => onSystem("page", "ui", "--open"),
  "rtgen.explain": explain,
};

async function activate(context) {
  for (const [name, action] of Object.entries(COMMANDS)) {
    context.subscriptions.push(commands.registerCommand(name, action));
  }
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

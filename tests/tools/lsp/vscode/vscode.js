// Stands for the module that VS Code gives to extensions: what they ask of it, on record.

const fs = require("node:fs");

const asked = { watched: [], errors: [], tasks: [], pages: [] };
const state = JSON.parse(process.env.EDITOR ?? "{}");
const registered = {};

class Position {}

class ProcessExecution {
  constructor(process, args, options) {
    Object.assign(this, { process, args, options });
  }
}

class Task {
  constructor(definition, scope, name, source, execution) {
    Object.assign(this, { definition, scope, name, source, execution });
  }
}

const uriOf = (fsPath) => ({ fsPath });
const document = state.file && {
  uri: uriOf(state.file),
  getText: () => fs.readFileSync(state.file, "utf8"),
};

module.exports = {
  asked,
  registered,
  Position,
  ProcessExecution,
  Task,
  TaskScope: { Workspace: 2 },
  commands: {
    registerCommand: (name, action) => {
      registered[name] = action;
      return { dispose() {} };
    },
  },
  languages: {
    getDiagnostics: () =>
      (state.codes ?? []).map((code) => ({ code, range: { contains: () => true } })),
  },
  tasks: {
    executeTask: async (task) => {
      const { process, args, options } = task.execution;
      asked.tasks.push({ name: task.name, command: [process, ...args], cwd: options.cwd });
    },
  },
  workspace: {
    workspaceFolders: state.folder && [{ uri: uriOf(state.folder) }],
    getConfiguration: (section) => ({
      get: (name) => JSON.parse(process.env.SETTINGS)[`${section}.${name}`],
    }),
    createFileSystemWatcher: (pattern) => {
      asked.watched.push(pattern);
      return { dispose() {} };
    },
    findFiles: async (pattern) =>
      fs
        .globSync(pattern, { cwd: state.folder ?? "/nowhere" })
        .map((name) => uriOf(`${state.folder}/${name}`)),
    fs: { readFile: async (uri) => fs.readFileSync(uri.fsPath) },
    asRelativePath: (uri) => uri.fsPath.slice(state.folder.length + 1),
    openTextDocument: async (page) => page,
  },
  window: {
    activeTextEditor: document && { document, selection: { active: new Position() } },
    showErrorMessage: (message) => asked.errors.push(message),
    showQuickPick: async (items) => {
      asked.items = items.map((item) => item.label ?? item);
      return items.find((item) => (item.label ?? item) === state.picked);
    },
    showInputBox: async ({ validateInput }) => {
      asked.invalid = validateInput("no code");
      return state.written;
    },
    showTextDocument: async (page) => asked.pages.push(page),
  },
};

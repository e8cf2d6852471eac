// Stands for the module that VS Code gives to extensions: what they ask of it, on record.

const asked = { watched: [], errors: [] };

module.exports = {
  asked,
  workspace: {
    getConfiguration: (section) => ({
      get: (name) => JSON.parse(process.env.SETTINGS)[`${section}.${name}`],
    }),
    createFileSystemWatcher: (pattern) => {
      asked.watched.push(pattern);
      return { dispose() {} };
    },
  },
  window: { showErrorMessage: (message) => asked.errors.push(message) },
};

// Stands for the client library: starts the command, and initializes and ends the server in it.

const { spawn } = require("node:child_process");
const { once } = require("node:events");

class LanguageClient {
  constructor(id, name, server, options) {
    Object.assign(this, { id, name, server, options, answers: [], received: "" });
  }

  async start() {
    this.process = spawn(this.server.command, this.server.args);
    await once(this.process, "spawn");
    this.process.stdout.on("data", (data) => (this.received += data));
    await this.request(1, "initialize", { processId: null, rootUri: null, capabilities: {} });
    this.running = true;
  }

  isRunning() {
    return this.running === true;
  }

  async stop() {
    await this.request(2, "shutdown");
    this.send({ method: "exit" });
    [this.exit] = await once(this.process, "exit");
  }

  dispose() {}

  async request(id, method, params) {
    this.send({ id, method, params });
    const found = () => this.received.split(/Content-Length: \d+\r\n\r\n/).find((text) => {
      try {
        return JSON.parse(text).id === id;
      } catch {
        return false; // it has not come whole
      }
    });
    while (found() === undefined) await once(this.process.stdout, "data");
    this.answers.push(JSON.parse(found()).result);
  }

  send(message) {
    const body = JSON.stringify({ jsonrpc: "2.0", ...message });
    this.process.stdin.write(`Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`);
  }
}

module.exports = { LanguageClient };

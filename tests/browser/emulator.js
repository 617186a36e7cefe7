// The program under test: started on free ports, ended with the test.
import { spawn } from "node:child_process";
import { fileURLToPath } from "node:url";
import readline from "node:readline";

const PROGRAM = process.env.PROFIDRIVE ?? fileURLToPath(new URL("../../target/debug/profidrive", import.meta.url));
const READY_LIMIT_MS = 60_000;

export class Emulator {
  /** Starts `profidrive emulate` with a TCP link and the panel, and waits for its ready line. */
  static async start(...options) {
    return Emulator.#start("0", "0", options);
  }

  /** Starts `profidrive try` without a browser of its own. */
  static async try(...options) {
    return Emulator.#run(["try", "--no-browser", ...options], options);
  }

  static async #start(linkPort, panelPort, options) {
    const link = `${options.includes("--node") ? "slcan-tcp" : "tcp"}:127.0.0.1:${linkPort}`;
    return Emulator.#run(["emulate", "--link", link, "--panel", `127.0.0.1:${panelPort}`, ...options], options);
  }

  static async #run(args, options) {
    const child = spawn(PROGRAM, args, { stdio: ["ignore", "pipe", "pipe"] });
    const log = [];
    child.stderr.on("data", (text) => log.push(text.toString()));
    const ended = new Promise((resolve) => child.once("exit", resolve));
    const ready = await new Promise((resolve, reject) => {
      const fail = (why) => reject(new Error(`${PROGRAM} ${why}\n${log.join("")}`));
      const timer = setTimeout(() => fail("was not ready in time"), READY_LIMIT_MS);
      child.once("error", (error) => fail(error.message));
      child.once("exit", (code) => fail(`ended with ${code} before it was ready`));
      readline.createInterface({ input: child.stdout }).once("line", (line) => {
        clearTimeout(timer);
        resolve(line);
      });
    });
    return new Emulator({ child, log, ended, ready, options });
  }

  constructor(fields) {
    Object.assign(this, fields);
    this.linkPort = Number(/link=(?:slcan-)?tcp:\S*:(\d+)/.exec(this.ready)?.[1]);
    this.panel = /panel=(http:\S+)/.exec(this.ready)?.[1];
    if (!this.linkPort || !this.panel) throw new Error(`not understood: ${this.ready}`);
  }

  /** A new emulator where this one was, for pages that shall find it again; with other devices if they are given. `meanwhile` there is none. */
  async restart(meanwhile, options = this.options) {
    await this.stop();
    await meanwhile();
    return Emulator.#start(String(this.linkPort), new URL(this.panel).port, options);
  }

  /** Stops the program where it is, as a computer does that hangs: its port stays open, and nobody answers. */
  freeze() {
    this.child.kill("SIGSTOP");
  }

  /** Lets it go on. */
  thaw() {
    this.child.kill("SIGCONT");
  }

  /** Ends the program and says what it logged if that was not as it should be. */
  async stop() {
    this.thaw();
    this.child.kill("SIGTERM");
    const code = await this.ended;
    if (code !== 0) throw new Error(`the emulator ended with ${code}\n${this.log.join("")}`);
  }
}

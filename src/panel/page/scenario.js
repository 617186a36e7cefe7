// A scenario: what is clicked, with its times, played again, and saved for programs.
import { button, html, many, mark, say } from "./dom.js";
import { onRequest, request } from "./api.js";
import { saveText } from "./settings.js";

const FORM = 1;
/** Keys that are held say so again and again: that is one press. */
const RENEWAL = "lease_milliseconds";

export class Scenario {
  #steps = [];
  #begun = null;
  /** What plays now: a number of its own, so that another play ends it. */
  #playing = null;
  #record = button("Record", () => this.#toggle(), { "aria-pressed": false });
  #play = button("Play", () => this.#again());
  #file = html("input", { type: "file", accept: ".json", hidden: true, tabindex: -1, "aria-label": "A file of a scenario", onchange: () => this.#load() });
  #said = html("p", { role: "status", class: "muted" });
  #list = html("ol", { class: "log mono", tabindex: 0, "aria-label": "Steps of the scenario", hidden: true });
  #saves;

  constructor(root) {
    this.#saves = [
      button("Save", () => this.#save("scenario.json", JSON.stringify({ profidrive: FORM, steps: this.#steps }, null, 1), "application/json")),
      button("Save for pytest", () => this.#save("test_scenario.py", pytest(this.#steps), "text/x-python")),
      button("Save line file", () => this.#save("scenario.toml", lineFile(this.#steps), "application/toml")),
    ];
    root.replaceChildren(
      html("div", { class: "toolbar" }, this.#record, this.#play, ...this.#saves, button("Load", () => this.#file.click()), this.#file),
      html("p", { class: "hint" }, "Faults, inputs, keys, plugs and what the master in this program does are recorded with their times."),
      this.#said,
      this.#list,
    );
    onRequest((step) => this.#take(step));
    this.#show();
  }

  /** Something was asked of the server, and done. */
  #take({ method, path, body, answer }) {
    if (this.#begun === null || this.#playing !== null) return;
    const last = this.#steps.at(-1);
    const renews = body?.[RENEWAL] !== undefined && last?.path === path && JSON.stringify(last.body) === JSON.stringify(body);
    if (renews) return;
    const number = path.endsWith("/faults") ? answer?.number : undefined;
    this.#steps.push({ at: Number(((performance.now() - this.#begun) / 1000).toFixed(3)), method, path, body, number });
    this.#show();
  }

  #toggle() {
    if (this.#begun === null) {
      this.#steps = [];
      this.#begun = performance.now();
    } else {
      this.#begun = null;
    }
    mark(this.#record, "aria-pressed", this.#begun !== null);
    this.#show();
  }

  async #again() {
    if (this.#playing !== null) {
      this.#playing = null;
      this.#show();
      return;
    }
    if (this.#begun !== null) this.#toggle();
    const mine = (this.#playing = {});
    this.#show();
    const begun = performance.now();
    // Faults have other numbers now.
    const numbers = new Map();
    for (const [place, { at, method, path, body, number }] of this.#steps.entries()) {
      await new Promise((resolve) => setTimeout(resolve, Math.max(0, at * 1000 - (performance.now() - begun))));
      if (this.#playing !== mine) return;
      this.#point(place);
      try {
        const now = path.replace(/\/faults\/(\d+)$/, (all, was) => `/faults/${numbers.get(Number(was)) ?? was}`);
        // A key has no tab that renews its lease here: its release comes as a step of its own.
        const sent = body?.[RENEWAL] === undefined ? body : { ...body, [RENEWAL]: undefined };
        const answer = await request(method, now, sent);
        if (number !== undefined) numbers.set(number, answer?.number);
      } catch (error) {
        this.#playing = null;
        this.#show();
        mark(this.#said, "class", "refused");
        say(this.#said, `Step ${place + 1} was refused: ${error.message}`);
        return;
      }
    }
    this.#playing = null;
    this.#show();
  }

  #save(name, text, type) {
    saveText(name, text, type);
  }

  async #load() {
    const [file] = this.#file.files;
    this.#file.value = "";
    if (!file) return;
    try {
      const { profidrive: form, steps } = JSON.parse(await file.text());
      const isStep = ({ at, method, path }) => typeof at === "number" && ["POST", "PUT", "PATCH", "DELETE"].includes(method) && /^\/(lines|stations)(\/|$)/.test(path);
      if (form !== FORM || !Array.isArray(steps) || !steps.every(isStep)) throw new RangeError("it has no steps that this page has saved");
      this.#steps = steps;
      this.#show();
    } catch (error) {
      mark(this.#said, "class", "refused");
      say(this.#said, `The file cannot be used: ${error.message}`);
    }
  }

  #show() {
    mark(this.#said, "class", "muted");
    const doing = this.#playing !== null ? "plays" : this.#begun !== null ? "records" : "";
    say(this.#said, [many(this.#steps.length, "step"), doing].filter(Boolean).join(", "));
    say(this.#record, this.#begun === null ? "Record" : "Stop");
    say(this.#play, this.#playing === null ? "Play" : "Stop playing");
    for (const made of [this.#play, ...this.#saves]) made.disabled = this.#steps.length === 0;
    this.#list.hidden = this.#steps.length === 0;
    if (this.#list.childElementCount !== this.#steps.length || this.#steps.length === 0) {
      this.#list.replaceChildren(...this.#steps.map(({ at, method, path, body }) => html("li", {}, html("span", { class: "time" }, `${at.toFixed(3)} s`), html("span", { class: "kind" }, method), html("span", { class: "text" }, `${path} ${body === undefined ? "" : JSON.stringify(body)}`))));
    }
  }

  #point(place) {
    for (const [at, line] of [...this.#list.children].entries()) {
      if (at === place) mark(line, "aria-current", true);
      else line.removeAttribute("aria-current");
    }
  }
}

/** A value as Python writes it. */
function python(value) {
  if (value === null || value === undefined) return "None";
  if (typeof value === "boolean") return value ? "True" : "False";
  if (Array.isArray(value)) return `[${value.map(python).join(", ")}]`;
  if (typeof value === "object") return `{${Object.entries(value).filter(([, of]) => of !== undefined).map(([key, of]) => `${JSON.stringify(key)}: ${python(of)}`).join(", ")}}`;
  return JSON.stringify(value);
}

/** A test that plays the steps against the emulator whose panel it is told. */
export function pytest(steps) {
  const lines = steps.map(({ at, method, path, body, number }) => `    (${at}, ${python(method)}, ${python(path)}, ${python(body && { ...body, [RENEWAL]: undefined })}, ${python(number)}),`);
  return `"""A scenario that was recorded in the panel of profidrive.

Start the emulator with --panel, your master, and then:  PROFIDRIVE_PANEL=http://127.0.0.1:8080 pytest test_scenario.py
"""

import json
import os
import re
import time
import urllib.request

PANEL = os.environ.get("PROFIDRIVE_PANEL", ${python(location.origin)})

# Seconds, method, path, body, number of a fault on the line.
STEPS = [
${lines.join("\n")}
]


def ask(method, path, body=None):
    data = None if body is None else json.dumps(body).encode()
    headers = {} if body is None else {"Content-Type": "application/json"}
    request = urllib.request.Request(PANEL + "/api/v1" + path, data, headers, method=method)
    with urllib.request.urlopen(request, timeout=20) as answer:
        octets = answer.read()
    return json.loads(octets) if octets else None


def play():
    begun, numbers = time.monotonic(), {}
    for at, method, path, body, number in STEPS:
        time.sleep(max(0.0, at - (time.monotonic() - begun)))
        path = re.sub(r"/faults/(\\d+)$", lambda was: f"/faults/{numbers.get(int(was[1]), was[1])}", path)
        answer = ask(method, path, body)
        if number is not None:
            numbers[number] = answer["number"]


def test_scenario():
    play()
    # Here: what your master must have done, and what the stations must show.
    for station in ask("GET", "/stations")["stations"]:
        assert station["fault"] is None, station
`;
}

/** The faults on the line with their times, as a line file has them; what such a file cannot say, as comments. */
export function lineFile(steps) {
  const faults = [];
  const others = [];
  for (const { at, method, path, body, number } of steps) {
    const [, line] = /^\/lines\/([^/]+)\/faults/.exec(path) ?? [];
    if (line !== undefined && method === "POST") faults.push({ number, from: at, text: body.fault });
    else if (line !== undefined && method === "DELETE") {
      const of = /\/faults\/(\d+)$/.exec(path)?.[1];
      for (const fault of faults) if (fault.until === undefined && (of === undefined || fault.number === Number(of))) fault.until = at;
    } else others.push(`# ${at} s: ${method} ${path} ${body === undefined ? "" : JSON.stringify(body)}`);
  }
  const rows = faults.map(({ from, until, text }) => `[[line.fault]]\nfault = ${JSON.stringify(text)}\nfrom = "${Math.round(from * 1000)}ms"\n${until === undefined ? "" : `until = "${Math.round(until * 1000)}ms"\n`}`);
  const note = others.length === 0 ? "" : `# A line file has no time line for these; test_scenario.py plays them:\n${others.join("\n")}\n`;
  return `# A scenario that was recorded in the panel of profidrive: put it into the [[line]] of your line file.\n\n${rows.join("\n")}\n${note}`;
}

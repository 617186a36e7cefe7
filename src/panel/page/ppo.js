// A drive of PROFIDRIVE version 2: its words, values, faults, parameter channel and parameters.
import { html, say, mark, Rows } from "./dom.js";
import { request } from "./api.js";
import { Why } from "./why.js";
import { WordTable } from "./words.js";

/** A kind of colour for a drive. */
function kindOf({ fault, warning, operation_enabled: enabled, owner_address: owner }) {
  if (fault) return "fault";
  if (warning) return "warning";
  return enabled ? "ready" : owner === null ? "idle" : "ready";
}

export class PpoView {
  #by = (id) => document.getElementById(id);
  #address = null;
  #stw;
  #zsw;
  #why;
  #values;
  #pkw;
  #parameters;

  constructor() {
    this.#stw = new WordTable(this.#by("ppo-stw"));
    this.#zsw = new WordTable(this.#by("ppo-zsw"));
    this.#why = new Why(this.#by("ppo-reasons"));
    this.#values = new Rows(this.#by("ppo-values"), ({ name }) => {
      const value = html("dd");
      return { element: html("div", {}, html("dt", {}, name), value), show: ({ text }) => say(value, text) };
    });
    this.#pkw = new Rows(this.#by("ppo-pkw"), () => line("p"));
    const body = html("tbody");
    const head = html("tr", {}, ...["PNU", "Name", "Value", "Unit"].map((name) => html("th", { scope: "col", class: name === "Value" ? "right" : undefined }, name)));
    this.#by("ppo-parameters").replaceChildren(html("table", { class: "table" }, html("thead", {}, head), body));
    this.#parameters = new Rows(body, (row) => this.#parameterRow(row));
    this.#drawActs(this.#by("ppo-acts"));
  }

  /** Another drive is to be shown; what the page says of the one before is taken away. */
  choose(address) {
    this.#address = address;
    say(this.#by("ppo-title"), `Drive ${address}`);
    for (const id of ["ppo-state", "ppo-about", "ppo-refusal", "ppo-problem"]) say(this.#by(id), "");
    this.#why.show({ title: "", kind: "waiting", reasons: [], refused: "" });
    for (const rows of [this.#values, this.#pkw, this.#parameters]) rows.show([], () => "");
  }

  /** `state` is a PpoDriveState. */
  show(state) {
    say(this.#by("ppo-title"), `Drive ${state.address}: ${state.ppo ?? "PROFIDRIVE version 2"}`);
    say(this.#by("ppo-state"), state.state);
    mark(this.#by("ppo-state"), "data-kind", kindOf(state));
    const owner = state.owner_address === null ? "no master exchanges data" : `master ${state.owner_address}`;
    const watchdog = state.watchdog_milliseconds === null ? "no watchdog" : `watchdog ${state.watchdog_milliseconds} ms`;
    say(this.#by("ppo-about"), `ident 0x${hex(state.ident_number)}, ${owner}, ${watchdog}`);
    say(this.#by("ppo-refusal"), state.dp_state === "DATA-EXCH" ? "" : (state.last_refusal ?? ""));
    const [title, kind] = state.turning ? ["It turns", "ready"] : state.why.length === 0 ? ["Ready to turn", "ready"] : ["Why it does not turn", "waiting"];
    this.#why.show({ title, kind: state.fault ? "fault" : kind, reasons: state.why, refused: "" });
    this.#stw.show({ raw: state.stw, mode: "", bits: state.stw_bits.map(word) });
    this.#zsw.show({ raw: state.zsw, mode: "", bits: state.zsw_bits.map((bit) => ({ ...word(bit), alarm: bit.bit === 3 && bit.set })) });
    const numbers = (list) => (list.length === 0 ? "none" : list.join(", "));
    this.#values.show(
      [
        ["Setpoint", `${state.setpoint_percent.toFixed(1)} %`],
        ["Actual value", `${state.actual_percent.toFixed(1)} %`],
        ["Speed", `${state.speed_rpm.toFixed(0)} rpm of ${state.reference_speed_rpm.toFixed(0)}`],
        ["Torque", `${state.torque_percent.toFixed(0)} %, load ${state.load_percent.toFixed(0)} %`],
        ["Current", `${state.current_amperes.toFixed(1)} A`],
        ["Faults (947)", numbers(state.faults)],
        ["Acknowledged", numbers(state.faults_acknowledged.slice(0, 8))],
        ["Warnings (953)", numbers(state.warnings)],
      ].map(([name, text]) => ({ name, text })),
      ({ name }) => name,
    );
    const said = (who, words) => ({ who, text: words === null ? `${who}: nothing` : `${who}: ${words.words_hex}: ${words.text}` });
    this.#pkw.show([said("Master", state.pkw_job), said("Drive", state.pkw_reply)], ({ who }) => who);
  }

  /** Asks for the parameters and shows them. */
  async refresh() {
    const address = this.#address;
    const { parameters } = await request("GET", `/ppo-drives/${address}/parameters`);
    if (address === this.#address) this.#parameters.show(parameters, ({ pnu }) => pnu);
  }

  /** There is no such drive. */
  gone(message) {
    say(this.#by("ppo-problem"), message);
  }

  #parameterRow({ pnu, name }) {
    const [value, unit] = [html("td", { class: "right" }), html("td")];
    const element = html("tr", {}, html("td", {}, String(pnu)), html("td", {}, name), value, unit);
    const shown = (number, scale) => (number === null ? "?" : scale === 1 ? String(number) : `${number} (${Number((number * scale).toPrecision(6))})`);
    return {
      element,
      show: ({ values, scale, unit: text }) => {
        const few = values.slice(0, 4).map((number) => shown(number, scale)).join(", ");
        say(value, values.length > 4 ? `${few}, ...` : few);
        say(unit, text);
      },
    };
  }

  #drawActs(root) {
    const field = (label, attributes, action, send) => {
      const input = html("input", { type: "number", min: 0, required: true, ...attributes });
      const form = html("form", { class: "form" }, html("label", { class: "field" }, `${label} `, input), html("button", { type: "submit" }, action));
      form.addEventListener("submit", (event) => {
        event.preventDefault();
        send(input.valueAsNumber);
      });
      return form;
    };
    root.replaceChildren(
      field("Fault number", { min: 1, max: 65535, value: 77 }, "Raise", (number) => this.#act("POST", "fault", { number })),
      field("Warning number, 0 ends it", { max: 65535, value: 5 }, "Set", (number) => this.#act("PUT", "warning", { number })),
      field("Load in % of the rated torque", { max: 1000, value: 10 }, "Set load", (percent) => this.#act("PUT", "load", { percent })),
    );
  }

  async #act(method, path, body) {
    try {
      await request(method, `/ppo-drives/${this.#address}/${path}`, body);
      say(this.#by("ppo-problem"), "");
    } catch (error) {
      say(this.#by("ppo-problem"), error.message);
    }
  }
}

/** Every drive of PROFIDRIVE version 2 as a tile. */
export class PpoTiles {
  #rows = new Rows(document.getElementById("ppo-tiles"), () => new Tile());

  /** Asks which there are and shows them. */
  async refresh() {
    try {
      const { ppo_drives: drives } = await request("GET", "/ppo-drives");
      document.getElementById("ppo-drives").hidden = drives.length === 0;
      this.#rows.show([...drives].sort((a, b) => a.address - b.address), ({ address }) => address);
      return drives;
    } catch {
      return null;
    }
  }
}

class Tile {
  #address = html("span", { class: "address" });
  #name = html("span", { class: "name" });
  #word = html("span", { class: "word" });

  constructor() {
    this.link = html("a", { class: "tile" }, this.#address, html("span", { class: "shape", "aria-hidden": "true" }), this.#name, this.#word);
    this.element = html("li", {}, this.link);
  }

  show(drive) {
    mark(this.link, "href", `#ppo/${drive.address}`);
    mark(this.link, "data-kind", kindOf(drive));
    say(this.#address, String(drive.address));
    say(this.#name, drive.ppo ?? "PPO drive");
    say(this.#word, `${drive.state}, ${drive.actual_percent.toFixed(0)} %`);
  }
}

function line(tag) {
  const element = html(tag);
  return { element, show: ({ text }) => say(element, text) };
}

function word({ bit, set, name }) {
  return { bit, name, meaning: "", set, alarm: false, used: true };
}

function hex(number) {
  return number.toString(16).toUpperCase().padStart(4, "0");
}

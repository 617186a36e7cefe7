// A station from a GSD: its modules as cards, its diagnosis.
import { html, many, say, mark, Rows } from "./dom.js";
import { request } from "./api.js";
import { StationDiagnosis } from "./station_diagnosis.js";
import { ModuleCard } from "./station_module.js";

/** What the outputs are, as a word and a kind of colour. */
const OUTPUTS = {
  unowned: ["no master exchanges data", "idle"],
  live: ["Data_Exchange", "ready"],
  cleared: ["outputs cleared by the master", "warning"],
  fail_safe: ["Fail_Safe: no outputs", "warning"],
  watchdog_expired: ["watchdog expired", "fault"],
};

export class StationView {
  #by = (id) => document.getElementById(id);
  #address = null;
  #modules;
  #diagnosis;

  constructor() {
    this.#modules = new Rows(this.#by("modules"), () => new ModuleCard((method, path, body) => this.#act(method, path, body)));
    this.#diagnosis = new StationDiagnosis(this.#by("diagnosis"), (method, body) => this.#act(method, "diagnosis", body));
    this.#by("station-release").addEventListener("click", () => this.#act("DELETE", "inputs"));
  }

  /** Another station is to be shown; what the page says of the one before is taken away. */
  async choose(address) {
    this.#address = address;
    say(this.#by("station-title"), `Station ${address}`);
    for (const id of ["station-state", "station-about", "station-refusal", "station-problem"]) say(this.#by(id), "");
    this.#modules.show([], () => "");
    this.#diagnosis.clear();
    try {
      const texts = await request("GET", `/stations/${address}/texts`);
      if (address === this.#address) this.#diagnosis.offer(texts);
    } catch (error) {
      if (address === this.#address) this.gone(error.message);
    }
  }

  /** `state` is a GsdStationState. */
  show(state) {
    say(this.#by("station-title"), `Station ${state.address}: ${state.vendor} ${state.model}`);
    const [word, kind] = OUTPUTS[state.outputs_are] ?? [state.outputs_are, "idle"];
    say(this.#by("station-state"), word);
    mark(this.#by("station-state"), "data-kind", kind);
    const owner = state.owner_address === null ? "no master" : `master ${state.owner_address}`;
    const watchdog = state.watchdog_milliseconds === null ? "no watchdog" : `watchdog ${state.watchdog_milliseconds} ms`;
    say(this.#by("station-about"), `ident ${hex16(state.ident_number)}, ${owner}, ${watchdog}, ${many(state.modules.length, "module")}`);
    const refusal = state.dp_state === "DATA-EXCH" ? null : state.last_refusal;
    say(this.#by("station-refusal"), refusal ?? "");
    this.#modules.show(state.modules, ({ slot, name, inputs, outputs }) => `${slot} ${name} ${inputs.length} ${outputs.length}`);
    this.#diagnosis.show(state);
  }

  /** There is no such station. */
  gone(message) {
    say(this.#by("station-problem"), message);
  }

  async #act(method, path, body) {
    try {
      await request(method, `/stations/${this.#address}/${path}`, body);
      say(this.#by("station-problem"), "");
    } catch (error) {
      say(this.#by("station-problem"), error.message);
    }
  }
}

/** Every station from a GSD as a tile. */
export class StationTiles {
  #rows = new Rows(document.getElementById("gsd-tiles"), () => new Tile());

  /** Asks which there are and shows them. */
  async refresh() {
    try {
      const { stations } = await request("GET", "/stations");
      document.getElementById("gsd-stations").hidden = stations.length === 0;
      this.#rows.show([...stations].sort((a, b) => a.address - b.address), ({ address }) => address);
      return stations;
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

  show({ address, vendor, model, outputs_are, faulty }) {
    const [word, kind] = OUTPUTS[outputs_are] ?? [outputs_are, "idle"];
    mark(this.link, "href", `#station/${address}`);
    mark(this.link, "data-kind", faulty ? "fault" : kind);
    say(this.#address, String(address));
    say(this.#name, `${vendor} ${model}`);
    say(this.#word, faulty ? `diagnosis, ${word}` : word);
  }
}

function hex16(number) {
  return `0x${number.toString(16).toUpperCase().padStart(4, "0")}`;
}

// One station in all details: the lists of its description, each in a part of the page of its own.
//
// A view is made for one station and thrown away with it: nothing in it can act on another one.
import { button, html, mark, say } from "./dom.js";
import { saveReport } from "./report.js";
import { fileOf, nameOf, request, stationOf } from "./api.js";
import { Curves } from "./curves.js";
import { Device } from "./device.js";
import { Diagnosis } from "./diagnosis.js";
import { Entries, OBJECTS, PARAMETERS } from "./entries.js";
import { Faults } from "./faults.js";
import { Inputs } from "./inputs.js";
import { Master } from "./master.js";
import { Process } from "./process.js";
import { Records } from "./records.js";
import { faultText, stateOf } from "./states.js";
import { Groups, Values } from "./values.js";
import { Why } from "./why.js";
import { Words } from "./words.js";

export class StationView {
  #parts;
  #head;
  #state = html("p", { id: "station-state", class: "state" });
  #about = html("span", { id: "station-about", class: "muted" });
  #message = html("p", { class: "refused", role: "alert", id: "station-problem" });
  #root;
  #path;
  #recalled = false;
  #noted = 0;
  #now = 0;

  /**
   * Of the station `{ line, address }` in `root`; `choose` is put beside its name, `lines` is how many there are. A time that
   * is chosen in the curves is for `onPoint(time)`, what their trigger waited for is for `onTrigger({ time_s, text })`; `told()` are the events and telegrams of a report, `note(line)` takes one more.
   */
  constructor(root, station, { choose, lines, onPoint, onTrigger, told, note }) {
    this.station = station;
    this.#root = root;
    this.#path = stationOf(station);
    const ask = (method, path, body) => request(method, this.#path + path, body);
    const act = (...of) => this.#act(ask(...of));
    const save = html("a", { class: "button", href: fileOf(`${this.#path}/samples.csv`), download: "" }, "Save as CSV");
    this.why = new Why();
    this.master = new Master(ask, {
      advise: (command) => this.why.advise(command),
      below: () => this.words.element.previousElementSibling !== this.master.element && this.words.element.before(this.master.element),
    });
    this.values = new Values();
    this.device = new Device(ask, act);
    const report = button("Save as report", () => saveReport({ station, state: this.#state.textContent, about: this.#about.textContent, picture: this.curves.picture, csv: save.href, ...told() }));
    const noted = button("Mark", () => this.#note(note));
    this.curves = new Curves(html("span", { class: "group" }, noted, save, report), onPoint, onTrigger);
    this.faults = new Faults(act);
    this.words = new Words();
    this.inputs = new Inputs(ask);
    this.process = new Process(act);
    this.parameters = new Entries(PARAMETERS, ask);
    this.objects = new Entries(OBJECTS, ask);
    this.diagnosis = new Diagnosis(ask, act);
    this.records = new Records(ask);
    this.groups = new Groups();
    const { why, master, values, device, curves, faults, words, inputs, process, parameters, objects, diagnosis, records, groups } = this;
    this.#parts = [why, master, values, device, curves, faults, words, inputs, process, parameters, objects, diagnosis, records, groups];
    this.#head = html("h2", { id: "station-title" }, `Station ${nameOf(station, lines)}`);
    root.replaceChildren(
      html("div", { class: "toolbar headline" }, this.#head, this.#state, this.#about, html("span", { class: "spacer" }), choose),
      why.element,
      this.#message,
      master.element,
      values.element,
      html("div", { class: "columns" }, device.element, html("div", { class: "column wide" }, curves.element, faults.element, words.element), inputs.element),
      process.element,
      html("div", { class: "pair" }, parameters.element, objects.element, diagnosis.element, records.element, groups.element),
    );
    mark(root, "data-known", "asked");
  }

  /** A complete state; `gap`: states before it were lost. A part that does not understand it says so, and only that part. */
  show(state, gap) {
    mark(this.#root, "data-known", "there");
    this.#now = state.time_seconds;
    this.#showHead(state);
    this.#recall(state);
    for (const part of this.#parts) {
      try {
        part.show(state, gap);
      } catch (error) {
        console.warn(error);
        part.element.dataset.trouble = `Not understood: ${error.message}`;
        continue;
      }
      delete part.element.dataset.trouble;
    }
  }

  /** There is no such station, and nothing to show of one: the sentence takes the place of everything. */
  gone(sentence) {
    this.leave();
    this.curves.clear();
    mark(this.#root, "data-known", "gone");
    mark(this.#state, "data-kind", "off");
    say(this.#about, "");
    say(this.#message, "");
    this.#state.replaceChildren(html("span", { class: "shape", "aria-hidden": "true" }), "not present");
    this.why.refuse(sentence);
  }

  /** The view is left, or nobody looks at it any more: what a finger held is released. */
  leave() {
    this.device.release();
  }

  /** What the server has kept of its curves, once. Without them there is less to see, and nothing that is wrong. */
  #recall({ has }) {
    if (this.#recalled || !has?.samples) return;
    this.#recalled = true;
    request("GET", `${this.#path}/samples`).then(({ samples }) => this.curves.addBefore(samples), () => {});
  }

  /** A mark at this moment, among the events and in the curves. */
  #note(note) {
    this.#noted += 1;
    const { line, address } = this.station;
    note({ number: `mark ${this.#noted}`, time_s: this.#now, kind: "mark", text: `mark ${this.#noted}`, line, stations: [address] });
  }

  /** What is not in the stream. */
  async refresh() {
    await Promise.all([this.master.refresh(), this.parameters.refresh(), this.objects.refresh(), this.records.refresh()]);
  }

  /** What moves by itself between two states: LEDs, curves. */
  paint() {
    this.device.paint();
    this.curves.paint();
  }

  #showHead(state) {
    const { kind, word } = stateOf(state);
    const text = state.power === "off" ? "switched off" : state.fault ? `fault ${state.fault.fault}` : (state.state_text ?? word);
    if (this.#state.dataset.kind !== kind || this.#state.textContent !== text) {
      mark(this.#state, "data-kind", kind);
      this.#state.replaceChildren(html("span", { class: "shape", "aria-hidden": "true" }), text);
    }
    const { bus, owner_address: owner } = state;
    // On CANopen nobody owns a node.
    const master = bus !== "profibus" || owner === undefined ? null : owner === null ? "no master" : `master ${owner}`;
    const fault = state.fault ? `fault ${faultText(state.fault)}` : null;
    const about = [state.product ?? state.device, state.bus_state, master, fault, state.warning].filter((part) => part && part !== text);
    say(this.#about, about.join(" · "));
  }

  async #act(asked) {
    try {
      await asked;
      say(this.#message, "");
    } catch (error) {
      say(this.#message, error.message);
    }
  }
}

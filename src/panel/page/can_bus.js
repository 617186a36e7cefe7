// A bus of CAN: what was counted, faults on it, nodes that come and go.
import { html, say, Rows } from "./dom.js";
import { request } from "./api.js";
import { LineFaults } from "./line_faults.js";

/** How a fault is written, and what the master gets (docs/faults.md). */
const FAULTS = [
  ["boot-up-missing", "no boot-up"],
  ["boot-up-twice", "two boot-ups"],
  ["sdo-late=20ms", "SDO answers 20 ms later"],
  ["sdo-lost", "no SDO answer"],
  ["sdo-twice", "SDO answers twice"],
  ["sdo-other-index", "SDO answers of another object"],
  ["sdo-wrong-toggle", "segments with the wrong toggle bit"],
  ["sdo-abort=08000022", "an abort in place of SDO answers"],
  ["heartbeat-jitter=50ms", "every second heartbeat later"],
  ["heartbeat-lost", "no heartbeat"],
  ["heartbeat-stuck=05", "heartbeats always with this state"],
  ["guarding-toggle-stuck", "guarding answers without toggle"],
  ["tpdo-short", "TPDOs without their last octet"],
  ["tpdo-stale", "TPDOs with old data"],
  ["tpdo-swapped", "a TPDO after the next one"],
  ["emcy-storm=100ms", "EMCY again and again"],
  ["pre-operational", "the node leaves OPERATIONAL by itself"],
  ["brown-out=500ms", "the supply fails and returns"],
  ["frame-lost", "nobody hears a frame"],
  ["frame-late=20ms", "frames 20 ms later"],
  ["frame-twice", "frames twice"],
  ["frame-damaged", "error frames: 32 lead to bus off"],
  ["frame-not-acknowledged", "no acknowledge: 16 lead to error passive"],
];

/** As on the command line. */
const DEVICES = ["ag03-1", "ap10", "asda-a2"];

export class CanBusView {
  #counters;
  #nodes;

  constructor() {
    const by = (id) => document.getElementById(id);
    this.#drawCounters(by("counters"));
    const message = html("p", { class: "refused", role: "alert" });
    const act = (...of) => this.#act(message, ...of);
    this.faults = new LineFaults(by("line-faults"), { kinds: FAULTS, placeholder: "node=5,rate=0.1", message, act });
    this.#drawForm(by("stations"));
  }

  /** Asks for the state of the bus and shows it. */
  async refresh() {
    const bus = await request("GET", "/bus");
    const load = bus.time_seconds > 0 ? (100 * bus.busy_seconds) / bus.time_seconds : 0;
    this.#counters.show(
      [
        { what: "rate", text: `${bus.rate_bits_per_second / 1000} kbit/s` },
        { what: "frames", text: String(bus.frames) },
        { what: "remote requests among them", text: String(bus.remote_requests) },
        { what: "error frames", text: String(bus.error_frames) },
        { what: "load since the start", text: `${load.toFixed(1)} %` },
      ],
      ({ what }) => what,
    );
    // Two nodes may have one number.
    this.#nodes.show(bus.nodes.map((node, place) => ({ ...node, place })), ({ place }) => place);
    this.faults.show(bus.faults);
  }

  #drawCounters(root) {
    const counters = html("tbody");
    const nodes = html("tbody");
    root.replaceChildren(
      html("table", { class: "table" }, counters),
      html("h4", {}, "Nodes"),
      html("table", { class: "table" }, html("thead", {}, html("tr", {}, ...["Number", "Error state"].map((name) => html("th", { scope: "col" }, name)))), nodes),
    );
    this.#counters = new Rows(counters, ({ what }) => {
      const value = html("td", { class: "right" });
      return { element: html("tr", {}, html("td", {}, what), value), show: ({ text }) => say(value, text) };
    });
    this.#nodes = new Rows(nodes, () => {
      const cells = [html("td"), html("td")];
      return {
        element: html("tr", {}, ...cells),
        show: ({ address, error_state: state }) => [String(address), state.replace("_", " ")].forEach((text, index) => say(cells[index], text)),
      };
    });
  }

  #drawForm(root) {
    const message = html("p", { class: "refused", role: "alert" });
    const act = (...of) => this.#act(message, ...of);
    const address = html("input", { type: "number", min: 1, max: 127, required: true });
    const device = html("select", {}, ...DEVICES.map((value) => html("option", { value }, value)));
    const remove = html("button", { type: "button", onclick: () => address.reportValidity() && act("DELETE", `/drives/${address.valueAsNumber}`) }, "Remove");
    const form = html(
      "form",
      { class: "form" },
      html("label", { class: "field" }, "Number ", address),
      html("label", { class: "field" }, "Device ", device),
      html("span", { class: "group" }, html("button", { type: "submit" }, "Add"), remove),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      act("POST", "/drives", { address: address.valueAsNumber, device: device.value });
    });
    root.replaceChildren(form, message);
  }

  async #act(message, method, path, body) {
    try {
      await request(method, path, body);
      say(message, "");
      await this.refresh();
    } catch (error) {
      say(message, error.message);
    }
  }
}

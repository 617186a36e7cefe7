// The bus: what was counted, faults on its line, drives that come and go.
import { html, say, Rows } from "./dom.js";
import { request } from "./api.js";
import { BusRates } from "./bus_rates.js";
import { LineFaults } from "./line_faults.js";
import { MODELS } from "./states.js";

/** How a fault on the line is written, and what the master gets (docs/faults.md). */
const FAULTS = [
  ["no-reply", "no reply"],
  ["late=20ms", "replies 20 ms later"],
  ["duplicate", "replies twice"],
  ["truncated", "replies without their end"],
  ["bit-errors=1", "one bit inverted"],
  ["wrong-fcs", "a wrong frame check sequence"],
  ["wrong-length", "wrong LE and LEr"],
  ["wrong-source", "the reply of another station"],
  ["noise=4", "noise before the reply"],
  ["drop-request", "requests are not heard"],
  ["diag-storm", "a diagnosis announced each time"],
  ["not-ready=2s", "Station_Not_Ready for 2 s"],
  ["refuse-prm", "Set_Prm is refused"],
  ["refuse-cfg", "Chk_Cfg is refused"],
  ["lose-prm", "the slave waits for Set_Prm again"],
  ["pkw-delay=10", "PKW answers 10 exchanges later"],
  ["pkw-wrong-ak", "PKW answers with a wrong AK"],
  ["pkw-wrong-pnu", "PKW answers with a wrong PNU"],
  ["pkw-torn", "PKW answers torn in two"],
];

export class BusView {
  #line;
  #stations;

  constructor() {
    const by = (id) => document.getElementById(id);
    this.rates = new BusRates(by("rates"));
    this.#drawCounters(by("counters"));
    const message = html("p", { class: "refused", role: "alert" });
    const act = (...of) => this.#act(message, ...of);
    this.faults = new LineFaults(by("line-faults"), { kinds: FAULTS, placeholder: "rate=0.1,station=5", message, act });
    this.#drawStations(by("stations"));
  }

  /** Asks for the state of the bus and shows it. */
  async refresh() {
    const bus = await request("GET", "/bus");
    this.rates.show(bus);
    const rejected = bus.rejected.filter(({ count }) => count > 0);
    this.#line.show(
      [
        { what: "rate", text: `${bus.rate_bits_per_second / 1000} kbit/s` },
        ...bus.telegrams_heard.map(({ what, count }) => ({ what: `heard: ${what}`, text: String(count) })),
        { what: "sent", text: String(bus.telegrams_sent) },
        { what: "searched for the next telegram", text: String(bus.resyncs) },
        ...(rejected.length === 0 ? [{ what: "rejected", text: "0" }] : rejected.map(({ what, count }) => ({ what: `rejected: ${what}`, text: String(count) }))),
      ],
      ({ what }) => what,
    );
    this.#stations.show(bus.stations, ({ address }) => address);
    this.faults.show(bus.faults);
  }

  #drawCounters(root) {
    const line = html("tbody");
    const stations = html("tbody");
    root.replaceChildren(
      html("table", { class: "table" }, line),
      html("h4", {}, "Stations"),
      html(
        "div",
        { class: "scroll", tabindex: 0, role: "region", "aria-label": "Stations" },
        html("table", { class: "table" }, html("thead", {}, html("tr", {}, ...["Address", "Requests", "Retries", "Replies", "Too late", "Watchdog"].map((name) => html("th", { scope: "col", class: "right" }, name)))), stations),
      ),
    );
    this.#line = new Rows(line, ({ what }) => {
      const value = html("td", { class: "right" });
      return { element: html("tr", {}, html("td", {}, what), value), show: ({ text }) => say(value, text) };
    });
    this.#stations = new Rows(stations, () => {
      const cells = Array.from({ length: 6 }, () => html("td", { class: "right" }));
      return {
        element: html("tr", {}, ...cells),
        show: ({ address, counters }) => {
          const { requests, retries, replies, replies_too_late, watchdog_expiries } = counters;
          [address, requests, retries, replies, replies_too_late, watchdog_expiries].forEach((value, index) => say(cells[index], String(value)));
        },
      };
    });
  }

  #drawStations(root) {
    const message = html("p", { class: "refused", role: "alert" });
    const act = (...of) => this.#act(message, ...of);
    const address = html("input", { type: "number", min: 0, max: 126, required: true });
    const model = html("select", {}, ...Object.entries(MODELS).reverse().map(([value, name]) => html("option", { value }, name)));
    const gear = html("select", {}, html("option", { value: "48" }, "48:1"), html("option", { value: "24" }, "24:1"));
    const remove = html("button", { type: "button", onclick: () => address.reportValidity() && act("DELETE", `/drives/${address.valueAsNumber}`) }, "Remove");
    const form = html(
      "form",
      { class: "form" },
      html("label", { class: "field" }, "Address ", address),
      html("label", { class: "field" }, "Model ", model),
      html("label", { class: "field" }, "Gear ", gear),
      html("span", { class: "group" }, html("button", { type: "submit" }, "Add"), remove),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      act("POST", "/drives", { address: address.valueAsNumber, model: model.value, gear_ratio: Number(gear.value) });
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

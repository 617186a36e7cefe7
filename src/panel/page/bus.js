// A line: what was counted, faults on purpose, stations that come and go.
import { Figures, Rows, Table, button, field, form, html, many, numberText, say } from "./dom.js";
import { lineOf, request } from "./api.js";
import { BusRates } from "./bus_rates.js";

export class BusView {
  #by = (id) => document.getElementById(id);
  #lines = [];
  #shown = null;
  #choose = html("select", { id: "choose-line", onchange: () => this.#open(this.#choose.value) });
  #field = html("label", { class: "field" }, "Line ", this.#choose);

  /** The name of the line that is shown, null before one is. */
  get line() {
    return this.#shown?.name ?? null;
  }

  /** Asks which lines there are, and for the state of the one that is shown. */
  async refresh() {
    const { lines } = await request("GET", "/lines");
    this.#offer(lines);
    if (!this.#lines.includes(this.line)) this.#open(this.#lines[0]);
    await this.#shown?.refresh();
  }

  #offer(lines) {
    const names = lines.map(({ line }) => line);
    this.#field.hidden = names.length < 2;
    if (names.join() === this.#lines.join()) return;
    this.#lines = names;
    this.#choose.replaceChildren(...lines.map(({ line, bus, link }) => html("option", { value: line }, `${line} (${bus}, ${link})`)));
  }

  #open(name) {
    if (name === undefined) return;
    this.#choose.value = name;
    this.#shown = new LineView(name, this.#field);
    this.#by("bus").replaceChildren(this.#shown.element);
    this.#shown.refresh().catch(() => {});
  }
}

/** A view is made for one line: nothing in it acts on another one. */
class LineView {
  #path;
  #rates = new BusRates();
  #totals = new Figures();
  #counters = html("div");
  #table = null;
  #columns = "";
  #faults;
  #message = html("p", { class: "refused", role: "alert" });

  constructor(name, choose) {
    this.name = name;
    this.#path = lineOf(name);
    this.#faults = new Faults((...of) => this.#act(...of), this.#path);
    const card = (id, title, ...children) => html("section", { class: "card", id, "aria-labelledby": `${id}-title` }, html("h3", { id: `${id}-title` }, title), ...children);
    this.element = html(
      "div",
      { class: "stack" },
      html("div", { class: "toolbar" }, html("h2", { id: "bus-title" }, "Bus"), html("span", { class: "spacer" }), choose),
      this.#message,
      html(
        "div",
        { class: "pair" },
        html("div", { class: "column" }, card("rates", "Rates", this.#rates.element), card("counters", "Counters", this.#totals.element, this.#counters)),
        html("div", { class: "column" }, card("line-faults", "Faults on the line", this.#faults.element), card("devices", "Add or remove a station", this.#stationForm())),
      ),
    );
  }

  async refresh() {
    const bus = await request("GET", this.#path);
    this.#rates.show(bus);
    this.#showTotals(bus);
    this.#showStations(bus.stations ?? []);
    this.#faults.show(bus);
    this.#offer(bus.devices ?? []);
  }

  /** Every number that the line counts, by its name. */
  #showTotals(bus) {
    const { rate_bits_per_second: rate, rejected = [], telegrams_heard: heard = [], ...others } = bus;
    const plain = Object.entries(others).filter(([key, value]) => typeof value === "number" && key !== "time_seconds" && key !== "busy_seconds");
    const counted = [...heard.map(({ what, count }) => [`heard: ${what}`, count]), ...rejected.filter(({ count }) => count > 0).map(({ what, count }) => [`rejected: ${what}`, count])];
    const all = [...plain.map(([key, value]) => [key.replaceAll("_", " "), value]), ...counted];
    this.#totals.show([{ name: "rate", text: `${rate / 1000} kbit/s` }, ...all.map(([name, value]) => ({ name, text: numberText(value) }))]);
  }

  /** A column for each counter that stations have. */
  #showStations(stations) {
    const counters = (station) => ({ ...(station.error_state ? { error_state: station.error_state } : {}), ...station.counters });
    const columns = [...new Set(stations.flatMap((station) => Object.keys(counters(station))))];
    if (columns.join() !== this.#columns || this.#table === null) {
      this.#columns = columns.join();
      const names = ["Address", ...columns.map((name) => name.replaceAll("_", " "))].map((name) => `>${name}`);
      const texts = (station) => [String(station.address), ...columns.map((name) => numberText(counters(station)[name] ?? null).replaceAll("_", " "))];
      this.#table = new Table("Counters of the stations", names, texts);
      this.#counters.replaceChildren(this.#table.element);
    }
    this.#table.show(stations.map((station) => ({ ...station, key: station.address })));
  }

  #stationForm() {
    this.address = html("input", { type: "number", min: 0, max: 127, required: true });
    this.device = html("select", { "aria-label": "Device" });
    const add = () => this.address.reportValidity() && this.#act("POST", "/stations", { line: this.name, address: this.address.valueAsNumber, device: this.device.value });
    const remove = button("Remove", () => this.address.reportValidity() && this.#act("DELETE", `${this.#path}/stations/${this.address.valueAsNumber}`));
    return form({}, add, field("Address", this.address), field("Device", this.device), html("span", { class: "group" }, html("button", { type: "submit" }, "Add"), remove));
  }

  #offer(devices) {
    if (this.device.options.length === devices.length) return;
    this.device.replaceChildren(...devices.map(({ device, text }) => html("option", { value: device }, text ?? device)));
  }

  async #act(method, path, body) {
    try {
      await request(method, path, body);
      say(this.#message, "");
      await this.refresh();
    } catch (error) {
      say(this.#message, error.message);
    }
  }
}

/** The faults on purpose of a line: those that act, one more, all of them off. */
class Faults {
  #rows;
  #kinds = html("datalist", { id: "fault-kinds" });
  #kind = html("input", { type: "text", "aria-label": "Fault", list: "fault-kinds", placeholder: "late=20ms", autocomplete: "off", spellcheck: "false" });
  #more = html("input", { type: "text", "aria-label": "When and where", placeholder: "rate=0.1,station=5", autocomplete: "off", spellcheck: "false" });
  #none = html("p", { class: "muted" }, "None.");
  #clear;

  constructor(act, path) {
    const add = () => act("POST", `${path}/faults`, { fault: [this.#kind.value.trim(), this.#more.value.trim()].filter(Boolean).join(",") });
    const list = html("ul", { class: "line" });
    this.#clear = html("p", {}, button("Remove all", () => act("DELETE", `${path}/faults`)));
    const controls = form({}, add, this.#kind, this.#kinds, html("span", { class: "group" }, this.#more, html("button", { type: "submit" }, "Add")));
    this.element = html("div", { class: "stack" }, this.#none, list, this.#clear, controls);
    this.#rows = new Rows(list, ({ number, fault }) => {
      const injected = html("span", { class: "muted" });
      const remove = button("Remove", () => act("DELETE", `${path}/faults/${number}`), { "aria-label": `Remove ${fault}` });
      const element = html("li", {}, html("span", { class: "mono" }, fault), html("span", { class: "group" }, injected, remove));
      return { element, show: ({ injected: count, may_act }) => say(injected, `${may_act ? "" : "does not act now, "}injected ${many(count, "time")}`) };
    });
  }

  show({ faults = [], fault_kinds: kinds = [] }) {
    if (this.#kinds.children.length !== kinds.length) this.#kinds.replaceChildren(...kinds.map(({ fault, text }) => html("option", { value: fault }, text)));
    this.#rows.show(faults, ({ number }) => number);
    this.#none.hidden = faults.length > 0;
    this.#clear.hidden = faults.length === 0;
  }
}

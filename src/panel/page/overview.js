// The whole plant: every station of every line as a tile, with address, state as a word and a shape, the values worth seeing;
// of each line what passes on it, and which faults wait there on purpose.
import { field, html, many, say, mark, Rows } from "./dom.js";
import { lineOf, linkOf, request } from "./api.js";
import { share, total } from "./bus_rates.js";
import { stateOf, valueText } from "./states.js";

/** So many have room for large tiles. */
const FEW = 12;

/** How the stations are put in order. */
const ORDERS = [
  ["line", "by line"],
  ["address", "by address"],
  ["fault", "faults first"],
];
/** What needs somebody comes first. */
const URGENT = ["fault", "warning", "moving", "ready", "idle", "off"];

export class Overview {
  #by = (id) => document.getElementById(id);
  #stations = [];
  /** The state of each line, and the one before, by name. */
  #traffic = new Map();
  #order = html("select", { onchange: () => this.#update() }, ...ORDERS.map(([value, name]) => html("option", { value }, name)));
  #lines = new Rows(this.#by("lines"), (line) => new Line(line));

  constructor() {
    this.filter = this.#by("stations-filter");
    this.filter.addEventListener("input", () => this.#update());
    this.filter.closest("label").before(field("Order", this.#order));
  }

  /** What passes on each line, which is not in the stream. */
  async refresh() {
    const names = [...new Set(this.#stations.map(({ line }) => line))];
    for (const line of names) {
      const now = await request("GET", lineOf(line)).catch(() => null);
      const before = this.#traffic.get(line)?.now;
      // Counters that go back are those of another start.
      if (now) this.#traffic.set(line, { now, before: before?.time_seconds < now.time_seconds ? before : undefined });
    }
    this.#update();
  }

  /** `stations` are summaries, sorted. */
  show(stations) {
    this.#stations = stations.map((station) => ({ ...station, ...stateOf(station) }));
    this.#update();
  }

  #update() {
    const wanted = this.filter.value.toLowerCase().split(/[\s,]+/).filter(Boolean);
    const shown = this.#stations.filter((station) => matches(station, wanted));
    const several = new Set(this.#stations.map(({ line }) => line)).size > 1;
    const few = this.#stations.length <= FEW;
    const order = this.#order.value;
    const urgent = ({ kind }) => (order === "fault" ? URGENT.indexOf(kind) : 0);
    if (order !== "line") shown.sort((a, b) => urgent(a) - urgent(b) || a.address - b.address || a.line.localeCompare(b.line));
    const names = [...new Set(shown.map(({ line }) => line))];
    const together = { line: "", several: false, few, stations: shown.map((station) => ({ ...station, of: several ? station.line : "" })), about: names.map((line) => `${line}: ${aboutLine(this.#traffic.get(line))}`).join("; ") };
    const each = names.map((line) => ({ line, several, few, stations: shown.filter((station) => station.line === line), about: aboutLine(this.#traffic.get(line)) }));
    this.#lines.show(order === "line" ? each : [together], ({ line }) => line);
    const faults = this.#stations.filter(({ kind }) => kind === "fault").length;
    const all = many(this.#stations.length, "station");
    const some = wanted.length === 0 ? all : `${shown.length} of ${all}`;
    say(this.#by("stations-count"), faults === 0 ? some : `${some}, ${faults} in fault`);
    this.#by("stations-none").hidden = shown.length > 0 || wanted.length === 0;
  }
}

/** Whether a number of the filter is the address, and every word is found. Several numbers are alternatives. */
function matches(station, wanted) {
  const numbers = wanted.filter((word) => /^\d+$/.test(word)).map(Number);
  const words = wanted.filter((word) => !/^\d+$/.test(word));
  const { product, device, word, kind, line, bus } = station;
  const text = `${product} ${device} ${word} ${kind} ${line} ${bus}`.toLowerCase();
  return (numbers.length === 0 || numbers.includes(station.address)) && words.every((word) => text.includes(word));
}

/** What passes on a line, and which faults wait there. */
function aboutLine(traffic) {
  if (!traffic) return "";
  const { now, before } = traffic;
  const seconds = before ? now.time_seconds - before.time_seconds : 0;
  const parts = seconds > 0 ? [`${Math.round((total(now) - total(before)) / seconds)} telegrams/s`] : [];
  if (seconds > 0 && now.busy_seconds !== undefined) parts.push(`load ${share(now.busy_seconds - before.busy_seconds, seconds)}`);
  const waiting = (now.faults ?? []).map(({ fault }) => fault);
  if (waiting.length > 0) parts.push(`faults on purpose: ${waiting.join(", ")}`);
  return parts.join(", ");
}

/** The stations of a line, or of all; its name where there are several, and what passes on it. */
class Line {
  #title = html("h3");
  #about = html("p", { class: "muted about-line" });
  #tiles = html("ul", { class: "tiles" });
  #rows = new Rows(this.#tiles, () => new Tile());

  constructor({ line }) {
    this.element = html("section", { "aria-label": line === "" ? "All lines" : `Line ${line}` }, this.#title, this.#about, this.#tiles);
  }

  show({ line, several, few, stations, about }) {
    this.#title.hidden = !several;
    say(this.#about, about);
    say(this.#title, `${line} (${stations[0]?.bus ?? ""})`);
    this.#tiles.classList.toggle("few", few);
    this.#rows.show(stations, ({ line: name, address }) => `${name} ${address}`);
  }
}

class Tile {
  #address = html("span", { class: "address" });
  #name = html("span", { class: "name" });
  #word = html("span", { class: "word" });
  #values = html("span", { class: "position" });

  constructor() {
    this.link = html("a", { class: "tile" }, this.#address, html("span", { class: "shape", "aria-hidden": "true" }), this.#name, this.#word, this.#values);
    this.element = html("li", {}, this.link);
  }

  show(station) {
    const { address, product, device, kind, word, headline, display, of } = station;
    mark(this.link, "href", linkOf(station));
    mark(this.link, "data-kind", kind);
    mark(this.link, "title", `${product ?? device}: ${word}`);
    say(this.#address, of ? `${of}/${address}` : String(address));
    say(this.#name, product ?? device);
    say(this.#word, word);
    const rows = (display?.rows ?? []).map(({ text }) => text.trim());
    const texts = rows.length > 0 ? rows : (headline ?? []).slice(0, 1).map(valueText);
    say(this.#values, texts.join("  "));
  }
}

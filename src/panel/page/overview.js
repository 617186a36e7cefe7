// Every station as a tile: address, state as a word and a shape, the values worth seeing.
import { html, many, say, mark, Rows } from "./dom.js";
import { linkOf } from "./api.js";
import { stateOf, valueText } from "./states.js";

/** So many have room for large tiles. */
const FEW = 12;

export class Overview {
  #by = (id) => document.getElementById(id);
  #stations = [];
  #lines = new Rows(this.#by("lines"), (line) => new Line(line));

  constructor() {
    this.filter = this.#by("stations-filter");
    this.filter.addEventListener("input", () => this.#update());
  }

  /** `stations` are summaries, sorted. */
  show(stations) {
    this.#stations = stations.map((station) => ({ ...station, ...stateOf(station) }));
    this.#update();
  }

  #update() {
    const wanted = this.filter.value.toLowerCase().split(/[\s,]+/).filter(Boolean);
    const shown = this.#stations.filter((station) => matches(station, wanted));
    const names = [...new Set(shown.map(({ line }) => line))];
    const several = new Set(this.#stations.map(({ line }) => line)).size > 1;
    const few = this.#stations.length <= FEW;
    this.#lines.show(
      names.map((line) => ({ line, several, few, stations: shown.filter((station) => station.line === line) })),
      ({ line }) => line,
    );
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

/** The stations of a line; its name where there are several. */
class Line {
  #title = html("h3");
  #tiles = html("ul", { class: "tiles" });
  #rows = new Rows(this.#tiles, () => new Tile());

  constructor({ line }) {
    this.element = html("section", { "aria-label": `Line ${line}` }, this.#title, this.#tiles);
  }

  show({ line, several, few, stations }) {
    this.#title.hidden = !several;
    say(this.#title, `${line} (${stations[0]?.bus ?? ""})`);
    this.#tiles.classList.toggle("few", few);
    this.#rows.show(stations, ({ address }) => address);
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
    const { address, product, device, kind, word, headline, display } = station;
    mark(this.link, "href", linkOf(station));
    mark(this.link, "data-kind", kind);
    mark(this.link, "title", `${product ?? device}: ${word}`);
    say(this.#address, String(address));
    say(this.#name, product ?? device);
    say(this.#word, word);
    const rows = (display?.rows ?? []).map(({ text }) => text.trim());
    const texts = rows.length > 0 ? rows : (headline ?? []).slice(0, 1).map(valueText);
    say(this.#values, texts.join("  "));
  }
}

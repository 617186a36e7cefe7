// Every drive as a tile: address, state as a word and a shape, position.
import { html, many, say, mark, Rows } from "./dom.js";

/** So many drives have room for large tiles. */
const FEW = 12;

export class Overview {
  #rows;
  #drives = [];

  /** `thing` is what one of them is called. */
  constructor({ tiles, filter, count, none }, thing = "drive") {
    Object.assign(this, { filter, count, none, thing });
    this.tiles = tiles;
    this.#rows = new Rows(tiles, () => new Tile());
    filter.addEventListener("input", () => this.#update());
  }

  /** `drives` are `{ address, name, kind, word, position }`. */
  show(drives) {
    this.#drives = drives;
    this.tiles.classList.toggle("few", drives.length <= FEW);
    this.#update();
  }

  #update() {
    const wanted = this.filter.value.toLowerCase().split(/[\s,]+/).filter(Boolean);
    const shown = this.#drives.filter((drive) => matches(drive, wanted));
    this.#rows.show(shown, ({ address }) => address);
    const faults = this.#drives.filter(({ kind }) => kind === "fault").length;
    const all = many(this.#drives.length, this.thing);
    const some = wanted.length === 0 ? all : `${shown.length} of ${all}`;
    say(this.count, faults === 0 ? some : `${some}, ${faults} in fault`);
    this.none.hidden = shown.length > 0 || wanted.length === 0;
  }
}

/** Whether a number of the filter is the address, and every word is found. Several numbers are alternatives. */
function matches(drive, wanted) {
  const numbers = wanted.filter((word) => /^\d+$/.test(word)).map(Number);
  const words = wanted.filter((word) => !/^\d+$/.test(word));
  const text = `${drive.name} ${drive.word} ${drive.kind}`.toLowerCase();
  return (numbers.length === 0 || numbers.includes(drive.address)) && words.every((word) => text.includes(word));
}

class Tile {
  #address = html("span", { class: "address" });
  #name = html("span", { class: "name" });
  #word = html("span", { class: "word" });
  #position = html("span", { class: "position" });

  constructor() {
    this.link = html("a", { class: "tile" }, this.#address, html("span", { class: "shape", "aria-hidden": "true" }), this.#name, this.#word, this.#position);
    this.element = html("li", {}, this.link);
  }

  show({ address, name, kind, word, position }) {
    mark(this.link, "href", `#drive/${address}`);
    mark(this.link, "data-kind", kind);
    mark(this.link, "title", `${name}: ${word}`);
    say(this.#address, String(address));
    say(this.#name, name);
    say(this.#word, word);
    say(this.#position, position);
  }
}

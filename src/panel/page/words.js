// A word bit by bit: number, level, and what the manual calls the bit in the operating mode.
import { html, say, mark, Rows } from "./dom.js";

const CHANGED_MS = 1200;

export class WordTable {
  #raw = html("code");
  #mode = html("span");
  #rows;

  constructor(root) {
    const bits = html("ul", { class: "bits" });
    root.replaceChildren(html("p", { class: "raw" }, this.#raw, this.#mode), bits);
    this.#rows = new Rows(bits, () => new BitRow());
  }

  /**
   * `raw` is the word, `mode` the operating mode in words; `bits` are `{ bit, name, meaning, set, alarm, used }`
   * in the order to show them: `name` is the manual's, `meaning` that of the level (or ""), `alarm` is for levels that
   * need somebody, `used` for bits that mean something.
   */
  show({ raw, mode, bits }) {
    say(this.#raw, raw.toString(16).toUpperCase().padStart(4, "0"));
    say(this.#mode, mode ? ` ${mode}` : "");
    this.#rows.show(bits, ({ bit }) => bit);
  }
}

class BitRow {
  #level = html("span", { class: "level" });
  #number = html("span", { class: "number" });
  #name = html("span", { class: "name" });
  #meaning = html("span", { class: "meaning" });
  #set = null;
  #timer = 0;

  constructor() {
    this.element = html("li", {}, this.#number, this.#level, html("span", {}, this.#meaning, " ", this.#name));
  }

  show({ bit, name, meaning, set, alarm, used }) {
    say(this.#number, String(bit));
    say(this.#level, set ? "1" : "0");
    // What the level means comes first: a 1 beside "stop" would read as a stop, where it is none.
    say(this.#meaning, meaning === "" ? name : meaning);
    say(this.#name, meaning === "" ? "" : name);
    mark(this.element, "data-set", set);
    mark(this.element, "data-alarm", Boolean(alarm));
    mark(this.element, "data-used", used);
    if (this.#set !== null && this.#set !== set) {
      mark(this.element, "data-changed", true);
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => mark(this.element, "data-changed", false), CHANGED_MS);
    }
    this.#set = set;
  }
}

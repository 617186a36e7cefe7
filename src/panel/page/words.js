// A word bit by bit: number, level, and what the manual calls the bit in the operating mode.
import { html, say, mark, Rows } from "./dom.js";

const CHANGED_MS = 1200;

export class WordTable {
  #raw = html("code");
  #mode = html("span");
  #rows;

  constructor(root) {
    const body = html("tbody");
    root.replaceChildren(html("p", { class: "raw" }, this.#raw, this.#mode), html("table", { class: "bits" }, body));
    this.#rows = new Rows(body, () => new BitRow());
  }

  /**
   * `raw` is the word, `mode` the operating mode in words; `bits` are `{ bit, name, meaning, set, alarm }`
   * in the order to show them: `name` is the manual's, `meaning` that of the level (or ""), `alarm` is for levels that
   * need somebody.
   */
  show({ raw, mode, bits }) {
    say(this.#raw, raw.toString(16).toUpperCase().padStart(4, "0"));
    say(this.#mode, mode ? ` ${mode}` : "");
    this.#rows.show(bits, ({ bit }) => bit);
  }
}

class BitRow {
  #level = html("span");
  #number = html("td", { class: "number" });
  #name = html("span", { class: "name" });
  #meaning = html("span", { class: "meaning" });
  #set = null;
  #timer = 0;

  constructor() {
    this.element = html("tr", {}, this.#number, html("td", { class: "level" }, this.#level), html("td", {}, this.#name, " ", this.#meaning));
  }

  show({ bit, name, meaning, set, alarm }) {
    say(this.#number, String(bit));
    say(this.#level, set ? "1" : "0");
    say(this.#name, name);
    say(this.#meaning, meaning);
    mark(this.element, "data-set", set);
    mark(this.element, "data-alarm", Boolean(alarm));
    if (this.#set !== null && this.#set !== set) {
      mark(this.element, "data-changed", true);
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => mark(this.element, "data-changed", false), CHANGED_MS);
    }
    this.#set = set;
  }
}

// Words bit by bit: number, level, and what the manual calls the bit in the operating mode.
import { html, say, mark, Rows } from "./dom.js";

const CHANGED_MS = 1200;

/** A card for each word. */
export class Words {
  element = html("div", { class: "words", id: "words" });
  #rows = new Rows(this.element, (word) => new Word(word));

  show({ words }) {
    this.element.hidden = !words || words.length === 0;
    mark(this.element, "data-count", words?.length ?? 0);
    this.#rows.show(words ?? [], ({ key }) => key);
  }
}

class Word {
  #raw = html("code");
  #title;
  #rows;

  constructor({ key }) {
    const bits = html("ul", { class: "bits" });
    this.#title = html("h3", { id: `word-${key}` });
    this.element = html("section", { class: "card", "data-word": key, "aria-labelledby": `word-${key}` }, this.#title, html("p", { class: "raw" }, this.#raw), bits);
    this.#rows = new Rows(bits, () => new Bit());
  }

  show({ name, value, bits }) {
    say(this.#title, name);
    say(this.#raw, value === null ? "–" : `${value.toString(16).toUpperCase().padStart(4, "0")}h`);
    this.#rows.show(bits, ({ bit }) => bit);
  }
}

class Bit {
  #level = html("span", { class: "level" });
  #number = html("span", { class: "number" });
  #name = html("span", { class: "name" });
  #meaning = html("span", { class: "meaning" });
  #set = null;
  #timer = 0;

  constructor() {
    this.element = html("li", {}, this.#number, this.#level, html("span", {}, this.#meaning, " ", this.#name));
  }

  show({ bit, name, meaning, note, set, alarm, used }) {
    const told = meaning && meaning !== name && used !== false ? meaning : "";
    say(this.#number, String(bit));
    say(this.#level, set ? "1" : "0");
    // What the level means comes first: a 1 beside "stop" would read as a stop, where it is none.
    say(this.#meaning, told || name || "not used");
    say(this.#name, told ? name : "");
    mark(this.element, "title", note ?? "");
    mark(this.element, "data-set", Boolean(set));
    mark(this.element, "data-alarm", Boolean(alarm));
    mark(this.element, "data-used", used !== false);
    if (this.#set !== null && this.#set !== set) {
      mark(this.element, "data-changed", true);
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => mark(this.element, "data-changed", false), CHANGED_MS);
    }
    this.#set = set;
  }
}

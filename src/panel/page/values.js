// Measured values, the most wanted first and larger.
import { html, say, Rows } from "./dom.js";

export class Values {
  #rows;

  constructor(root) {
    this.#rows = new Rows(root, (item) => new Value(item));
  }

  /** `items` are `{ name, value, unit, main }`; `value` is text. */
  show(items) {
    this.#rows.show(items, ({ name }) => name);
  }
}

class Value {
  #value = html("span");
  #unit = html("span", { class: "unit" });

  constructor({ name, main }) {
    this.element = html("div", { class: main ? "main" : "", "data-value": name }, html("dt", {}, name), html("dd", {}, this.#value, this.#unit));
  }

  show({ value, unit }) {
    say(this.#value, value);
    say(this.#unit, unit ?? "");
  }
}

// Every parameter of the drive: number, name, value, range.
import { html, say, mark, Rows } from "./dom.js";

export class Parameters {
  #rows;
  #items = [];

  /** `choose(item)` is called when somebody wants to read or write a parameter. */
  constructor(root, choose) {
    this.filter = html("input", { type: "search", placeholder: "1016, limit ...", autocomplete: "off", spellcheck: "false", oninput: () => this.#update() });
    const body = html("tbody");
    root.replaceChildren(
      html("label", { class: "field" }, "Filter ", this.filter),
      html(
        "div",
        { class: "scroll", tabindex: 0, role: "region", "aria-label": "Parameters" },
        html(
          "table",
          { class: "table" },
          html("thead", {}, html("tr", {}, ...["PNU", "Name", "Value", "Range"].map((name, index) => html("th", { scope: "col", class: index === 2 ? "right" : "" }, name)))),
          body,
        ),
      ),
    );
    this.#rows = new Rows(body, () => new Row(choose));
  }

  /** `items` are `{ pnu, name, value, range, array }` with texts for value and range. */
  show(items) {
    this.#items = items;
    this.#update();
  }

  #update() {
    const words = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    const shown = this.#items.filter(({ pnu, name }) => words.every((word) => `${pnu} ${name}`.toLowerCase().includes(word)));
    this.#rows.show(shown, ({ pnu }) => pnu);
  }
}

class Row {
  #pnu = html("button", { type: "button", class: "plain" });
  #name = html("td");
  #value = html("td", { class: "right" });
  #range = html("td", { class: "muted" });
  #item = null;

  constructor(choose) {
    this.#pnu.addEventListener("click", () => choose(this.#item));
    this.element = html("tr", {}, html("td", {}, this.#pnu), this.#name, this.#value, this.#range);
  }

  show(item) {
    const { pnu, name, value, range } = (this.#item = item);
    say(this.#pnu, String(pnu));
    mark(this.#pnu, "aria-label", `Choose PNU ${pnu}, ${name}`);
    say(this.#name, name);
    say(this.#value, value);
    say(this.#range, range);
  }
}

// Every parameter of a station, or every object of its dictionary: a list with a filter, and a form to read and write one.
import { Table, button, field, form, html, mark, say } from "./dom.js";

/** How parameters are listed, by number. */
export const PARAMETERS = {
  title: "Parameters",
  id: "parameters",
  has: "parameters",
  path: "/parameters",
  placeholder: "1016, limit ...",
  key: ({ key, elements }) => (elements ? `${key}.0` : String(key)),
  pathOf: (key) => key,
  range: ({ access, low, high }) => (access === "read_only" ? "read only" : low === null || low === undefined ? "" : `${low} to ${high}`),
  // Of an array, what is empty at its end says nothing.
  value: ({ text, value }) => (text ?? String(value ?? "")).replace(/(, no fault)+$/, ""),
};

/** How objects are listed, by index and subindex. */
export const OBJECTS = {
  title: "Object dictionary",
  id: "objects",
  has: "objects",
  path: "/objects",
  placeholder: "6041, 0x1017, heartbeat ...",
  key: ({ index, sub }) => `${index}h:${sub}`,
  pathOf: (key) => key.replace(/^0x/i, "").replace(/h?[:.]/i, "/").replace(/h$/i, "/00"),
  range: ({ type, access }) => `${type}, ${access}`,
  value: ({ value, refused }) => (value === null ? (refused ?? "") : String(value)),
};

export class Entries {
  #kind;
  #ask;
  #items = [];
  #wanted = false;
  #table;
  #filter;
  #key;
  #value = html("input", { type: "text", autocomplete: "off", spellcheck: "false" });
  #answer = html("p", { role: "status" });

  /** `kind` is one of the above; `ask(method, path, body)` asks the station. */
  constructor(kind, ask) {
    this.#kind = kind;
    this.#ask = ask;
    this.#filter = html("input", { type: "search", placeholder: kind.placeholder, autocomplete: "off", spellcheck: "false", oninput: () => this.#update() });
    this.#key = html("input", { type: "text", class: "key mono", autocomplete: "off", spellcheck: "false" });
    const texts = (item) => [kind.key(item), item.name, kind.value(item), kind.range(item)];
    const choose = (item) => button(kind.key(item), () => this.#choose(item), { class: "plain mono", "aria-label": `Choose ${kind.key(item)}, ${item.name}` });
    this.#table = new Table(`${kind.title}, all of them`, ["Number", "Name", ">Value", "Range"], texts, choose);
    // Who presses Enter in the value wants it written, not read over.
    const enter = () => (document.activeElement === this.#value ? this.#write() : this.#read());
    this.element = html(
      "section",
      { class: "card", id: kind.id, "aria-labelledby": `${kind.id}-title`, hidden: true },
      html("h3", { id: `${kind.id}-title` }, kind.title),
      form(
        {},
        enter,
        html("span", { class: "group" }, field("Number", this.#key), html("button", { type: "submit" }, "Read")),
        html("span", { class: "group" }, field("Value", this.#value), button("Write", () => this.#write())),
      ),
      this.#answer,
      html("p", { class: "hint" }, "Reads and writes directly, not over the bus: with the checks of the device, but the master sees nothing."),
      field("Filter", this.#filter),
      this.#table.element,
    );
  }

  show({ has, power }) {
    this.#wanted = Boolean(has?.[this.#kind.has]) && power !== "off";
    this.element.hidden = !has?.[this.#kind.has];
    if (!this.#wanted && this.#items.length > 0) this.#take([]);
  }

  /** Asks for all of them. A station without supply has none. */
  async refresh() {
    if (!this.#wanted) return;
    const answer = await this.#ask("GET", this.#kind.path).catch(() => null);
    if (answer) this.#take(Array.isArray(answer) ? answer : answer[this.#kind.id]);
  }

  #take(items) {
    this.#items = items.map((item) => ({ ...item, key: item.key ?? `${item.index}:${item.sub}` }));
    this.#update();
  }

  #update() {
    const words = this.#filter.value.toLowerCase().split(/\s+/).filter(Boolean).map((word) => word.replace(/^0x/, ""));
    const text = (item) => `${this.#kind.key(item)} ${item.name}`.toLowerCase();
    this.#table.show(this.#items.filter((item) => words.every((word) => text(item).includes(word))));
  }

  /** The form is for this one. The value of another one does not stay. */
  #choose(item) {
    this.#key.value = this.#kind.key(item);
    this.#value.value = "";
    this.#read();
    this.#value.focus();
  }

  #read() {
    this.#send("GET");
  }

  /** Nothing typed is not 0. What is written is what was typed, a number or a text. */
  #write() {
    const typed = this.#value.value.trim();
    if (typed === "") {
      this.#say("Nothing is written: there is no value.", "refused");
      this.#value.focus();
      return;
    }
    const number = /^-?0x[0-9a-f]+$/i.test(typed) ? (typed.startsWith("-") ? -Number(typed.slice(1)) : Number(typed)) : Number(typed);
    this.#send("PUT", { value: Number.isNaN(number) ? typed : number });
  }

  async #send(method, body) {
    const key = this.#key.value.trim();
    if (key === "") {
      this.#say("Which one? Give its number, or choose it below.", "refused");
      this.#key.focus();
      return;
    }
    try {
      const answer = await this.#ask(method, `${this.#kind.path}/${this.#kind.pathOf(key)}`, body);
      this.#say(`${key} ${answer.name}: ${this.#kind.value(answer)}`, "done");
      if (method === "PUT") await this.refresh();
    } catch (error) {
      this.#say(error.message, "refused");
    }
  }

  #say(text, kind) {
    mark(this.#answer, "class", kind);
    say(this.#answer, text);
  }
}

// Every parameter of a station, or every object of its dictionary: a list with a filter, and a form to read and write one.
import { Table, button, field, form, html, many, mark, say } from "./dom.js";
import { differences, read as readFile, save } from "./settings.js";

/** How parameters are listed, by number. */
export const PARAMETERS = {
  title: "Parameters",
  id: "parameters",
  has: "parameters",
  path: "/parameters",
  placeholder: "1016, limit ...",
  key: ({ key, elements }) => (elements ? `${key}.0` : String(key)),
  pathOf: (key) => key,
  number: ({ value }) => value,
  digits: 4,
  isSet: ({ access, persistent, value }) => access === "read_write" && persistent && typeof value === "number",
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
  number: ({ value }) => value,
  digits: 0,
  isSet: ({ access, value, default: usual }) => access === "rw" && usual !== null && usual !== undefined && value !== null,
  pathOf: (key) => key.replace(/^0x/i, "").replace(/h?[:.]/i, "/").replace(/h$/i, "/00"),
  range: ({ type, access }) => `${type}, ${access}`,
  value: ({ value, refused }) => (value === null ? (refused ?? "") : String(value)),
};

/** A number as the bus has it: hexadecimal, of a negative one its complement; "" of what is no whole number. */
function hexadecimal({ octets_hex: octets }, number, digits) {
  if (typeof octets === "string" && octets !== "" && typeof number === "number") return `${octets.replaceAll(" ", "").match(/../g).reverse().join("")}h`;
  if (!Number.isInteger(number)) return "";
  const width = number < -0x8000 || number > 0xffff ? 8 : Math.max(digits, 4);
  return `${(number < 0 ? number + 16 ** width : number).toString(16).toUpperCase().padStart(width, "0")}h`;
}

/** How long a value that has changed is marked. */
const CHANGED_MS = 2500;
/** While the list is looked at, it is asked for this often. */
const LIVE_MS = 200;
/** A longer list is asked for with everything else. */
const LIVE_ITEMS = 1000;

/** What can be shown. */
const CHOICES = [
  ["all", "all"],
  ["other", "other than the default"],
  ["changed", "changed since the page is open"],
  ["file", "other than in the file loaded last"],
];

export class Entries {
  #kind;
  #ask;
  #items = [];
  /** When a value changed last, and what it was, by key. */
  #changed = new Map();
  #known = new Map();
  #asking = false;
  #saved = null;
  #wanted = false;
  #table;
  #filter;
  #key;
  #value = html("input", { type: "text", autocomplete: "off", spellcheck: "false" });
  #answer = html("p", { role: "status" });
  #count = html("span", { class: "muted" });
  #only = html("select", { onchange: () => this.#update() }, ...CHOICES.map(([value, name]) => html("option", { value }, name)));
  /** What is done with the file that is chosen next. */
  #then = null;
  #file = html("input", { type: "file", accept: ".json", hidden: true, tabindex: -1, "aria-label": "A file of settings", onchange: () => this.#chosen() });

  /** `kind` is one of the above; `ask(method, path, body)` asks the station. */
  constructor(kind, ask) {
    this.#kind = kind;
    this.#ask = ask;
    this.#filter = html("input", { type: "search", placeholder: kind.placeholder, autocomplete: "off", spellcheck: "false", oninput: () => this.#update() });
    this.#key = html("input", { type: "text", class: "key mono", autocomplete: "off", spellcheck: "false" });
    const texts = (item) => [kind.key(item), item.name, kind.value(item), hexadecimal(item, kind.number(item), kind.digits), this.#besides(item)];
    const choose = (item) => button(kind.key(item), () => this.#choose(item), { class: "plain mono", "aria-label": `Choose ${kind.key(item)}, ${item.name}` });
    this.#table = new Table(`${kind.title}, all of them`, ["Number", "Name", ">Value", ">Hex", "Range"], texts, choose);
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
      html("div", { class: "toolbar" }, field("Filter", this.#filter), field("Show", this.#only), button("Save settings", () => this.#export()), button("Compare with file", () => this.#chooseFile((all) => this.#compare(all))), button("Load settings", () => this.#chooseFile((all) => this.#import(all))), this.#file, this.#count),
      this.#table.element,
    );
    setInterval(() => this.#isLooked() && this.refresh(), LIVE_MS);
  }

  /** Whether somebody can see the list now. */
  #isLooked() {
    if (!this.#wanted || document.hidden || this.element.offsetParent === null || this.#items.length > LIVE_ITEMS) return false;
    const { top, bottom } = this.#table.element.getBoundingClientRect();
    return top < innerHeight && bottom > 0;
  }

  show({ has, power }) {
    this.#wanted = Boolean(has?.[this.#kind.has]) && power !== "off";
    this.element.hidden = !has?.[this.#kind.has];
    if (!this.#wanted && this.#items.length > 0) this.#take([]);
  }

  /** Asks for all of them. A station without supply has none. */
  async refresh() {
    // An answer that is slow is not asked for twice.
    if (!this.#wanted || this.#asking) return;
    this.#asking = true;
    const answer = await this.#ask("GET", this.#kind.path).catch(() => null);
    this.#asking = false;
    if (answer) this.#take(Array.isArray(answer) ? answer : answer[this.#kind.id]);
  }

  #take(items) {
    this.#items = items.map((item) => ({ ...item, key: item.key ?? `${item.index}:${item.sub}` }));
    const now = performance.now();
    for (const item of this.#items) {
      const value = this.#kind.value(item);
      if (this.#known.has(item.key) && this.#known.get(item.key) !== value) this.#changed.set(item.key, now);
      this.#known.set(item.key, value);
    }
    this.#update();
  }

  #update() {
    const words = this.#filter.value.toLowerCase().split(/\s+/).filter(Boolean).map((word) => word.replace(/^0x/, ""));
    // By number, name, value and what the value is in hexadecimal.
    const text = (item) => `${this.#kind.key(item)} ${item.name} ${this.#kind.value(item)} ${hexadecimal(item, this.#kind.number(item), this.#kind.digits)}`.toLowerCase();
    const now = performance.now();
    const shown = { all: () => true, other: (item) => this.#isOther(item), changed: ({ key }) => this.#changed.has(key), file: (item) => this.#inFile(item) !== undefined }[this.#only.value];
    const matching = this.#items.filter((item) => shown(item) && words.every((word) => text(item).includes(word)));
    this.#table.show(matching);
    say(this.#count, many(matching.length, "line"));
    for (const row of this.#table.element.querySelectorAll("tr[data-key]")) {
      const item = this.#items.find(({ key }) => key === row.dataset.key);
      mark(row, "data-changed", now - (this.#changed.get(row.dataset.key) ?? -Infinity) < CHANGED_MS);
      mark(row, "data-other", Boolean(item) && this.#isOther(item));
    }
  }

  /** What a person has set, as a file. */
  #export() {
    save(`${this.#kind.id}.json`, this.#kind.id, this.#items.filter(this.#kind.isSet).map((item) => ({ key: item.key, name: item.name, value: this.#kind.number(item) })));
  }

  #chooseFile(then) {
    this.#then = then;
    this.#file.click();
  }

  async #chosen() {
    const [file] = this.#file.files;
    this.#file.value = "";
    if (!file) return;
    try {
      this.#saved = readFile(await file.text(), this.#kind.id);
    } catch (error) {
      this.#say(error.message, "refused");
      return;
    }
    const differing = differences(this.#saved, this.#items, this.#kind.number);
    await (this.#then ?? ((all) => this.#import(all)))(differing);
  }

  /** What the file has in place of the value; undefined: the same, or nothing. */
  #inFile(item) {
    const saved = this.#saved?.find(({ key }) => key === item.key);
    return saved && saved.value !== this.#kind.number(item) ? saved.value : undefined;
  }

  /** The range; what the default is, and the value in the file, where they are others. */
  #besides(item) {
    const { default: usual } = item;
    const parts = [this.#kind.range(item)];
    if (this.#isOther(item)) parts.push(`default ${usual}`);
    const saved = this.#inFile(item);
    if (saved !== undefined) parts.push(`in the file ${saved}`);
    return parts.filter(Boolean).join("; ");
  }

  #isOther(item) {
    const { default: usual } = item;
    return usual !== null && usual !== undefined && this.#kind.isSet(item) && usual !== this.#kind.number(item);
  }

  /** Shows what differs from the file, and writes nothing. */
  #compare(differing) {
    this.#only.value = "file";
    this.#update();
    this.#say(differing.length === 0 ? "Nothing differs from the file." : `${many(differing.length, "value")} other than in the file. Nothing is written.`, "done");
  }

  /** Writes what the file says otherwise, one after the other. What is refused is said, the rest is written. */
  async #import(differing) {
    const refused = [];
    for (const { key, value } of differing) {
      await this.#ask("PUT", `${this.#kind.path}/${this.#kind.pathOf(key)}`, { value }).catch(({ message }) => refused.push(`${key}: ${message}`));
    }
    await this.refresh();
    const written = `${many(differing.length - refused.length, "value")} written, ${many(refused.length, "value")} refused`;
    this.#say([differing.length === 0 ? "Nothing differs from the file." : written, ...refused].join("; "), refused.length > 0 ? "refused" : "done");
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

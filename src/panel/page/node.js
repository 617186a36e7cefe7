// One node in all details: what is seen of it, what acts on it, its words, PDOs, dictionary and errors.
import { html, say, mark, Rows } from "./dom.js";
import { request } from "./api.js";
import { Why } from "./why.js";
import { WordTable } from "./words.js";

/** Over so wide a range a slider is of no use: steps are. */
const SLIDER_RANGE = 2500;
const STEPS = [-1, -0.1, -0.01, 0.01, 0.1, 1];
/** So long after a change what the node says is not shown over it: it is still on its way. */
const SETTLE_MS = 500;
/** Words for keys that the devices have as pictures. */
const KEYS = { left: "◀ left", up: "▲ up", star: "✱ star", key_1: "key 1 (clockwise)", key_2: "key 2 (counter-clockwise)" };

export class NodeView {
  #by = (id) => document.getElementById(id);
  #address = null;
  #state = null;

  constructor() {
    const by = this.#by;
    this.message = html("p", { class: "refused", role: "alert" });
    this.why = new Why(by("why"));
    this.face = new Face(by("face"), {
      press: (key, pressed) => this.#act("POST", "/keys", { key, pressed }),
      power: () => this.#act("PUT", "/power", { on: this.#state?.power === "off" }),
    });
    by("face").append(this.message);
    this.surroundings = new Surroundings(by("surroundings"), {
      change: (changes) => this.#act("PATCH", "/inputs", changes),
      nominal: () => this.#act("DELETE", "/inputs"),
    });
    this.errors = new Errors(by("faults"), (fault) => this.#act("POST", "/provoke", { fault }));
    this.words = [new WordTable(by("control")), new WordTable(by("status"))];
    this.pdos = new Pdos(by("pdos"));
    this.objects = new Objects(by("objects"), (index, sub, value) =>
      request("PUT", `/drives/${this.#address}/objects/${index}/${sub}`, { value }),
    );
  }

  /** Another node is chosen; nothing of the last one stays. */
  choose(address) {
    if (this.#address === address) return;
    this.#address = address;
    this.#state = null;
    this.objects.show([]);
    say(this.message, "");
    say(this.#by("drive-title"), `Node ${address}`);
    mark(this.#by("drive"), "data-known", "asked");
  }

  /** A complete state of the chosen node. */
  show(state) {
    if (state.address !== this.#address) return;
    this.#state = state;
    mark(this.#by("drive"), "data-known", "there");
    const off = state.power === "off";
    const head = this.#by("drive-state");
    const text = off ? "switched off" : (state.nmt_state ?? "silent");
    const kind = off ? "off" : state.error_register ? "fault" : state.nmt_state === "OPERATIONAL" ? "ready" : "waiting";
    if (head.textContent !== text || head.dataset.kind !== kind) {
      mark(head, "data-kind", kind);
      head.replaceChildren(html("span", { class: "shape", "aria-hidden": "true" }), text);
    }
    const register = state.error_register === null ? "" : ` · error register ${hex(state.error_register, 2)}h`;
    say(this.#by("drive-dp"), `${state.product}${register}`);
    this.#showWhy(state, kind);
    this.face.show(state);
    this.surroundings.show(state);
    this.errors.show(state);
    this.words.forEach((table, place) => {
      const word = state.words[place];
      if (word) table.show({ raw: word.value, mode: `${word.object} ${word.name}`, bits: word.bits.map((bit) => bitRow(bit)) });
      else table.show({ raw: 0, mode: "switched off", bits: [] });
    });
    this.pdos.show(state.pdos);
  }

  /** There is no node of this number. */
  gone(sentence) {
    this.#state = null;
    mark(this.#by("drive"), "data-known", "gone");
    mark(this.#by("drive-state"), "data-kind", "off");
    say(this.#by("drive-state"), "not present");
    this.#by("why").hidden = false;
    this.why.show({ title: sentence, kind: "fault", reasons: [], refused: "" });
  }

  showObjects(objects) {
    this.objects.show(objects);
  }

  #showWhy({ does_not_move: reasons }, kind) {
    // A device that cannot move has no reason not to.
    this.#by("why").hidden = reasons === null;
    if (reasons === null) return;
    const title = reasons.length === 0 ? "Nothing keeps it from moving" : "It does not move, because";
    this.why.show({ title, kind: reasons.length === 0 ? "ready" : kind === "fault" ? "fault" : "waiting", reasons, refused: "" });
  }

  async #act(method, path, body) {
    try {
      await request(method, `/drives/${this.#address}${path}`, body);
      say(this.message, "");
    } catch (error) {
      say(this.message, error.message);
    }
  }
}

function bitRow({ bit, set, name }) {
  return { bit, set, name: name === "" ? "not used" : name, meaning: "", used: name !== "", alarm: set && /fault|error/.test(name) && !/reset/.test(name) };
}

function hex(number, digits) {
  return number.toString(16).toUpperCase().padStart(digits, "0");
}

/** What a person sees of the device: display, signs, LEDs; and its keys and switch. */
class Face {
  #act;
  #keys = new Map();
  #lines;
  #leds;

  constructor(root, act) {
    this.#act = act;
    const lines = html("div", { class: "lcd", role: "img" });
    this.lcd = lines;
    this.#lines = new Rows(lines, () => {
      const element = html("p", { class: "mono" });
      return {
        element,
        show: ({ text, flashing }) => {
          say(element, text === "" ? "\u00a0" : text);
          mark(element, "data-flashing", flashing);
        },
      };
    });
    this.arrow = html("p", { class: "arrow", "aria-label": "arrow" });
    this.signs = html("p", { class: "muted signs" });
    const leds = html("ul", { class: "leds", "aria-label": "LEDs" });
    this.#leds = new Rows(leds, ({ led }) => {
      const lamp = html("span", { class: "lamp", "data-colour": led.split(" ").at(-1), "aria-hidden": "true" });
      const text = html("span");
      return {
        element: html("li", {}, lamp, text),
        show: ({ glow, blinks }) => {
          mark(lamp, "data-glow", glow);
          say(text, `${led}: ${blinks > 0 ? `blinks ${blinks} times` : glow}`);
        },
      };
    });
    this.keys = html("div", { class: "group keys", role: "group", "aria-label": "Keys" });
    this.power = html("button", { type: "button", onclick: () => act.power() }, "Power off");
    root.replaceChildren(lines, this.arrow, this.signs, leds, this.keys, html("p", {}, this.power));
  }

  show({ display, keys, power }) {
    this.lcd.hidden = display.lines.length === 0;
    mark(this.lcd, "aria-label", `Display: ${display.lines.map(({ text }) => text.trim()).join(", ")}`);
    this.#lines.show(
      display.lines.map((line, place) => ({ ...line, place })),
      ({ place }) => place,
    );
    this.arrow.hidden = display.lines.length < 2;
    say(this.arrow, display.arrow === "clockwise" ? "↻ turn clockwise" : display.arrow === "counter-clockwise" ? "↺ turn counter-clockwise" : "no arrow");
    say(this.signs, display.signs.join(", "));
    this.#leds.show(display.leds, ({ led }) => led);
    for (const { key, pressed } of keys) mark(this.#button(key), "aria-pressed", pressed);
    for (const [key, button] of this.#keys) button.hidden = !keys.some((known) => known.key === key);
    say(this.power, power === "off" ? "Power on" : "Power off");
  }

  /** A key is held as long as the pointer or the key of the keyboard is. */
  #button(key) {
    if (this.#keys.has(key)) return this.#keys.get(key);
    let held = false;
    const hold = (pressed) => {
      if (held === pressed) return;
      held = pressed;
      this.#act.press(key, pressed);
    };
    const typed = (event, pressed) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      hold(pressed);
    };
    const button = html("button", {
      type: "button",
      "data-key": key,
      "aria-pressed": false,
      onpointerdown: (event) => {
        button.setPointerCapture(event.pointerId);
        hold(true);
      },
      onpointerup: () => hold(false),
      onpointercancel: () => hold(false),
      onkeydown: (event) => typed(event, true),
      onkeyup: (event) => typed(event, false),
      onblur: () => hold(false),
    }, KEYS[key] ?? key);
    this.#keys.set(key, button);
    this.keys.append(button);
    return button;
  }
}

/** The inputs that the node names, each with its control. */
class Surroundings {
  #act;
  #names = "";
  #controls = [];

  constructor(form, act) {
    this.#act = act;
    this.form = form;
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  show({ inputs, input_ranges: ranges }) {
    const names = ranges.map(({ input }) => input).join();
    if (names !== this.#names) {
      this.#names = names;
      const change = (input) => (value) => this.#act.change({ [input]: value });
      this.#controls = ranges.map((range) => (range.low === null ? new Switch(range, change(range.input)) : new Quantity(range, change(range.input))));
      this.form.replaceChildren(
        ...this.#controls.map(({ element }) => element),
        html("p", {}, html("button", { type: "button", onclick: () => this.#act.nominal() }, "Set all to normal")),
      );
    }
    for (const control of this.#controls) control.show(inputs[control.input]);
  }
}

class Switch {
  constructor({ input, text }, change) {
    this.input = input;
    this.box = html("input", { type: "checkbox", onchange: () => change(this.box.checked) });
    this.element = html("label", { class: "field", "data-input": input }, this.box, html("span", {}, text));
  }

  show(value) {
    this.box.checked = value;
  }
}

class Quantity {
  #changed = 0;

  constructor({ input, text, low, high, may_be_null: own }, change) {
    this.input = input;
    const set = (value) => {
      if (Number.isNaN(value)) return;
      const within = Math.min(high, Math.max(low, Math.round(value * 1e6) / 1e6));
      this.#changed = performance.now();
      this.number.value = within;
      change(within);
    };
    this.number = html("input", { type: "number", step: "any", min: low, max: high, "aria-label": text, onchange: () => set(this.number.valueAsNumber) });
    const parts = [this.number];
    if (high - low <= SLIDER_RANGE) {
      this.slider = html("input", { type: "range", min: low, max: high, step: high - low > 100 ? 0.5 : 0.05, "aria-label": text, oninput: () => set(this.slider.valueAsNumber) });
      parts.push(this.slider);
    } else {
      const step = (by) => html("button", { type: "button", "aria-label": `${text}: ${by}`, onclick: () => set((this.number.valueAsNumber || 0) + by) }, by > 0 ? `+${by}` : String(by));
      parts.push(...STEPS.map(step));
    }
    if (own) parts.push(html("button", { type: "button", class: "plain", onclick: () => change(null) }, "calculated"));
    this.element = html("div", { class: "quantity", "data-input": input }, html("span", {}, text, html("span", { class: "muted" }, ` ${input.split("_").slice(-2).join(" ")}`)), html("div", { class: "group" }, ...parts));
  }

  show(value) {
    // Who types is not disturbed.
    if (document.activeElement === this.number || performance.now() - this.#changed < SETTLE_MS) return;
    this.number.value = value ?? "";
    if (this.slider && document.activeElement !== this.slider) this.slider.value = value ?? 0;
  }
}

/** How to make each fault, and 1003h. */
class Errors {
  #provoke;
  #buttons = new Map();
  #history;

  constructor(root, provoke) {
    this.#provoke = provoke;
    this.buttons = html("div", { class: "provoke many", role: "group", "aria-label": "Provoke a fault" });
    const history = html("tbody");
    this.none = html("p", { class: "muted" }, "The error history 1003h is empty.");
    this.table = html("table", { class: "table" }, html("caption", { class: "muted" }, "Error history 1003h, newest first"), html("thead", {}, html("tr", {}, ...["Code", "Device", "Meaning"].map((name) => html("th", { scope: "col" }, name)))), history);
    root.replaceChildren(this.buttons, html("div", { class: "scroll" }, this.table), this.none);
    this.#history = new Rows(history, () => {
      const cells = ["mono", "mono", ""].map((name) => html("td", { class: name }));
      return {
        element: html("tr", {}, ...cells),
        show: ({ code, information, text }) => [`${code}h`, `${information}h`, text].forEach((value, place) => say(cells[place], value)),
      };
    });
  }

  show({ faults, emcy_history: history }) {
    for (const { fault, text, present } of faults) {
      if (!this.#buttons.has(fault)) {
        const button = html("button", { type: "button", title: text, "data-fault": fault, "aria-label": `Provoke ${fault}: ${text}`, onclick: () => this.#provoke(fault) }, fault);
        this.#buttons.set(fault, button);
        this.buttons.append(button);
      }
      mark(this.#buttons.get(fault), "aria-pressed", present);
    }
    for (const [name, button] of this.#buttons) button.hidden = !faults.some(({ fault }) => fault === name);
    this.none.hidden = history.length > 0;
    this.table.hidden = history.length === 0;
    this.#history.show(history.map((entry, place) => ({ ...entry, place })), ({ place }) => place);
  }
}

/** Each PDO with what it carries. */
class Pdos {
  #rows;

  constructor(root) {
    const body = html("tbody");
    root.replaceChildren(html("table", { class: "table" }, html("thead", {}, html("tr", {}, ...["PDO", "COB-ID", "Type", "Entry", "Value"].map((name) => html("th", { scope: "col" }, name)))), body));
    this.#rows = new Rows(body, () => {
      const cells = ["", "mono", "mono", "", "mono"].map((name) => html("td", { class: name }));
      return { element: html("tr", {}, ...cells), show: ({ values }) => values.forEach((value, place) => say(cells[place], value)) };
    });
  }

  show(pdos) {
    const rows = pdos.flatMap(({ pdo, valid, cob_id: id, transmission_type: type, entries }) => {
      const first = [pdo, valid ? `${id}h` : `${id}h off`, String(type)];
      const one = ({ object, name, bits, value }, place) => ({
        key: `${pdo} ${place}`,
        values: [...(place === 0 ? first : ["", "", ""]), `${object} ${name}`, value === null ? "" : `${value}${bits <= 16 && value >= 0 ? ` = ${hex(value, bits / 4)}h` : ""}`],
      });
      return entries.length === 0 ? [{ key: pdo, values: [...first, "nothing mapped", ""] }] : entries.map(one);
    });
    this.#rows.show(rows, ({ key }) => key);
  }
}

/** The dictionary with a filter, and a form to write one entry past the bus. */
class Objects {
  #write;
  #rows;
  #objects = [];
  #chosen = null;

  constructor(root, write) {
    this.#write = write;
    this.filter = html("input", { type: "search", placeholder: "6041, heartbeat ...", autocomplete: "off", spellcheck: "false", oninput: () => this.#update() });
    this.which = html("span", { class: "muted" }, "Choose an entry to write it.");
    this.value = html("input", { type: "text", "aria-label": "Value", disabled: true });
    this.button = html("button", { type: "submit", disabled: true }, "Write");
    this.said = html("p", { role: "status" });
    const form = html("form", { class: "form" }, this.which, this.value, this.button);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#send();
    });
    const body = html("tbody");
    root.replaceChildren(
      html("label", { class: "field" }, "Filter ", this.filter),
      html("div", { class: "scroll" }, html("table", { class: "table" }, html("thead", {}, html("tr", {}, ...["Object", "Name", "Type", "Access", "Value"].map((name) => html("th", { scope: "col" }, name)))), body)),
      form,
      this.said,
    );
    this.#rows = new Rows(body, (object) => this.#row(object));
  }

  show(objects) {
    this.#objects = objects;
    this.#update();
  }

  #row({ index, sub, name, type, access }) {
    const value = html("td", { class: "mono" });
    const label = `${index}h:${sub}`;
    const head = access === "rw" || access === "wo" ? html("button", { type: "button", class: "plain mono", onclick: () => this.#choose(index, sub, name) }, label) : html("span", { class: "mono" }, label);
    return {
      element: html("tr", { "data-object": label }, html("td", {}, head), html("td", {}, name), html("td", {}, type), html("td", {}, access), value),
      show: ({ value: now, refused }) => say(value, now === null ? "" : String(now)) ?? mark(value, "title", refused ?? ""),
    };
  }

  #update() {
    const words = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    const text = ({ index, sub, name }) => `${index}h:${sub} ${name}`.toLowerCase();
    const shown = this.#objects.filter((object) => words.every((word) => text(object).includes(word)));
    this.#rows.show(shown, ({ index, sub }) => `${index}:${sub}`);
  }

  #choose(index, sub, name) {
    this.#chosen = { index, sub };
    const now = this.#objects.find((object) => object.index === index && object.sub === sub);
    say(this.which, `${index}h:${sub} ${name}`);
    this.value.disabled = false;
    this.button.disabled = false;
    this.value.value = now?.value ?? "";
    this.value.focus();
  }

  async #send() {
    const { index, sub } = this.#chosen;
    const text = this.value.value.trim();
    // 0x is how people write hexadecimal numbers.
    const value = text !== "" && !Number.isNaN(Number(text)) ? Number(text) : text;
    try {
      const written = await this.#write(index, sub, value);
      this.said.className = "done";
      say(this.said, `${index}h:${sub} is ${written.value}`);
      this.#objects = this.#objects.map((object) => (object.index === index && object.sub === sub ? written : object));
      this.#update();
    } catch (error) {
      this.said.className = "refused";
      say(this.said, error.message);
    }
  }
}

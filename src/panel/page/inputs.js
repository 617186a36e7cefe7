// What acts on the station from outside: each input with a control for its kind, range and unit, as the station says them.
import { Rows, button, html, mark, say, typedNumber } from "./dom.js";

/** While somebody moves a slider, values are sent this often at most. */
const SEND_PAUSE_MS = 60;
/** So long after a change what the station says is not shown over it: it is still on its way. */
const SETTLE_MS = 700;
/** Over so wide a range a slider is of no use: steps are. */
const SLIDER_RANGE = 300;
const STEPS = [-1, -0.1, -0.01, 0.01, 0.1, 1];
const WHOLE_STEPS = [-10, -1, 1, 10];

export class Inputs {
  #ask;
  #outbox = {};
  #sending = false;
  #message = html("p", { class: "refused", role: "alert" });
  #form = html("form", { id: "inputs", class: "inputs", novalidate: true });
  #rows = new Rows(this.#form, (input) => this.#control(input));
  #controls = new Map();
  element = html("section", { class: "card", "aria-labelledby": "inputs-title" }, html("h3", { id: "inputs-title" }, "Inputs from outside"), this.#form, this.#message, html("p", { class: "below" }, button("Set all to normal", () => this.#nominal())));

  /** `ask(method, path, body)` brings changes to the station and rejects with a sentence if it refuses them. */
  constructor(ask) {
    this.#ask = ask;
    this.#form.addEventListener("submit", (event) => event.preventDefault());
  }

  show({ inputs }) {
    this.element.hidden = !inputs || inputs.length === 0;
    this.#rows.show(inputs ?? [], ({ input }) => input);
  }

  #control(input) {
    const change = (value) => {
      control.take({ ...control.input, value });
      this.#outbox[input.input] = value;
      this.#flush();
    };
    // Beside what was typed, where somebody looks.
    const refuse = (sentence) => {
      control.element.after(this.#message);
      say(this.#message, sentence);
    };
    const control = input.low === null || input.low === undefined ? new Toggle(input, change) : new Quantity(input, change, refuse);
    this.#controls.set(input.input, control);
    return control;
  }

  async #nominal() {
    try {
      await this.#ask("DELETE", "/inputs");
      for (const control of this.#controls.values()) control.settle();
      say(this.#message, "");
    } catch (error) {
      say(this.#message, error.message);
    }
  }

  async #flush() {
    if (this.#sending) return;
    this.#sending = true;
    while (Object.keys(this.#outbox).length > 0) {
      const changes = this.#outbox;
      this.#outbox = {};
      try {
        await this.#ask("PATCH", "/inputs", changes);
        say(this.#message, "");
      } catch (error) {
        say(this.#message, error.message);
        for (const control of this.#controls.values()) control.settle();
      }
      await new Promise((resolve) => setTimeout(resolve, SEND_PAUSE_MS));
    }
    this.#sending = false;
  }
}

/** What the controls have in common: that a change just made is not shown over. */
class Control {
  #changed = -Infinity;

  constructor(input) {
    this.input = input;
  }

  /** What the station says. */
  show(input) {
    if (performance.now() - this.#changed < SETTLE_MS) return;
    this.#mark(input);
  }

  /** What somebody has chosen. */
  take(input) {
    this.#changed = performance.now();
    this.#mark(input);
  }

  settle() {
    this.#changed = -Infinity;
  }

  #mark(input) {
    this.input = input;
    mark(this.element, "data-changed", input.nominal !== undefined && input.value !== input.nominal);
    this.display(input);
  }
}

class Toggle extends Control {
  constructor(input, change) {
    super(input);
    const id = `input-${input.input}`;
    this.button = html("button", { type: "button", class: "toggle", role: "switch", "aria-checked": false, "aria-labelledby": id, onclick: () => change(!this.input.value) });
    this.element = html("div", { class: "input", "data-input": input.input }, html("label", { id, onclick: () => this.button.click() }, input.text), this.button);
  }

  display({ value }) {
    mark(this.button, "aria-checked", Boolean(value));
  }
}

/** A number with a slider or steps; one that may be null is calculated by the device until it is given. */
class Quantity extends Control {
  constructor(input, change, refuse) {
    super(input);
    const { text, low, high, unit, step, may_be_null: own } = input;
    const id = `input-${input.input}`;
    const named = unit ? `${text}, ${unit}` : text;
    const set = (value) => {
      const within = value >= low && value <= high;
      mark(this.number, "aria-invalid", !within);
      if (within) change(value);
      else refuse(`${text} must be ${low} to ${high}${unit ? ` ${unit}` : ""}, not ${value}. Nothing is changed.`);
    };
    const typed = () => {
      try {
        const value = typedNumber(this.number.value);
        if (value !== null) set(value);
      } catch (error) {
        mark(this.number, "aria-invalid", true);
        refuse(error.message);
      }
    };
    const fine = step ?? (high - low > 100 ? 0.5 : 0.05);
    this.number = html("input", { type: "text", class: "number", inputmode: "decimal", id, autocomplete: "off", onchange: typed });
    this.range = high - low <= SLIDER_RANGE ? html("input", { type: "range", min: low, max: high, step: fine, "aria-label": named, oninput: () => set(this.range.valueAsNumber) }) : null;
    const near = (by) => Math.min(high, Math.max(low, Number(((this.input.value ?? this.input.calculated ?? 0) + by).toFixed(6))));
    const steps = (step >= 1 ? WHOLE_STEPS : STEPS).map((by) => button(by > 0 ? `+${by}` : String(by), () => set(near(by)), { "aria-label": `${text}: ${by}` }));
    this.moving = this.range ?? html("span", { class: "group steps" }, ...steps);
    this.given = html("button", { type: "button", class: "toggle", role: "switch", "aria-checked": false, "aria-label": `Give ${text}`, hidden: !own, onclick: () => change(this.input.value === null ? near(0) : null) });
    this.free = html("span", { class: "muted" }, "calculated");
    this.amount = html("span", { class: "amount" }, this.number, html("span", { class: "unit" }, unit ?? ""));
    this.element = html("div", { class: "input", "data-input": input.input }, html("label", { for: id }, text), html("span", { class: "given" }, this.free, this.amount, this.given), this.moving);
  }

  display({ value }) {
    mark(this.given, "aria-checked", value !== null);
    this.free.hidden = value !== null;
    this.amount.hidden = value === null;
    this.moving.hidden = value === null;
    if (value === null) return;
    if (this.range && document.activeElement !== this.range) this.range.value = value;
    // Who types is not disturbed.
    if (document.activeElement === this.number && this.number.getAttribute("aria-invalid") === "true") return;
    if (document.activeElement === this.number && this.number.value !== this.shown) return;
    this.shown = String(Number(value.toFixed(6)));
    this.number.value = this.shown;
    mark(this.number, "aria-invalid", false);
  }
}

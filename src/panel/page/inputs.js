// What acts on the drive from outside: supplies, load, enable, battery, temperatures, faults of its parts.
import { html, say, mark } from "./dom.js";

/** While somebody moves a slider, values are sent this often at most. */
const SEND_PAUSE_MS = 60;
/** So long after a change what the drive says is not shown over it: it is still on its way. */
const SETTLE_MS = 700;

/**
 * The controls, in the order of the page. `field` is a field of the inputs of the API; `models` are those it means
 * something for. `given` controls may be left to the drive (null) and have a value to begin with.
 */
const CONTROLS = [
  { field: "control_supply_volts", label: "Control supply", unit: "V", min: 0, max: 60, step: 0.5, normal: 24 },
  { field: "output_supply_volts", label: "Output stage supply", unit: "V", min: 0, max: 60, step: 0.5, normal: 24, models: ["ag03-1"] },
  { field: "enable", label: "Enable input", normal: true, models: ["ag03"] },
  { field: "blocked", label: "Shaft blocked", normal: false },
  { field: "load_torque_newton_metres", label: "Load, pulls clockwise", unit: "Nm", min: -10, max: 10, step: 0.1, normal: 0 },
  { field: "friction_torque_newton_metres", label: "Friction", unit: "Nm", min: 0, max: 10, step: 0.1, normal: 0 },
  { field: "battery_volts", label: "Battery", unit: "V", min: 0, max: 4, step: 0.05, normal: 3 },
  { field: "ambient_temperature_celsius", label: "Air", unit: "°C", min: -50, max: 120, step: 1, normal: 25 },
  { field: "stage_temperature_celsius", label: "Output stage temperature", unit: "°C", min: -50, max: 150, step: 1, normal: null, given: 95 },
  { field: "dc_link_volts", label: "Intermediate circuit", unit: "V", min: 0, max: 60, step: 0.5, normal: null, given: 36 },
  { field: "encoder_fault", label: "SIN/COS error of the encoder", normal: false, models: ["ag03-1"] },
  { field: "internal_fault", label: "Internal error", normal: false },
];

export class Inputs {
  #send;
  #controls = [];
  #outbox = {};
  #sending = false;
  #message = html("p", { class: "refused", role: "alert" });
  #model = null;

  /** `send(changes)` brings changed fields to the drive and rejects with a sentence if it refuses them. */
  constructor(form, send) {
    this.#send = send;
    this.form = form;
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  /** Another drive: what was refused by the last one is not said of it. */
  clear() {
    say(this.#message, "");
  }

  /** `values` are the inputs in effect. */
  show(model, values) {
    if (this.#model !== model) this.#build(model);
    for (const control of this.#controls) control.show(values[control.field]);
  }

  /** Changes fields as if somebody had moved the controls. */
  change(changes) {
    for (const control of this.#controls) if (control.field in changes) control.show(changes[control.field], true);
    Object.assign(this.#outbox, changes);
    this.#flush();
  }

  #build(model) {
    this.#model = model;
    const change = (field, value) => this.change({ [field]: value });
    // Beside what was typed, where somebody looks.
    const refuse = (sentence, element) => {
      element.after(this.#message);
      say(this.#message, sentence);
    };
    this.#controls = CONTROLS.filter(({ models }) => !models || models.includes(model)).map((control) => {
      if (control.unit === undefined) return new Toggle(control, change);
      return control.given === undefined ? new Slider(control, change, refuse) : new Override(control, change, refuse);
    });
    const nominal = () => this.change(Object.fromEntries(this.#controls.map(({ field, normal }) => [field, normal])));
    this.form.replaceChildren(
      ...this.#controls.map(({ element }) => element),
      this.#message,
      html("p", {}, html("button", { type: "button", onclick: nominal }, "Set all to normal")),
    );
  }

  async #flush() {
    if (this.#sending) return;
    this.#sending = true;
    while (Object.keys(this.#outbox).length > 0) {
      const changes = this.#outbox;
      this.#outbox = {};
      try {
        await this.#send(changes);
        say(this.#message, "");
      } catch (error) {
        say(this.#message, error.message);
        for (const control of this.#controls) control.settle();
      }
      await new Promise((resolve) => setTimeout(resolve, SEND_PAUSE_MS));
    }
    this.#sending = false;
  }
}

/** What the controls have in common: the value in effect, and that a change just made is not shown over. */
class Control {
  #changed = -Infinity;

  constructor({ field, normal }) {
    Object.assign(this, { field, normal });
  }

  show(value, byHand = false) {
    if (value === undefined) return;
    if (byHand) this.#changed = performance.now();
    else if (performance.now() - this.#changed < SETTLE_MS) return;
    mark(this.element, "data-changed", value !== this.normal);
    this.display(value);
  }

  settle() {
    this.#changed = -Infinity;
  }
}

class Slider extends Control {
  constructor(control, change, refuse) {
    super(control);
    const { field, label, unit, min, max, step } = control;
    const id = `input-${field}`;
    const changed = (source) => {
      if (source.value !== "" && source.checkValidity()) {
        mark(this.number, "aria-invalid", false);
        change(field, source.valueAsNumber);
        return;
      }
      mark(this.number, "aria-invalid", true);
      const typed = source.value === "" ? "" : `, not ${source.value}`;
      refuse(`${label} must be ${min} to ${max} ${unit}${typed}. Nothing is changed.`, this.element);
    };
    this.range = html("input", { type: "range", min, max, step, "aria-label": `${label}, ${unit}`, oninput: () => changed(this.range) });
    this.number = html("input", { type: "number", id, min, max, step: "any", onchange: () => changed(this.number) });
    this.element = html(
      "div",
      { class: "input", "data-field": field },
      html("label", { for: id }, label),
      html("span", { class: "amount" }, this.number, html("span", { class: "unit" }, unit)),
      this.range,
    );
  }

  display(value) {
    this.range.value = value;
    if (document.activeElement === this.number) return;
    this.number.value = Number(value.toFixed(3));
    mark(this.number, "aria-invalid", false);
  }
}

class Toggle extends Control {
  constructor(control, change) {
    super(control);
    const { field, label } = control;
    const id = `input-${field}`;
    this.button = html("button", { type: "button", class: "toggle", role: "switch", "aria-checked": false, "aria-labelledby": id, onclick: () => change(field, this.button.getAttribute("aria-checked") !== "true") });
    this.element = html("div", { class: "input", "data-field": field }, html("label", { id, onclick: () => this.button.click() }, label), this.button);
  }

  display(value) {
    mark(this.button, "aria-checked", value);
  }
}

/** A quantity that follows from the others unless it is given. */
class Override extends Control {
  constructor(control, change, refuse) {
    super(control);
    const { field, label, given } = control;
    this.slider = new Slider(control, change, refuse);
    this.button = html("button", { type: "button", class: "toggle", role: "switch", "aria-checked": false, "aria-label": `Give ${label}`, onclick: () => change(field, this.button.getAttribute("aria-checked") === "true" ? null : given) });
    this.free = html("span", { class: "muted" }, "calculated");
    this.element = this.slider.element;
    this.amount = this.element.querySelector(".amount");
    const head = html("span", { class: "given" }, this.free, this.amount, this.button);
    this.element.insertBefore(head, this.slider.range);
  }

  display(value) {
    mark(this.button, "aria-checked", value !== null);
    this.free.hidden = value !== null;
    this.amount.hidden = value === null;
    this.slider.range.hidden = value === null;
    if (value !== null) this.slider.display(value);
  }
}

// A module of a station: LEDs for its bits, its octets as values, and inputs that can be forced.
import { html, say, mark } from "./dom.js";

const TYPES = { unsigned8: 1, signed8: 1, unsigned16: 2, signed16: 2, unsigned32: 4, signed32: 4, float32: 4 };
/** More octets than this are shown as values only. */
const MOST_WITH_LEDS = 8;

export class ModuleCard {
  #title = html("h3");
  #octets = html("span", { class: "muted mono" });
  #act;
  #slot = null;
  #inputs;
  #outputs;

  /** `act(method, path, body)` asks the station for something. */
  constructor(act) {
    this.#act = act;
    this.#inputs = new Side("Inputs", {
      flip: (octet, bit, on) => this.#force(octet, `bit${bit}`, on ? 1 : 0),
      force: (octet, type, value) => this.#force(octet, type, value),
      release: (octet, type) => this.#act("DELETE", `inputs/${this.#slot}/${octet}/${type}`),
    });
    this.#outputs = new Side("Outputs", null);
    this.element = html("li", { class: "card module" }, html("header", {}, this.#title, this.#octets), this.#inputs.element, this.#outputs.element);
  }

  show({ slot, name, identifiers, inputs, forced, outputs }) {
    this.#slot = slot;
    mark(this.element, "data-slot", slot);
    say(this.#title, `Slot ${slot}: ${name}`);
    say(this.#octets, identifiers.map(hex).join(" "));
    this.#inputs.show(inputs, forced);
    this.#outputs.show(outputs, []);
  }

  #force(octet, type, value) {
    this.#act("PUT", `inputs/${this.#slot}/${octet}/${type}`, { value });
  }
}

/** The inputs or the outputs of a module. */
class Side {
  #name;
  #actions;
  #rows = [];
  #list = html("ul", { class: "octets" });
  #type = html("select", {}, ...Object.keys(TYPES).map((type) => html("option", { value: type }, type)));
  #octet = html("input", { type: "number", min: 0, value: 0 });
  #value = html("span", { class: "mono" });

  /** `actions` is null where nothing can be forced. */
  constructor(name, actions) {
    this.#name = name;
    this.#actions = actions;
    const as = html("label", { class: "field" }, "Octet ", this.#octet);
    const type = html("label", { class: "field" }, "as ", this.#type);
    this.element = html("section", { class: "side", "aria-label": name }, html("h4", {}, name), this.#list, html("p", { class: "value-of" }, as, type, this.#value));
    if (actions !== null) this.element.append(this.#form());
  }

  show(octets, forced) {
    this.element.hidden = octets.length === 0;
    if (this.#rows.length !== octets.length) {
      this.#rows = octets.map((_, octet) => new Octet(this.#name, octet, octets.length <= MOST_WITH_LEDS, this.#actions?.flip));
      this.#list.replaceChildren(...this.#rows.map(({ element }) => element));
      mark(this.#octet, "max", Math.max(0, octets.length - 1));
    }
    octets.forEach((value, octet) => this.#rows[octet].show(value, forced[octet] ?? 0));
    say(this.#value, valueOf(octets, this.#octet.valueAsNumber, this.#type.value));
  }

  #form() {
    const value = html("input", { type: "number", step: "any", required: true });
    const release = html("button", { type: "button", onclick: () => this.#actions.release(this.#octet.valueAsNumber, this.#type.value) }, "Release");
    const form = html("form", { class: "form" }, html("label", { class: "field" }, "Value ", value), html("span", { class: "group" }, html("button", { type: "submit" }, "Force"), release));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#actions.force(this.#octet.valueAsNumber, this.#type.value, value.valueAsNumber);
    });
    return form;
  }
}

/** An octet: its bits from 7 to 0, its value. */
class Octet {
  #leds = [];
  #value = html("span", { class: "mono" });

  constructor(name, octet, withLeds, flip) {
    const bits = withLeds ? [7, 6, 5, 4, 3, 2, 1, 0] : [];
    this.#leds = bits.map((bit) => {
      const label = `${name.slice(0, -1)} ${octet}.${bit}`;
      return flip === undefined
        ? { bit, led: html("span", { class: "led", role: "img", "aria-label": label }) }
        : { bit, led: html("button", { class: "led", type: "button", role: "switch", "aria-checked": false, "aria-label": label, onclick: ({ target }) => flip(octet, bit, target.getAttribute("data-lit") !== "true") }) };
    });
    this.element = html("li", {}, html("span", { class: "muted" }, String(octet)), html("span", { class: "leds" }, ...this.#leds.map(({ led }) => led)), this.#value);
  }

  show(value, forced) {
    for (const { bit, led } of this.#leds) {
      const lit = ((value >> bit) & 1) === 1;
      mark(led, "data-lit", lit);
      mark(led, "data-forced", ((forced >> bit) & 1) === 1);
      if (led.getAttribute("role") === "switch") mark(led, "aria-checked", lit);
    }
    say(this.#value, `${hex(value)} ${value}${forced === 0 ? "" : " F"}`);
  }
}

/** The value that begins at an octet, big-endian; "" if it does not fit. */
function valueOf(octets, octet, type) {
  const length = TYPES[type];
  if (!Number.isInteger(octet) || octet < 0 || octet + length > octets.length) return "";
  const view = new DataView(Uint8Array.from(octets).buffer, octet, length);
  const read = {
    unsigned8: () => view.getUint8(0),
    signed8: () => view.getInt8(0),
    unsigned16: () => view.getUint16(0),
    signed16: () => view.getInt16(0),
    unsigned32: () => view.getUint32(0),
    signed32: () => view.getInt32(0),
    float32: () => Number(view.getFloat32(0).toPrecision(7)),
  };
  return `= ${read[type]()}`;
}

function hex(octet) {
  return octet.toString(16).toUpperCase().padStart(2, "0");
}

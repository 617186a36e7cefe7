// Values in the octets of a module: where one begins and of which type it is, its scale and unit, and how it went.
import { Rows, button, field, html, mark, numberText, say, svg, typedNumber } from "./dom.js";

export const TYPES = { unsigned8: 1, signed8: 1, unsigned16: 2, signed16: 2, unsigned32: 4, signed32: 4, float32: 4 };
/** Samples of a spark line, and its size. */
const KEPT = 120;
const [WIDTH, HEIGHT] = [120, 24];
/** Values that are kept beside the chosen one. */
const MOST = 16;

/** The number that begins at an octet, high octet first; null if it does not fit. */
function numberOf(octets, octet, type) {
  const length = TYPES[type];
  if (!Number.isInteger(octet) || octet < 0 || octet + length > octets.length) return null;
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
  return read[type]();
}

/** The same in decimal, hexadecimal and binary; "" if it does not fit. */
function textOf(octets, octet, type) {
  const number = numberOf(octets, octet, type);
  if (number === null) return "";
  const bits = octets.slice(octet, octet + TYPES[type]);
  const hexadecimal = bits.map((value) => value.toString(16).toUpperCase().padStart(2, "0")).join("");
  return `= ${number} = ${hexadecimal}h = ${bits.map((value) => value.toString(2).padStart(8, "0")).join(" ")}b`;
}

/** How a value went: a line without axes. */
class Spark {
  #numbers = [];
  #line = svg("polyline", { fill: "none", stroke: "currentColor", "stroke-width": 1.5 });
  element = svg("svg", { class: "spark", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": "How it went" }, this.#line);

  add(number) {
    this.#numbers.push(number);
    if (this.#numbers.length > KEPT) this.#numbers.shift();
    const [low, high] = [Math.min(...this.#numbers), Math.max(...this.#numbers)];
    const y = (one) => HEIGHT - 2 - ((one - low) / (high - low || 1)) * (HEIGHT - 4);
    const step = WIDTH / (KEPT - 1);
    mark(this.#line, "points", this.#numbers.map((one, place) => `${(place * step).toFixed(1)},${y(one).toFixed(1)}`).join(" "));
    mark(this.element, "aria-label", low === high ? `always ${numberText(low)}` : `between ${numberText(low)} and ${numberText(high)}`);
  }

  clear() {
    this.#numbers = [];
  }
}

/** What was kept in this browser; nothing where it keeps nothing. */
function remembered(place) {
  try {
    const kept = JSON.parse(localStorage.getItem(place) ?? "[]");
    return Array.isArray(kept) ? kept.filter(({ type, octet }) => type in TYPES && Number.isInteger(octet)).slice(0, MOST) : [];
  } catch {
    return [];
  }
}

/** The chosen value of a module, and those that were kept, each with scale, unit and spark line. */
export class Watch {
  #place;
  #octets = [];
  #kept = [];
  #spark = new Spark();
  #type = html("select", { onchange: () => this.#chosen() }, ...Object.keys(TYPES).map((type) => html("option", { value: type }, type)));
  #octet = html("input", { type: "number", min: 0, value: 0, oninput: () => this.#chosen() });
  #scale = html("input", { type: "text", class: "number", value: "1", autocomplete: "off", oninput: () => this.#chosen() });
  #unit = html("input", { type: "text", class: "number", autocomplete: "off" });
  #value = html("span", { class: "mono" });
  #scaled = html("span", { class: "scaled" });
  #list = html("ul", { class: "kept" });
  #rows = new Rows(this.#list, (one) => this.#row(one));
  element = html(
    "div",
    {},
    html("p", { class: "value-of" }, field("Octet", this.#octet), field("as", this.#type), this.#value, field("×", this.#scale), field("Unit", this.#unit), this.#scaled, this.#spark.element, button("Keep", () => this.#keep())),
    this.#list,
  );

  /** `place` names the module, so that this browser finds again what was kept of it. */
  constructor(place) {
    this.#place = `profidrive ${place}`;
    this.#kept = remembered(this.#place);
    mark(this.#scale, "aria-label", "Scale: what one step of the value is");
  }

  get octet() {
    return this.#octet.valueAsNumber;
  }

  get type() {
    return this.#type.value;
  }

  show(octets) {
    this.#octets = octets;
    mark(this.#octet, "max", Math.max(0, octets.length - 1));
    say(this.#value, textOf(octets, this.octet, this.type));
    const { text, number } = this.#read({ octet: this.octet, type: this.type, scale: this.#scale.value, unit: this.#unit.value });
    say(this.#scaled, text);
    if (number !== null) this.#spark.add(number);
    this.#rows.show(this.#kept, ({ octet, type, scale, unit }) => `${octet} ${type} ${scale} ${unit}`);
  }

  /** A value with its scale and unit: the number, and what it is in words if that is more than the number. */
  #read({ octet, type, scale, unit }) {
    const raw = numberOf(this.#octets, octet, type);
    let factor;
    try {
      factor = typedNumber(scale) ?? 1;
    } catch (error) {
      return { number: null, text: error.message };
    }
    if (raw === null) return { number: null, text: "" };
    const number = raw * factor;
    return { number, text: factor === 1 && unit.trim() === "" ? "" : `${numberText(number)} ${unit.trim()}`.trim() };
  }

  #chosen() {
    this.#spark.clear();
    this.show(this.#octets);
  }

  #keep() {
    const one = { octet: this.octet, type: this.type, scale: this.#scale.value, unit: this.#unit.value };
    if (numberOf(this.#octets, one.octet, one.type) === null || this.#kept.length >= MOST) return;
    this.#change([...this.#kept, one]);
  }

  #change(kept) {
    this.#kept = kept;
    try {
      localStorage.setItem(this.#place, JSON.stringify(kept));
    } catch {
      // A browser that keeps nothing shows it as long as the page is open.
    }
    this.show(this.#octets);
  }

  #row(one) {
    const [value, spark] = [html("span"), new Spark()];
    const name = `octet ${one.octet} as ${one.type}`;
    const gone = button("×", () => this.#change(this.#kept.filter((other) => other !== one)), { "aria-label": `Keep ${name} no longer` });
    const element = html("li", {}, html("span", { class: "muted mono" }, name), value, spark.element, gone);
    const show = (now) => {
      const { number, text } = this.#read(now);
      say(value, text === "" ? textOf(this.#octets, now.octet, now.type) : text);
      if (number !== null) spark.add(number);
    };
    return { element, show };
  }
}

// Process data: what master and station exchange, PDO by PDO or module by module, as octets, bits and named values.
import { Rows, button, field, form, html, mark, numberText, say, typedNumber } from "./dom.js";
import { Watch } from "./watch.js";

/** More octets than this are shown as values only. */
const MOST_WITH_LEDS = 8;
/** Lines of the dialogue. */
const KEPT = 60;

export class Process {
  #list = html("ul", { class: "modules" });
  #rows;
  #release;
  #dialogue = new Dialogue();

  /** `act(method, path, body)` asks the station for something. */
  constructor(act) {
    this.#rows = new Rows(this.#list, () => new Item(act));
    this.#release = button("Release all inputs", () => act("DELETE", "/inputs"));
    const title = html("h3", { id: "process-title" }, "Process data");
    this.element = html("section", { class: "card", id: "process", "aria-labelledby": "process-title" }, html("div", { class: "toolbar" }, title, html("span", { class: "spacer" }), this.#release), this.#list, this.#dialogue.element);
  }

  show({ process, time_seconds: time, master }) {
    const items = withOutputs(process ?? [], master);
    this.element.hidden = items.length === 0;
    this.#release.hidden = !items.some(canForce);
    this.#rows.show(items, ({ key }) => key);
    for (const item of items) this.#dialogue.see(item, time);
  }
}

/** Modules with outputs get all octets of outputs, and where theirs begin, if the master in this program may send them. */
function withOutputs(items, master) {
  const places = items.filter(({ from_master: fromMaster, slot }) => fromMaster && slot !== undefined && slot !== null);
  if (!master || places.length === 0) return items;
  const all = places.flatMap(({ octets_hex: octets }) => octetsOf(octets));
  let begin = 0;
  return items.map((item) => {
    if (!places.includes(item)) return item;
    const of = { ...item, outputs: { all, begin } };
    begin += octetsOf(item.octets_hex).length;
    return of;
  });
}

/** Whether the inputs of a module may be given from here. */
function canForce({ forced_hex: forced, from_master: fromMaster, slot }) {
  return typeof forced === "string" && !fromMaster && slot !== undefined && slot !== null;
}

function octetsOf(text) {
  return (text ?? "").match(/[0-9a-f]{2}/gi)?.map((octet) => Number.parseInt(octet, 16)) ?? [];
}

class Item {
  #title = html("h4");
  #octets = html("p", { class: "mono muted" });
  #details = html("p", { class: "details" });
  #list = html("dl", { class: "entries" });
  #bits = null;
  #act;
  #outputs = null;
  #entries = new Rows(this.#list, () => entry());
  element = html("li", { class: "module" }, this.#title, this.#octets, this.#details, this.#list);

  constructor(act) {
    this.#act = act;
  }

  show(item) {
    const { key, name, from_master: fromMaster, octets_hex: octets, details, entries, forced_hex: forced, slot } = item;
    mark(this.element, "data-process", key);
    say(this.#title, `${fromMaster ? "→" : "←"} ${name}`);
    mark(this.#title, "title", fromMaster ? "from the master" : "to the master");
    say(this.#octets, octets ?? "");
    say(this.#details, details ?? "");
    this.#details.hidden = !details;
    this.#entries.show((entries ?? []).map((one, place) => ({ ...one, key: `${one.place} ${place}` })), ({ key }) => key);
    if (slot === undefined || slot === null) return;
    this.#outputs = item.outputs ?? null;
    if (this.#bits === null) {
      const send = this.#outputs && ((octet, bit, on) => this.#send(octet, bit, on));
      this.#bits = new Octets({ side: fromMaster ? "Output" : "Input", place: `${location.hash} ${key}` }, canForce(item) ? { act: this.#act, slot } : null, send);
      this.element.append(this.#bits.element);
    }
    this.#bits.show(octetsOf(octets), octetsOf(forced));
  }

  /** Has the master in this program send another bit in each cycle. */
  #send(octet, bit, on) {
    const { all, begin } = this.#outputs;
    const octets = all.map((value, place) => (place !== begin + octet ? value : on ? value | (1 << bit) : value & ~(1 << bit)));
    this.#act("POST", "/master", { act: "outputs", octets_hex: octets.map((value) => value.toString(16).padStart(2, "0")).join(" ") });
  }
}

/** A named value with where it is. */
function entry() {
  const [name, place, value] = [html("dt"), html("span", { class: "muted mono" }), html("span")];
  const element = html("div", {}, name, html("dd", {}, value, " ", place));
  const show = ({ name: text, place: where, value: now, unit, forced }) => {
    say(name, text);
    say(place, where ?? "");
    const hexadecimal = Number.isInteger(now) && now > 9 ? ` = ${now.toString(16).toUpperCase()}h` : "";
    say(value, `${numberText(now)}${unit ? ` ${unit}` : hexadecimal}${forced ? " (forced)" : ""}`);
  };
  return { element, show };
}

/** The octets of a module: a light for each bit, any of them as a value, and inputs that can be forced. */
class Octets {
  #side;
  #force;
  #sends;
  #rows = [];
  #list = html("ul", { class: "octets" });
  #watch;
  #message = html("p", { class: "refused", role: "alert" });

  /**
   * `side` is what one of them is called, `place` names the module in this browser; `force` is null where nothing can be forced;
   * `send(octet, bit, on)` sets a bit of outputs.
   */
  constructor({ side, place }, force, send = null) {
    this.#watch = new Watch(place);
    this.#side = side;
    this.#force = force;
    this.#sends = send;
    this.element = html("div", { class: "side" }, this.#list, this.#watch.element);
    if (force !== null) this.element.append(this.#form(), this.#message);
  }

  show(octets, forced) {
    this.element.hidden = octets.length === 0;
    if (this.#rows.length !== octets.length) {
      const flip = this.#sends ?? (this.#force && ((octet, bit, on) => this.#send("PUT", octet, `bit${bit}`, { value: on ? 1 : 0 })));
      this.#rows = octets.map((_, octet) => new Octet(this.#side, octet, octets.length <= MOST_WITH_LEDS, flip));
      this.#list.replaceChildren(...this.#rows.map(({ element }) => element));
    }
    octets.forEach((value, octet) => this.#rows[octet].show(value, forced[octet] ?? 0));
    this.#watch.show(octets);
  }

  #form() {
    const value = html("input", { type: "text", class: "number", inputmode: "decimal", autocomplete: "off" });
    const send = () => {
      try {
        const typed = typedNumber(value.value);
        if (typed === null) throw new RangeError("Nothing is forced: there is no value.");
        say(this.#message, "");
        this.#send("PUT", this.#watch.octet, this.#watch.type, { value: typed });
      } catch (error) {
        say(this.#message, error.message);
      }
    };
    const release = button("Release", () => this.#send("DELETE", this.#watch.octet, this.#watch.type));
    return form({}, send, field("Value", value), html("span", { class: "group" }, html("button", { type: "submit" }, "Force"), release));
  }

  #send(method, octet, type, body) {
    this.#force.act(method, `/inputs/${this.#force.slot}/${octet}/${type}`, body);
  }
}

/** An octet: its bits from 7 to 0, its value. */
class Octet {
  #leds = [];
  #value = html("span", { class: "mono" });

  constructor(side, octet, withLeds, flip) {
    this.#leds = (withLeds ? [7, 6, 5, 4, 3, 2, 1, 0] : []).map((bit) => {
      const label = `${side} ${octet}.${bit}`;
      if (!flip) return { bit, led: html("span", { class: "led", role: "img", "aria-label": label }) };
      const turn = ({ target }) => flip(octet, bit, target.getAttribute("data-lit") !== "true");
      return { bit, led: html("button", { class: "led", type: "button", role: "switch", "aria-checked": false, "aria-label": label, onclick: turn }) };
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
    say(this.#value, `${value.toString(16).toUpperCase().padStart(2, "0")}h ${value}${forced === 0 ? "" : " F"}`);
  }
}

/** What master and station say to each other beside their values, as jobs of parameters: a line when it changes. */
class Dialogue {
  #last = new Map();
  #lines = [];
  #number = 0;
  #list = html("ol", { class: "log mono", tabindex: 0, "aria-label": "Jobs and replies on the bus, newest first" });
  element = html("div", { id: "dialogue", hidden: true }, html("h4", {}, "Parameter channel"), html("p", { class: "hint" }, "Read as often as states come; faster jobs are in the telegrams."), this.#list);
  #rows = new Rows(this.#list, ({ time, from, text }) => {
    const spans = [`${time.toFixed(3)} s`, from, text].map((part, place) => html("span", { class: ["time", "kind", "text"][place] }, part));
    return { element: html("li", {}, ...spans), show: () => {} };
  });

  see({ key, from_master: fromMaster, details }, time) {
    if (!details || this.#last.get(key) === details) return;
    this.#last.set(key, details);
    this.#number += 1;
    this.#lines.unshift({ time, from: fromMaster ? "master" : "station", text: details, number: this.#number });
    this.#lines.splice(KEPT);
    this.element.hidden = false;
    this.#rows.show(this.#lines, ({ number }) => number);
  }
}

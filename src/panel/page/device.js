// What a person sees of the device and touches: display, signs, LEDs, shaft; keys, switches, supply.
import { Rows, button, html, mark, say, svg } from "./dom.js";

const STILL = matchMedia("(prefers-reduced-motion: reduce)");
/** The rhythm of an LED that tells a code by how often it blinks. */
const BLINK = { on: 250, off: 250, pause: 1250 };
/** A held key is released by the device after this, unless the page says again that it is held. */
const LEASE_MS = 1500;
const RENEW_MS = 400;
/** What is counted in turns is drawn as a shaft. */
const TURNS = "turns";

/** Whether an LED as the API describes it is lit `ms` after the sample. */
export function isLit(led, ms) {
  const { glow, blinks, on_milliseconds: on = BLINK.on, off_milliseconds: off = BLINK.off, phase_milliseconds: phase = 0 } = led;
  if (glow !== "blinking") return glow === "on";
  const pause = blinks > 0 ? (led.pause_milliseconds ?? BLINK.pause) : 0;
  const times = Math.max(blinks, 1);
  const within = (phase + ms) % (times * (on + off) + pause);
  return within < times * (on + off) && within % (on + off) < on;
}

export class Device {
  #ask;
  #act;
  #state = null;
  #seen = 0;
  #lcd = html("div", { class: "lcd", role: "img" });
  #signs = html("p", { class: "muted signs" });
  #ledList = html("ul", { class: "leds", "aria-label": "LEDs" });
  #keyList = html("div", { class: "group keys", role: "group", "aria-label": "Keys" });
  #shaft = new Shaft();
  #switches;
  #text = html("p", { class: "muted", id: "device-text" });
  #lamps = new Map();
  /** Since when an LED does what it does: `{ does, since }` by its name. */
  #rhythms = new Map();
  #lines = new Rows(this.#lcd, () => displayRow());
  #leds = new Rows(this.#ledList, ({ led }) => this.#lamp(led));
  #keys = new Rows(this.#keyList, ({ key }) => new Key(key, this.#ask));
  element = html("section", { class: "card", id: "device", "aria-labelledby": "device-title" }, html("h3", { id: "device-title" }, "The device"));

  /** `ask` and `act` send requests to the station; `act` shows what was refused. */
  constructor(ask, act) {
    this.#ask = (...of) => act(...of);
    this.#act = act;
    this.#switches = new Switches((positions) => act("PUT", "/switches", { positions }));
    this.power = button("Power off", () => this.#act("PUT", "/power", { on: this.#state?.power === "off" }));
    const face = html("div", { class: "face" }, this.#shaft.element, this.#lcd, this.#signs, this.#ledList, this.#keyList, this.#switches.element, this.#text, html("p", {}, this.power));
    this.element.append(face);
  }

  show(state) {
    this.#state = state;
    this.#seen = performance.now();
    const { display, keys, switches, power, eeprom, values, has } = state;
    const { rows = [], signs = [], leds = [] } = display ?? {};
    this.#lcd.hidden = rows.length === 0;
    mark(this.#lcd, "aria-label", `Display: ${rows.map(({ text }) => text.trim()).join(", ")}`);
    this.#lines.show(rows.map((row, place) => ({ ...row, place })), ({ place }) => place);
    say(this.#signs, signs.join(", "));
    this.#leds.show(leds, ({ led }) => led);
    for (const led of leds) this.#follow(led);
    this.#keys.show(keys ?? [], ({ key }) => key);
    this.#shaft.show((values ?? []).find(({ unit }) => unit === TURNS));
    this.#switches.show(switches);
    say(this.#text, [switches?.text, eeprom ? `EEPROM ${eeprom}` : null].filter(Boolean).join(". "));
    this.power.hidden = !(has?.power ?? power !== null);
    say(this.power, power === "off" ? "Power on" : "Power off");
    this.element.hidden = this.power.hidden && [rows, signs, leds, keys ?? []].every(({ length }) => length === 0) && !switches;
  }

  /** Nobody holds a key any more. */
  release() {
    for (const element of this.#keyList.children) element.dispatchEvent(new Event("release"));
  }

  paint() {
    for (const led of this.#state?.display?.leds ?? []) {
      // Without a phase its rhythm begins when it is first seen to have it.
      const begin = led.phase_milliseconds === undefined ? this.#rhythms.get(led.led).since : this.#seen;
      const ms = performance.now() - begin;
      // For those who want nothing to move, the text says that it blinks.
      const steady = STILL.matches && led.glow === "blinking";
      const lamp = this.#lamps.get(led.led);
      if (lamp) mark(lamp, "data-lit", steady || isLit(led, ms));
    }
  }

  #follow({ led, glow, blinks, on_milliseconds: on, off_milliseconds: off }) {
    const does = `${glow} ${blinks} ${on} ${off}`;
    if (this.#rhythms.get(led)?.does !== does) this.#rhythms.set(led, { does, since: this.#seen });
  }

  #lamp(name) {
    const lamp = html("span", { class: "lamp", "aria-hidden": "true", "data-lamp": name });
    const text = html("span");
    this.#lamps.set(name, lamp);
    const show = ({ colour, glow, blinks, on_milliseconds: on, off_milliseconds: off, text: meaning }) => {
      mark(lamp, "data-colour", colour ?? name.split(" ").at(-1));
      const without = on < off ? "flashing" : glow;
      const does = glow === "blinking" && blinks > 0 ? `blinks ${blinks} ${blinks === 1 ? "time" : "times"}` : without;
      say(text, `${name}: ${meaning ?? does}`);
    };
    return { element: html("li", {}, lamp, text), show };
  }
}

function displayRow() {
  const element = html("p", { class: "mono" });
  const show = ({ text, flashing }) => {
    say(element, text === "" ? "\u00a0" : text);
    mark(element, "data-flashing", Boolean(flashing));
  };
  return { element, show };
}

/** A key is held as long as the pointer or the key of the keyboard is, and as long as the page says so. */
class Key {
  #held = false;
  #timer = 0;
  #press;
  #sent = Promise.resolve();
  /** Requests that are not answered yet. */
  #waiting = 0;

  constructor(key, ask) {
    // One after the other: a release that overtakes its press would leave the key down.
    this.#press = (pressed) => {
      const send = () => ask("POST", "/keys", pressed ? { key, pressed, lease_milliseconds: LEASE_MS } : { key, pressed });
      this.#waiting += 1;
      this.#sent = this.#sent.then(send).finally(() => (this.#waiting -= 1));
    };
    const typed = (event, pressed) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      this.#hold(pressed);
    };
    const release = () => this.#hold(false);
    this.element = html("button", {
      type: "button",
      "data-key": key,
      "aria-pressed": false,
      onpointerdown: (event) => {
        this.element.setPointerCapture(event.pointerId);
        this.element.focus();
        this.#hold(true);
      },
      onpointerup: release,
      onpointercancel: release,
      onlostpointercapture: release,
      onkeydown: (event) => typed(event, true),
      onkeyup: (event) => typed(event, false),
      onblur: release,
      onrelease: release,
    });
  }

  show({ key, text, pressed }) {
    say(this.element, text ?? key.replaceAll("_", " "));
    mark(this.element, "aria-pressed", pressed || this.#held);
  }

  #hold(held) {
    if (this.#held === held) return;
    this.#held = held;
    clearInterval(this.#timer);
    mark(this.element, "aria-pressed", held);
    this.#press(held);
    if (held) this.#timer = setInterval(() => this.#waiting === 0 && this.#press(true), RENEW_MS);
  }
}

/** A shaft seen on its end, clockwise positive. */
class Shaft {
  #pointer = svg("path", { class: "pointer", d: "M0 -44 L7 -24 H-7 Z" });
  #text = html("span", { class: "muted" });
  #drawing = svg(
    "svg",
    { class: "shaft", viewBox: "-60 -60 120 120", role: "img", "aria-label": "Output shaft" },
    ...Array.from({ length: 24 }, (_, index) => svg("path", { class: "tick", d: `M0 -58 v${index % 6 ? 5 : 9}`, transform: `rotate(${index * 15})` })),
    svg("circle", { class: "ring", r: 48 }),
    this.#pointer,
    svg("circle", { class: "bore", r: 18 }),
  );
  element = html("p", { class: "dial" }, this.#drawing, this.#text);

  show(value) {
    this.element.hidden = typeof value?.value !== "number";
    if (this.element.hidden) return;
    mark(this.#pointer, "transform", `rotate(${((value.value % 1) * 360).toFixed(1)})`);
    say(this.#text, `${value.name}: ${value.value.toFixed(2)} turns`);
  }
}

/** Switches of the housing, as `{ positions, names }`. */
class Switches {
  #positions = [];
  #set;
  element = html("div", { class: "dip", role: "group", "aria-label": "Switches" });
  #rows = new Rows(this.element, ({ place }) => this.#toggle(place));

  constructor(set) {
    this.#set = set;
  }

  show(switches) {
    this.element.hidden = !switches;
    this.#positions = switches?.positions ?? [];
    this.#rows.show(this.#positions.map((on, place) => ({ on, place, name: switches.names?.[place] ?? `SW${place + 1}` })), ({ place }) => place);
  }

  #toggle(place) {
    const flip = () => this.#set(this.#positions.with(place, !this.#positions[place]));
    const element = html("button", { type: "button", role: "switch", class: "slider", "aria-checked": false, onclick: flip }, String(place + 1));
    const show = ({ on, name }) => {
      mark(element, "aria-checked", on);
      mark(element, "aria-label", name);
      mark(element, "title", name);
    };
    return { element, show };
  }
}

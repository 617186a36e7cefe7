// The drive as an engineer sees it: clamping ring with shaft, two LEDs, two keys, ten DIP switches.
import { svg, say, mark } from "./dom.js";

const SWITCHES = 10;
/** What the switches set, in the order of the manual (chapters 2.4, 7.8 and 7.10). */
const SWITCH_NAMES = [
  ...[1, 2, 4, 8, 16, 32, 64].map((weight, index) => `SW${index + 1}, address ${weight}`),
  "SW8, factory reset",
  "SW9, bus terminator",
  "SW10, bus terminator",
];
const KEYS = [
  { name: "clockwise", label: "Key 1, clockwise", x: 222, arrow: "M-8 3 A 8.5 8.5 0 1 1 5 7 M5 7 l6 -1 M5 7 l0 -6.5" },
  { name: "counter_clockwise", label: "Key 2, counter-clockwise", x: 284, arrow: "M8 3 A 8.5 8.5 0 1 0 -5 7 M-5 7 l-6 -1 M-5 7 l0 -6.5" },
];

export class DeviceDrawing {
  #shaft;
  #name;
  #lamps = {};
  #switches = [];
  #keys = [];
  #held = new Set();
  #actions;

  /** `actions.flip(index, on)` and `actions.key(name, pressed)` are called when somebody touches the drive. */
  constructor(root, actions) {
    this.#actions = actions;
    root.replaceChildren(this.#draw());
    // A finger that leaves the window has left the key.
    for (const leaving of ["blur", "pagehide"]) window.addEventListener(leaving, () => this.releaseKeys());
    document.addEventListener("visibilitychange", () => document.hidden && this.releaseKeys());
  }

  /**
   * `name` is printed on the housing, `switches` are ten booleans, `keys` the names of the keys held, `shaft` the
   * turns of the output shaft, clockwise positive as seen on the clamping ring.
   */
  show({ name, switches, keys, shaft }) {
    say(this.#name, name);
    switches.forEach((on, index) => {
      mark(this.#switches[index], "aria-checked", on);
      this.#switches[index].classList.toggle("on", on);
    });
    for (const key of this.#keys) {
      const held = keys.includes(key.dataset.name) || this.#held.has(key.dataset.name);
      mark(key, "aria-pressed", held);
    }
    mark(this.#shaft, "transform", `rotate(${((shaft % 1) * 360).toFixed(2)})`);
  }

  /** Lights the lamps; `status` and `bus` are booleans, the texts say what they tell over time. */
  light({ status, bus, statusText, busText }) {
    const lamps = [["status", status, statusText], ["bus", bus, busText]];
    for (const [name, lit, text] of lamps) {
      this.#lamps[name].lamp.classList.toggle("lit", lit);
      mark(this.#lamps[name].lamp, "data-lit", lit);
      say(this.#lamps[name].text, text);
    }
  }

  /** Nobody holds a key any more. */
  releaseKeys() {
    for (const name of [...this.#held]) this.#press(name, false);
  }

  #press(name, pressed) {
    if (this.#held.has(name) === pressed) return;
    if (pressed) this.#held.add(name);
    else this.#held.delete(name);
    const key = this.#keys.find((key) => key.dataset.name === name);
    mark(key, "aria-pressed", pressed);
    this.#actions.key(name, pressed);
  }

  #draw() {
    this.#name = svg("text", { class: "plate", x: 190, y: 64 });
    return svg(
      "svg",
      { class: "device", viewBox: "0 0 344 344", role: "group", "aria-label": "The drive" },
      ...[70, 150, 230].map((x) => svg("path", { class: "connector", d: `M${x} 22 v-14 h44 v14 m-38 0 v-10 m8 10 v-10 m8 10 v-10 m8 10 v-10 m8 10 v-10` })),
      svg("rect", { class: "housing", x: 8, y: 22, width: 328, height: 216, rx: 12 }),
      this.#drawShaft(),
      this.#name,
      this.#drawLamp("status", "Status LED, green", 96),
      this.#drawLamp("bus", "Bus LED, orange", 130),
      svg("path", { class: "groove", d: "M190 152 H322" }),
      ...KEYS.map((key) => this.#drawKey(key)),
      this.#drawSwitches(),
    );
  }

  #drawShaft() {
    this.#shaft = svg(
      "g",
      { class: "shaft" },
      svg("circle", { class: "bore", r: 42 }),
      svg("path", { class: "feather", d: "M-5 -42 v-8 h10 v8" }),
      svg("path", { class: "pointer", d: "M0 -38 L6 -23 H-6 Z" }),
      svg("circle", { class: "hollow", r: 18 }),
    );
    const ticks = Array.from({ length: 24 }, (_, index) =>
      svg("path", { class: "tick", d: `M0 -78 v${index % 6 ? 5 : 9}`, transform: `rotate(${index * 15})` }),
    );
    return svg(
      "g",
      { transform: "translate(96 130)" },
      ...ticks,
      svg("circle", { class: "ring", r: 64 }),
      svg("path", { class: "screw", d: "M57 -9 h12 a4 4 0 0 1 4 4 v10 a4 4 0 0 1 -4 4 h-12" }),
      this.#shaft,
    );
  }

  #drawLamp(name, label, y) {
    const lamp = svg("circle", { class: `lamp ${name}`, cx: 198, cy: y, r: 7, "data-lamp": name });
    const text = svg("text", { class: "value", x: 213, y: y + 13 });
    this.#lamps[name] = { lamp, text };
    return svg("g", { role: "img", "aria-label": label }, lamp, svg("text", { x: 213, y: y - 1 }, label), text);
  }

  #drawKey({ name, label, x, arrow }) {
    const button = svg(
      "g",
      { class: "key", transform: `translate(${x} 188)`, role: "button", tabindex: 0, "aria-pressed": false, "aria-label": label, "data-name": name },
      svg("rect", { class: "focus", x: -25, y: -25, width: 50, height: 50, rx: 12 }),
      svg("circle", { class: "cap", r: 20 }),
      svg("path", { class: "arrow", d: arrow }),
      svg("text", { class: "number", y: 38 }, label.slice(4, 5)),
    );
    const press = (pressed) => this.#press(name, pressed);
    button.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      button.focus();
      button.setPointerCapture(event.pointerId);
      press(true);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) {
      button.addEventListener(end, () => press(false));
    }
    button.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      press(true);
    });
    button.addEventListener("keyup", (event) => {
      if (event.key === " " || event.key === "Enter") press(false);
    });
    this.#keys.push(button);
    return button;
  }

  #drawSwitches() {
    const switches = SWITCH_NAMES.map((name, index) => this.#drawSwitch(name, index));
    return svg(
      "g",
      { role: "group", "aria-label": "DIP switches" },
      svg("rect", { class: "dip", x: 8, y: 256, width: 328, height: 80, rx: 8 }),
      svg("text", { class: "legend", x: 18, y: 279 }, "ON"),
      ...switches,
    );
  }

  #drawSwitch(name, index) {
    const width = 28;
    const toggle = () => this.#actions.flip(index, element.getAttribute("aria-checked") !== "true");
    const element = svg(
      "g",
      { class: "switch", transform: `translate(${48 + index * width} 262)`, role: "switch", tabindex: 0, "aria-checked": false, "aria-label": name, onclick: toggle },
      svg("rect", { class: "focus", x: 0, y: -1, width, height: 70, rx: 5 }),
      svg("rect", { class: "slot", x: 7, y: 4, width: 14, height: 44, rx: 3 }),
      svg("rect", { class: "slider", x: 8, y: 27, width: 12, height: 20, rx: 2 }),
      svg("text", { x: width / 2, y: 63 }, String(index + 1)),
    );
    element.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      if (!event.repeat) toggle();
    });
    this.#switches.push(element);
    return element;
  }
}

/** Ten switches as text, in the groups of their meaning: `1010000 0 00`. */
export function switchesText(switches) {
  const digits = switches.map((on) => (on ? "1" : "0")).join("");
  return `${digits.slice(0, 7)} ${digits.slice(7, 8)} ${digits.slice(8, SWITCHES)}`;
}

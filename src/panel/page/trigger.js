// The trigger of the timeline: a value that passes a level, or an event with some words, and the curves stand around it.
import { field, html, mark, numberText, say, typedNumber } from "./dom.js";
import { hasWords, wordsOf } from "./lines.js";

const KINDS = [
  ["off", "off"],
  ["rises", "value rises above"],
  ["falls", "value falls below"],
  ["event", "event with"],
];

export class Trigger {
  #kind = html("select", { onchange: () => this.arm() }, ...KINDS.map(([value, name]) => html("option", { value }, name)));
  #value = html("select", { "aria-label": "Value of the trigger", onchange: () => this.arm() });
  #level = html("input", { type: "text", class: "number", value: "0", inputmode: "decimal", autocomplete: "off", "aria-label": "Level of the trigger", oninput: () => this.arm() });
  #words = html("input", { type: "text", placeholder: "fault, travel started ...", autocomplete: "off", spellcheck: "false", "aria-label": "Words of the event", oninput: () => this.arm() });
  #said = html("span", { class: "muted", role: "status" });
  #again = html("button", { type: "button", hidden: true, onclick: () => this.arm() }, "Arm again");
  #lanes = "";
  #armed = false;
  #before = null;
  element = html("span", { class: "group trigger" }, field("Trigger", this.#kind), this.#value, this.#level, this.#words, this.#again, this.#said);

  /** `hit(time, text)` is called once when it is armed and what it waits for happens; `begin()` when it is armed. */
  constructor({ hit, begin }) {
    this.hit = hit;
    this.begin = begin;
    this.arm();
  }

  /** Waits for what is chosen. What is no number or says nothing is waited for in vain, and says so. */
  arm() {
    const kind = this.#kind.value;
    const ofValue = kind === "rises" || kind === "falls";
    this.#value.hidden = this.#level.hidden = !ofValue;
    this.#words.hidden = kind !== "event";
    this.#again.hidden = true;
    this.#before = null;
    const missing = this.#missing(kind);
    this.#armed = kind !== "off" && missing === "";
    mark(this.#said, "class", missing === "" ? "muted" : "refused");
    say(this.#said, this.#armed ? "armed" : missing);
    if (this.#armed) this.begin();
  }

  #missing(kind) {
    if (kind === "event") return wordsOf(this.#words.value).length === 0 ? "Which words?" : "";
    if (kind === "off") return "";
    try {
      return typedNumber(this.#level.value) === null ? "Which level?" : "";
    } catch {
      return `'${this.#level.value}' is no number`;
    }
  }

  /** The values that there are, as lanes of the curves. */
  offer(lanes) {
    const offered = lanes.map(({ key, name, unit }) => `${key} ${name} ${unit}`).join();
    if (this.#lanes === offered) return;
    this.#lanes = offered;
    this.#value.replaceChildren(...lanes.map(({ key, name, unit }) => html("option", { value: key }, unit ? `${name}, ${unit}` : name)));
  }

  /** A sample. The first one after it is armed only says on which side of the level the value is. */
  see({ time_s, values }) {
    if (!this.#armed || this.#value.hidden) return;
    const now = values[this.#value.value];
    if (typeof now !== "number") return;
    const [level, before] = [typedNumber(this.#level.value), this.#before];
    this.#before = now;
    const passed = this.#kind.value === "rises" ? before <= level && now > level : before >= level && now < level;
    if (before !== null && passed) this.#fire(time_s, `${this.#value.selectedOptions[0].textContent}: ${numberText(now)}`);
  }

  /** Something that happened. */
  happened(line) {
    if (this.#armed && !this.#words.hidden && line.time_s !== null && hasWords(line, wordsOf(this.#words.value))) this.#fire(line.time_s, line.text);
  }

  #fire(time, text) {
    this.#armed = false;
    this.#again.hidden = false;
    say(this.#said, `triggered at ${time.toFixed(3)} s: ${text}`);
    this.hit(time, text);
  }
}

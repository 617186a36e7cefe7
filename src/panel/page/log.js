// Events and refusals in words. Telegrams have a list of their own: however many come, no event is pushed out.
import { html } from "./dom.js";
import { Lines } from "./lines.js";

/** What can be shown, in the order of the choice. */
const CHOICES = [
  ["all", "all events"],
  ["trouble", "faults and refusals"],
];
const TROUBLE = ["fault", "refusal", "lost"];

export class Log {
  #lines;
  #choice = "all";

  constructor(root) {
    const choice = html("select", { onchange: () => this.#choose(choice.value) }, ...CHOICES.map(([value, name]) => html("option", { value }, name)));
    this.#lines = new Lines(root, {
      label: "Events",
      placeholder: "fault, -parameter ...",
      tools: [html("label", { class: "field" }, "Show ", choice)],
      wanted: ({ kind }) => this.#choice === "all" || TROUBLE.includes(kind),
    });
  }

  only(station) {
    this.#lines.only(station);
  }

  /** A line as `Lines` has it; kinds are refusal, fault, hint, dp, drive, power, line, lost. */
  add(line) {
    this.#lines.add(line);
  }

  /** Lines of before, by their `number`. */
  merge(lines) {
    if (lines.length > 0) this.#lines.merge(lines);
  }

  /** The emulator was started again: its events are numbered anew. */
  beginAnew() {
    this.#lines.forgetNumbers();
  }

  paint() {
    this.#lines.paint();
  }

  #choose(choice) {
    this.#choice = choice;
    this.#lines.again();
  }
}

// Events and refusals in words. Telegrams have a list of their own: however many come, no event is pushed out.
import { field, html } from "./dom.js";
import { Lines } from "./lines.js";

/** What can be shown, in the order of the choice. */
const CHOICES = [
  ["all", "all events"],
  ["trouble", "faults and refusals"],
];
const TROUBLE = ["fault", "refusal", "lost"];

export class Log extends Lines {
  /** `onPoint(time)` is called when somebody chooses an event. */
  constructor(root, onPoint) {
    const choice = html("select", { onchange: () => this.again() }, ...CHOICES.map(([value, name]) => html("option", { value }, name)));
    super(root, {
      label: "Events",
      placeholder: "fault, -parameter ...",
      tools: [field("Show", choice)],
      onPoint,
      wanted: ({ kind }) => choice.value === "all" || TROUBLE.includes(kind),
    });
  }

  /** The emulator was started again: its events are numbered anew. */
  beginAnew() {
    this.forgetNumbers();
    this.add({ time_s: null, kind: "line", text: "the emulator was started again; its time begins at 0", stations: [] });
  }
}

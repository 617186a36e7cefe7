// Why the station does not move: conditions that are not met now, the way out of a fault, and the last request it refused.
import { html, say, mark, Rows } from "./dom.js";
import { copyButton } from "./copy.js";
import { faultText } from "./states.js";

export class Why {
  #title = html("h3", { id: "why-title" });
  #list = html("ul", { id: "why-reasons" });
  #next = html("span", { id: "why-next" });
  #command = null;
  #copyWords = copyButton("Copy the words", "Copy the words to send", () => wordsOf(this.#next.textContent).join(" "));
  #copyCommand = copyButton("Copy the command", "Copy the command of profidrive master", () => this.#command ?? "");
  #way = html("p", { id: "why-way", class: "way" }, this.#next, " ", this.#copyWords, " ", this.#copyCommand);
  #refused = html("p", { id: "why-refused", class: "last-refusal" });
  #reasons = new Rows(this.#list, () => {
    const element = html("li");
    return { element, show: ({ text }) => say(element, text) };
  });
  element = html("section", { id: "why", class: "why", "aria-labelledby": "why-title", hidden: true }, this.#title, this.#list, this.#way, this.#refused);

  show(state) {
    const { why, last_refusal: refusal, fault } = state;
    // A device that cannot move has no reason not to.
    this.element.hidden = !fault && !refusal && (!why || (why.moving === null && !why.services?.length));
    if (this.element.hidden) return;
    const services = why?.services ?? [];
    const reasons = [...(why?.moving && !fault ? [] : (why?.reasons ?? [])), ...services];
    mark(this.element, "data-kind", fault ? "fault" : !why || (!why.moving && reasons.length > 0) ? "waiting" : "ready");
    say(this.#title, title(state));
    this.#reasons.show(reasons, ({ text }) => text);
    say(this.#next, why?.next ? `Next: ${why.next}` : "");
    this.#offer();
    say(this.#refused, refusal ? `Last refusal${ago(state, refusal)}: ${refusal.text}` : "");
  }

  /** The command of a terminal that does what comes next; null: there is none. */
  advise(command) {
    this.#command = command;
    this.#offer();
  }

  #offer() {
    const advised = this.#next.textContent !== "";
    this.#way.hidden = !advised;
    this.#copyWords.hidden = wordsOf(this.#next.textContent).length === 0;
    this.#copyCommand.hidden = !advised || !this.#command;
    mark(this.#copyCommand, "title", this.#command ?? "");
  }

  /** Nothing but a sentence: there is no such station. */
  refuse(sentence) {
    this.element.hidden = false;
    mark(this.element, "data-kind", "fault");
    say(this.#title, sentence);
    this.#reasons.show([], () => "");
    for (const line of [this.#next, this.#refused]) say(line, "");
    this.#offer();
  }
}

/** The control words in an advice: four digits each, and no index of an object. */
function wordsOf(advice) {
  return advice.match(/\b(?!60[0-9A-F]{2}h)[0-9A-F]{4}(?=h?\b)/g) ?? [];
}

function title({ why, fault, faults, state_text: word }) {
  if (fault) {
    const known = (faults ?? []).find((one) => one.fault === fault.fault);
    const cause = known === undefined ? "" : known.present ? " Its cause is still present." : " Its cause is gone.";
    return `Fault ${faultText(fault)}.${cause}`;
  }
  if (!why || why.moving === null) return why?.services?.length ? "Services of DP-V1" : "It refused a request";
  if (why.moving) return `It moves${word ? `: ${word}` : ""}`;
  return why.reasons.length === 0 ? "Ready: nothing keeps it from moving" : "It does not move, because";
}

function ago({ time_seconds: now }, { time_seconds: then }) {
  if (then === undefined) return "";
  const seconds = Math.max(0, Math.round(now - then));
  return seconds < 60 ? `, ${seconds} s ago` : `, ${Math.round(seconds / 60)} min ago`;
}

// Telegrams, events and refusals in words, newest at the bottom, with a filter.
import { html, say } from "./dom.js";

const KEPT = 1000;
/** What can be shown, in the order of the choice. */
const KINDS = [
  ["all", "everything"],
  ["no telegrams", "events"],
  ["telegram", "telegrams"],
  ["refusal", "refusals"],
];

export class Log {
  #lines = [];
  #paused = false;
  #choice = "no telegrams";
  #words = [];
  #station = null;
  #pending = [];
  #onChoice;

  /** `onChoice(telegrams)` is called when telegrams are wanted or not any more. */
  constructor(root, onChoice) {
    this.#onChoice = onChoice;
    this.list = html("ol", { class: "log mono", tabindex: 0, "aria-label": "Telegrams and events, newest last" });
    const kind = html("select", { onchange: () => this.#choose(kind.value) }, ...KINDS.map(([value, name]) => html("option", { value, selected: value === this.#choice }, name)));
    const filter = html("input", { type: "search", placeholder: "Set_Prm, -Data_Exchange ...", autocomplete: "off", spellcheck: "false", oninput: () => this.#filter(filter.value) });
    this.pause = html("button", { type: "button", "aria-pressed": false, onclick: () => this.#pause() }, "Pause");
    this.count = html("span", { class: "muted" });
    root.replaceChildren(
      html(
        "div",
        { class: "toolbar" },
        html("label", { class: "field" }, "Show ", kind),
        html("label", { class: "field" }, "Filter ", filter),
        this.pause,
        html("button", { type: "button", onclick: () => this.#clear() }, "Clear"),
        html("span", { class: "spacer" }),
        this.count,
      ),
      this.list,
    );
  }

  get wantsTelegrams() {
    return this.#choice === "all" || this.#choice === "telegram";
  }

  /** Only what concerns one station, or `null` for all. */
  only(station) {
    if (this.#station === station) return;
    this.#station = station;
    this.#again();
  }

  /** A line `{ time_s, kind, text, station, bad }`; kinds are telegram, refusal, fault, dp, power, line, lost. */
  add(line) {
    this.#lines.push(line);
    if (this.#lines.length > 2 * KEPT) this.#lines.splice(0, KEPT);
    if (this.#matches(line)) this.#pending.push(line);
    if (this.#pending.length > KEPT) this.#pending.splice(0, this.#pending.length - KEPT);
  }

  /** Puts the new lines into the document. */
  paint() {
    if (this.#paused) {
      say(this.count, this.#pending.length === 0 ? "" : `${this.#pending.length} more`);
      return;
    }
    if (this.#pending.length === 0 || this.list.offsetParent === null) return;
    const atEnd = this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < 30;
    this.list.append(...this.#pending.map(row));
    this.#pending = [];
    while (this.list.childElementCount > KEPT) this.list.firstElementChild.remove();
    if (atEnd) this.list.scrollTop = this.list.scrollHeight;
    say(this.count, `${this.list.childElementCount} lines`);
  }

  #choose(choice) {
    const before = this.wantsTelegrams;
    this.#choice = choice;
    this.#again();
    if (before !== this.wantsTelegrams) this.#onChoice(this.wantsTelegrams);
  }

  #filter(text) {
    this.#words = text.toLowerCase().split(/\s+/).filter(Boolean);
    this.#again();
  }

  #pause() {
    this.#paused = !this.#paused;
    this.pause.setAttribute("aria-pressed", this.#paused);
    this.paint();
  }

  #clear() {
    this.#lines = [];
    this.#again();
  }

  #again() {
    this.list.replaceChildren();
    this.#pending = this.#lines.filter((line) => this.#matches(line)).slice(-KEPT);
    say(this.count, "0 lines");
    this.paint();
  }

  #matches(line) {
    if (this.#station !== null && line.station !== null && line.station !== this.#station) return false;
    if (this.#choice === "no telegrams" && line.kind === "telegram") return false;
    if (["telegram", "refusal"].includes(this.#choice) && line.kind !== this.#choice) return false;
    const text = `${line.kind} ${line.station ?? ""} ${line.text}`.toLowerCase();
    return this.#words.every((word) => (word.length > 1 && word.startsWith("-") ? !text.includes(word.slice(1)) : text.includes(word)));
  }
}

function row({ time_s, kind, text, station, bad }) {
  const who = station === null ? kind : `${kind} ${station}`;
  return html(
    "li",
    { "data-kind": kind, "data-bad": Boolean(bad) },
    html("span", { class: "time" }, time_s === null ? "" : `${time_s.toFixed(3)} s`),
    html("span", { class: "kind" }, who),
    html("span", { class: "text" }, text),
  );
}

// Telegrams, events and refusals in words, newest at the bottom, with a filter.
import { html, many, say } from "./dom.js";

const KEPT = 1000;
/** What can be shown, in the order of the choice. */
const KINDS = [
  ["all", "everything"],
  ["no telegrams", "events"],
  ["telegram", "telegrams"],
  ["refusal", "refusals"],
];
/** The address of a telegram to all stations. */
const BROADCAST = 127;

export class Log {
  #lines = [];
  #paused = false;
  #choice = "no telegrams";
  #words = [];
  #station = null;
  #pending = [];
  #onChoice;

  /** `onChoice(telegrams)` is called when telegrams are wanted or not any more; `named` is what the bus calls them. */
  constructor(root, onChoice, named = "telegrams", placeholder = "Set_Prm, -Data_Exchange ...") {
    this.#onChoice = onChoice;
    const call = (name) => (name === "telegrams" ? named : name);
    this.list = html("ol", { class: "log mono", tabindex: 0, "aria-label": `${named[0].toUpperCase()}${named.slice(1)} and events, newest last` });
    const kind = html("select", { onchange: () => this.#choose(kind.value) }, ...KINDS.map(([value, name]) => html("option", { value, selected: value === this.#choice }, call(name))));
    const filter = html("input", { type: "search", placeholder, autocomplete: "off", spellcheck: "false", oninput: () => this.#filter(filter.value) });
    this.pause = html("button", { type: "button", "aria-pressed": false, onclick: () => this.#pause() }, "Pause");
    this.count = html("span", { class: "muted" });
    this.nothing = html("p", { class: "muted nothing" }, "nothing yet");
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
      this.nothing,
    );
    this.#empty();
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

  /**
   * A line `{ time_s, kind, word, text, stations, bad }`; `word` is what a telegram is called; kinds are telegram, refusal, fault, hint, dp, power, line, lost; `stations`
   * are those it is of, none if it concerns all.
   */
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
    if (this.#pending.length === 0 || this.pause.offsetParent === null) return;
    this.list.hidden = false;
    const atEnd = this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < 30;
    this.list.append(...this.#pending.map(row));
    this.#pending = [];
    while (this.list.childElementCount > KEPT) this.list.firstElementChild.remove();
    if (atEnd) this.list.scrollTop = this.list.scrollHeight;
    say(this.count, many(this.list.childElementCount, "line"));
    this.#empty();
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
    say(this.count, many(0, "line"));
    this.#empty();
    this.paint();
  }

  /** An empty list says that it is one. */
  #empty() {
    this.list.hidden = this.list.childElementCount === 0;
    this.nothing.hidden = !this.list.hidden;
    say(this.nothing, this.#lines.length === 0 ? "nothing yet" : "nothing matches");
  }

  #matches(line) {
    const concerned = line.stations.length === 0 || line.stations.some((station) => station === this.#station || station === BROADCAST);
    if (this.#station !== null && !concerned) return false;
    if (this.#choice === "no telegrams" && line.kind === "telegram") return false;
    if (["telegram", "refusal"].includes(this.#choice) && line.kind !== this.#choice) return false;
    const text = `${who(line)} ${line.text}`.toLowerCase();
    return this.#words.every((word) => (word.length > 1 && word.startsWith("-") ? !text.includes(word.slice(1)) : text.includes(word)));
  }
}

/** The kind of a line and the station; a telegram itself says whose it is. */
function who({ kind, word, stations }) {
  return kind === "telegram" ? (word ?? kind) : [kind, ...stations].join(" ");
}

function row(line) {
  const { time_s, kind, text, bad } = line;
  return html(
    "li",
    { "data-kind": kind, "data-bad": Boolean(bad) },
    html("span", { class: "time" }, time_s === null ? "" : `${time_s.toFixed(3)} s`),
    html("span", { class: "kind" }, who(line)),
    html("span", { class: "text" }, text),
  );
}

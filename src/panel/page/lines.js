// A list of lines, newest at the bottom, with a filter, a pause and a count.
import { isSame } from "./api.js";
import { html, many, mark, say } from "./dom.js";

/** Lines in the document. */
const SHOWN = 1000;
/** The address of a telegram to all stations. */
const BROADCAST = 127;

export class Lines {
  #lines = [];
  #words = [];
  #station = null;
  #pending = [];
  /** The number of the newest line, and of the newest that is shown while the list stands. */
  #newest = 0;
  #until = Infinity;
  #wanted;
  #kept;
  /** The line that somebody has chosen, or that is nearest to what was chosen elsewhere. */
  #pointed = null;

  /**
   * `label` names the list for those who do not see it, `tools` stand before the filter, `wanted(line)` says whether to
   * show a line, `kept` is how many are kept, `onPoint(time)` is called when somebody chooses a line.
   */
  constructor(root, { label, placeholder, tools = [], wanted, kept = SHOWN, onPoint = () => {} }) {
    this.#wanted = wanted;
    this.#kept = kept;
    this.list = html("ol", { class: "log mono", tabindex: 0, "aria-label": `${label}, newest last` });
    const choose = (item) => {
      if (!item?.dataset.time) return;
      this.point(Number(item.dataset.time), item);
      onPoint(Number(item.dataset.time));
    };
    this.list.addEventListener("click", ({ target }) => getSelection().isCollapsed && choose(target.closest("li")));
    this.list.addEventListener("keydown", (event) => {
      const step = { ArrowUp: "previousElementSibling", ArrowDown: "nextElementSibling" }[event.key];
      if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      choose(this.#pointed?.isConnected ? this.#pointed[step] : this.list.lastElementChild);
    });
    const filter = html("input", { type: "search", placeholder, autocomplete: "off", spellcheck: "false", oninput: () => this.#filter(filter.value) });
    this.pause = html("button", { type: "button", "aria-pressed": false, onclick: () => this.#pause() }, "Pause");
    this.count = html("span", { class: "muted" });
    this.nothing = html("p", { class: "muted nothing" }, "nothing yet");
    root.replaceChildren(
      html(
        "div",
        { class: "toolbar" },
        ...tools,
        html("label", { class: "field" }, "Filter ", filter),
        this.pause,
        html("button", { type: "button", onclick: () => this.clear() }, "Clear"),
        html("span", { class: "spacer" }),
        this.count,
      ),
      this.list,
      this.nothing,
    );
    this.#empty();
  }

  /** Only what concerns one station, or `null` for all. */
  only(station) {
    if (isSame(this.#station, station)) return;
    this.#station = station;
    this.again();
  }

  /**
   * A line `{ time_s, kind, word, text, line, stations, bad }`: `time_s` is null if it has none, `word` is what a telegram
   * is called, `stations` are the addresses on the line it is of, none if it concerns all.
   */
  add(line) {
    this.#newest += 1;
    const numbered = { ...line, place: this.#newest };
    this.#lines.push(numbered);
    if (this.#lines.length > 2 * this.#kept) this.#lines.splice(0, this.#kept);
    if (this.#matches(numbered)) this.#pending.push(numbered);
    if (this.#pending.length > SHOWN) this.#pending.splice(0, this.#pending.length - SHOWN);
  }

  /** Puts lines with a `number` where they belong among those that are there. */
  merge(lines) {
    for (const line of lines) {
      const before = this.#lines.findLastIndex(({ number }) => number !== undefined && number < line.number);
      this.#lines.splice(before + 1, 0, { ...line, place: this.#lines[before]?.place ?? 0 });
    }
    this.again();
  }

  /** The lines that are there are older than all that come; their numbers mean nothing any more. */
  forgetNumbers() {
    for (const line of this.#lines) delete line.number;
  }

  /** Shows the newest line until `time`, or `item`; null: none. */
  point(time, item = null) {
    this.#pointed?.removeAttribute("aria-current");
    this.#pointed = item;
    if (time === null) return;
    for (const line of item ? [] : this.list.children) if (line.dataset.time && Number(line.dataset.time) <= time) this.#pointed = line;
    if (this.#pointed === null) return;
    mark(this.#pointed, "aria-current", true);
    // The list scrolls, the page stays where it is.
    const { offsetTop: top, offsetHeight: height } = this.#pointed;
    const { scrollTop, clientHeight, offsetTop: first } = this.list;
    if (top - first < scrollTop || top - first + height > scrollTop + clientHeight) this.list.scrollTop = top - first - clientHeight / 2;
  }

  /** The lines that are shown, for a report. */
  get shown() {
    return this.#lines.filter((line) => this.#matches(line));
  }

  clear() {
    this.#lines = [];
    this.again();
  }

  /** Chooses anew what is shown; of a list that stands, from the lines it had when it was stopped. */
  again() {
    const matching = this.#lines.filter((line) => this.#matches(line));
    const shown = matching.filter(({ place }) => place <= this.#until);
    this.#pending = matching.filter(({ place }) => place > this.#until).slice(-SHOWN);
    this.list.replaceChildren(...shown.slice(-SHOWN).map(row));
    this.#empty();
    this.list.scrollTop = this.list.scrollHeight;
    say(this.count, many(this.list.childElementCount, "line"));
  }

  /** Puts the new lines into the document. */
  paint() {
    if (this.#until !== Infinity) {
      say(this.count, this.#pending.length === 0 ? "" : `${this.#pending.length} more`);
      return;
    }
    if (this.#pending.length === 0 || this.pause.offsetParent === null) return;
    this.list.hidden = false;
    const atEnd = this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < 30;
    this.list.append(...this.#pending.map(row));
    this.#pending = [];
    while (this.list.childElementCount > SHOWN) this.list.firstElementChild.remove();
    if (atEnd) this.list.scrollTop = this.list.scrollHeight;
    say(this.count, many(this.list.childElementCount, "line"));
    this.#empty();
  }

  #filter(text) {
    this.#words = wordsOf(text);
    this.again();
  }

  #pause() {
    this.#until = this.#until === Infinity ? this.#newest : Infinity;
    this.pause.setAttribute("aria-pressed", this.#until !== Infinity);
    this.paint();
  }

  /** An empty list says that it is one. */
  #empty() {
    this.list.hidden = this.list.childElementCount === 0;
    this.nothing.hidden = !this.list.hidden;
    say(this.nothing, this.#lines.length === 0 ? "nothing yet" : "nothing matches");
  }

  #matches(line) {
    return (this.#station === null || concerns(line, this.#station)) && this.#wanted(line) && hasWords(line, this.#words);
  }
}

/** Whether a line is of a station: what is of a whole line is of each of its stations. */
function concerns({ line, stations }, station) {
  if (line !== null && line !== undefined && line !== station.line) return false;
  return stations.length === 0 || stations.some((address) => address === station.address || address === BROADCAST);
}

/** What to look for: words that must be in a line, with - before them words that must not. 0x6041 finds 6041h. */
export function wordsOf(text) {
  return text.toLowerCase().split(/\s+/).filter(Boolean).map((word) => word.replace(/^(-?)0x(?=[0-9a-f]+$)/, "$1"));
}

export function hasWords(line, words) {
  const text = `${who(line)} ${line.text}`.toLowerCase();
  return words.every((word) => (word.length > 1 && word.startsWith("-") ? !text.includes(word.slice(1)) : text.includes(word)));
}

/** The kind of a line and the station; a telegram itself says whose it is. */
function who({ kind, word, stations }) {
  return kind === "telegram" ? (word ?? kind) : [kind, ...stations].join(" ");
}

function row(line) {
  const { time_s, kind, text, bad } = line;
  return html(
    "li",
    { "data-kind": kind, "data-bad": Boolean(bad), "data-time": time_s ?? undefined },
    html("span", { class: "time" }, time_s === null ? "" : `${time_s.toFixed(3)} s`),
    html("span", { class: "kind" }, who(line)),
    html("span", { class: "text" }, text),
  );
}

// The parameter channel: what master and drive say to each other, and parameters read and written at the bench.
import { html, say, Rows } from "./dom.js";

const KEPT = 60;

export class Pkw {
  #jobs = [];
  #rows;
  #read;
  #write;
  #number = 0;
  #last = new Map();

  /** `read(pnu, subindex)` and `write(pnu, subindex, value)` promise a sentence, and reject with one. */
  constructor(root, { read, write }) {
    this.#read = read;
    this.#write = write;
    const list = html("ol", { class: "log mono", tabindex: 0, "aria-label": "Jobs and replies on the bus, newest first" });
    this.pnu = html("input", { type: "number", class: "short", id: "pkw-pnu", min: 0, max: 2047, value: 1000, required: true });
    this.subindex = html("input", { type: "number", class: "short", id: "pkw-subindex", min: 0, max: 255 });
    this.value = html("input", { type: "number", id: "pkw-value", step: 1 });
    this.answer = html("p", { role: "status" });
    const form = html(
      "form",
      // The sentences of the drive and of this page say what is wrong, and stay until the next answer.
      { class: "form", novalidate: true },
      html("span", { class: "group" }, html("label", { class: "field" }, "PNU ", this.pnu), html("label", { class: "field" }, "Index ", this.subindex), html("button", { type: "submit" }, "Read")),
      html("span", { class: "group" }, html("label", { class: "field" }, "Value ", this.value), html("button", { type: "button", onclick: () => this.#writeValue() }, "Write")),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      // Who presses Enter in the value wants it written, not read over.
      if (document.activeElement === this.value) this.#writeValue();
      else this.#ask(this.#read);
    });
    root.replaceChildren(
      form,
      this.answer,
      html("p", { class: "hint" }, "Reads and writes directly, not over the bus: with the checks of the drive, but the master sees no job. Below: the jobs and replies on the bus, read 20 times a second; faster ones are in the telegrams."),
      list,
    );
    this.#rows = new Rows(list, () => {
      const time = html("span", { class: "time" });
      const kind = html("span", { class: "kind" });
      const text = html("span", { class: "text" });
      return {
        element: html("li", {}, time, kind, text),
        show: (line) => {
          say(time, `${line.time_s.toFixed(3)} s`);
          say(kind, line.kind);
          say(text, line.text);
        },
      };
    });
  }

  /** The form is for this parameter, of an array for its first element. The value of another one does not stay. */
  choose({ pnu, array }) {
    this.pnu.value = pnu;
    this.subindex.value = array ? "0" : "";
    this.value.value = "";
    this.#ask(this.#read);
    this.value.focus();
  }

  /** What the parameter channel carries at a time: `who` is master or drive. A line is added when it changes. */
  see(who, time_s, { words_hex, text }) {
    if (this.#last.get(who) === words_hex) return;
    this.#last.set(who, words_hex);
    this.#jobs.unshift({ time_s, kind: who, text: `${words_hex}  ${text}`, number: (this.#number += 1) });
    this.#jobs.splice(KEPT);
    this.#rows.show(this.#jobs, ({ number }) => number);
  }

  clear() {
    this.#jobs = [];
    this.#last.clear();
    this.#rows.show([], ({ number }) => number);
    this.#say("", "");
  }

  /** Nothing typed is not 0: what is no whole number is not sent. */
  #writeValue() {
    if (this.value.value === "" || !this.value.checkValidity()) {
      this.#say("Nothing is written: the value must be a whole number.", "refused");
      this.value.focus();
      return;
    }
    this.#ask(this.#write, this.value.valueAsNumber);
  }

  async #ask(act, value) {
    const { pnu, subindex } = this;
    for (const [field, sentence] of [[pnu, "The PNU must be a whole number from 0 to 2047."], [subindex, "The index must be a whole number from 0 to 255, or empty."]]) {
      if (field.checkValidity()) continue;
      this.#say(sentence, "refused");
      field.focus();
      return;
    }
    try {
      this.#say(await act(pnu.valueAsNumber, subindex.value === "" ? null : subindex.valueAsNumber, value), "done");
    } catch (error) {
      this.#say(error.message, "refused");
    }
  }

  #say(text, kind) {
    this.answer.className = kind;
    say(this.answer, text);
  }
}

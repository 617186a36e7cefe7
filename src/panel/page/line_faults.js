// The faults on purpose of a line or a bus: those that act, one more, all of them off.
import { html, many, say, Rows } from "./dom.js";

export class LineFaults {
  #rows;

  /** `kinds` are [as it is written, what it does]; `act(method, path, body)` asks for a change. */
  constructor(root, { kinds, placeholder, message, act }) {
    const kind = html("select", { "aria-label": "Fault" }, ...kinds.map(([value, text]) => html("option", { value }, `${value}: ${text}`)));
    const more = html("input", { type: "text", "aria-label": "When and where", placeholder, autocomplete: "off", spellcheck: "false" });
    const form = html("form", { class: "form" }, kind, html("span", { class: "group" }, more, html("button", { type: "submit" }, "Add")));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      act("POST", "/bus/faults", { fault: [kind.value, more.value.trim()].filter(Boolean).join(",") });
    });
    const list = html("ul", { class: "line" });
    this.none = html("p", { class: "muted" }, "None.");
    this.clear = html("p", {}, html("button", { type: "button", onclick: () => act("DELETE", "/bus/faults") }, "Remove all"));
    root.replaceChildren(this.none, list, this.clear, form, message);
    this.#rows = new Rows(list, ({ number, fault }) => {
      const injected = html("span", { class: "muted" });
      const remove = html("button", { type: "button", "aria-label": `Remove ${fault}`, onclick: () => act("DELETE", `/bus/faults/${number}`) }, "Remove");
      const element = html("li", {}, html("span", { class: "mono" }, fault), html("span", { class: "group" }, injected, remove));
      return { element, show: (fault) => say(injected, `injected ${many(fault.injected, "time")}`) };
    });
  }

  show(faults) {
    this.#rows.show(faults, ({ number }) => number);
    this.none.hidden = faults.length > 0;
    this.clear.hidden = faults.length === 0;
  }
}

// How to provoke each fault and take it back, and the history that the device keeps.
import { Rows, Table, html, mark, say } from "./dom.js";

export class Faults {
  #act;
  #list = html("div", { class: "provoke", role: "group", "aria-label": "Provoke a fault" });
  #rows = new Rows(this.#list, (fault) => this.#button(fault));
  #table = new Table("Fault history", ["Code", "Meaning", "When"], ({ code, text, when }) => [String(code), text ?? "", when ?? ""]);
  #none = html("p", { class: "muted" }, "The fault history is empty.");
  element = html("section", { class: "card", id: "faults", "aria-labelledby": "faults-title" }, html("h3", { id: "faults-title" }, "Faults"), this.#list, this.#table.element, this.#none);

  /** `act(method, path, body)` asks the station for something. */
  constructor(act) {
    this.#act = act;
  }

  show({ faults, history }) {
    const [made, kept] = [faults ?? [], history ?? []];
    this.element.hidden = made.length === 0 && kept.length === 0;
    this.#list.hidden = made.length === 0;
    this.#list.classList.toggle("many", made.length > 16);
    this.#rows.show(made, ({ fault }) => fault);
    this.#table.element.hidden = kept.length === 0;
    this.#none.hidden = kept.length > 0;
    this.#table.show(kept.map((entry, place) => ({ ...entry, key: place })));
  }

  #button({ fault }) {
    const provoked = () => element.getAttribute("aria-pressed") === "true";
    const element = html("button", { type: "button", "data-fault": fault, onclick: () => this.#act("POST", "/provoke", { fault, provoked: !provoked() }) }, fault);
    const show = ({ text, provoked, present }) => {
      mark(element, "aria-pressed", Boolean(provoked));
      mark(element, "data-present", Boolean(present));
      mark(element, "aria-label", `Provoke fault ${fault}: ${text}`);
      mark(element, "title", text);
      say(element, fault);
    };
    return { element, show };
  }
}

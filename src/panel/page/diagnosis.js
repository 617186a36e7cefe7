// The diagnosis of a station: what is raised, and what can be, in the texts of its GSD.
import { field, form, html, mark, say } from "./dom.js";

const MODULE_STATES = { invalid: "data invalid", wrong: "wrong module", missing: "no module" };
const WIDTHS = ["bit", "two_bits", "four_bits", "octet", "word", "two_words"];

export class Diagnosis {
  #ask;
  #act;
  #offered = false;
  #raised = html("ul", { class: "raised" });
  #octets = html("p", { class: "mono muted" });
  #bits = html("select", { multiple: true, size: 4, "aria-label": "Texts of the GSD" });
  #areas = html("select", { "aria-label": "Number in the diagnosis" });
  #slot = html("select", {});
  #module = html("select", {}, html("option", { value: "" }, "no status"), ...Object.entries(MODULE_STATES).map(([value, text]) => html("option", { value }, text)));
  #identifier = html("input", { type: "checkbox" });
  #error = html("select", {});
  #channel = html("input", { type: "number", min: 0, max: 63, value: 0 });
  #direction = html("select", {}, ...["input", "output", "both"].map((value) => html("option", { value }, value)));
  #width = html("select", {}, ...WIDTHS.map((value) => html("option", { value }, value.replace("_", " "))));
  #slots = "";

  /** `ask` and `act` send requests to the station; `act` shows what was refused. */
  constructor(ask, act) {
    this.#ask = ask;
    this.#act = (method, body) => act(method, "/diagnosis", body);
    const end = html("button", { type: "button", onclick: () => this.#act("DELETE") }, "End");
    this.element = html(
      "section",
      { class: "card", id: "diagnosis", "aria-labelledby": "diagnosis-title", hidden: true },
      html("h3", { id: "diagnosis-title" }, "Diagnosis"),
      this.#raised,
      this.#octets,
      form(
        { class: "stack" },
        () => this.#raise(),
        html("div", { class: "form" }, this.#bits, this.#areas),
        html("div", { class: "form" }, field("Slot", this.#slot), field("module status", this.#module), field("identifier", this.#identifier)),
        html("div", { class: "form" }, field("Channel error", this.#error), field("channel", this.#channel), field("direction", this.#direction), field("width", this.#width)),
        html("span", { class: "group" }, html("button", { type: "submit" }, "Raise"), end),
      ),
    );
  }

  /** What the GSD has texts for. */
  #offer({ bits, areas, statuses, channel_errors: errors }) {
    const option = (value, text) => html("option", { value }, text);
    const blocks = [{ type: "", bits, areas }, ...statuses].map((block) => ({ ...block, title: block.type === "" ? "" : `status ${block.type}, ` }));
    const texts = blocks.flatMap(({ type, title, bits }) => bits.map(({ number, text }) => option(`${type} ${number}`, `${title}${number}: ${text}`)));
    this.#bits.replaceChildren(...texts);
    this.#bits.hidden = texts.length === 0;
    const values = blocks.flatMap(({ type, title, areas }) =>
      areas.flatMap(({ first_bit: first, values }) => values.map(({ number, text }) => option(`${type} ${first} ${number}`, `${title}from bit ${first}: ${text}`))),
    );
    this.#areas.replaceChildren(option("", "no number"), ...values);
    this.#areas.hidden = values.length === 0;
    this.#error.replaceChildren(option("", "none"), ...errors.map(({ number, text }) => option(number, `${number}: ${text}`)));
  }

  show({ diagnosis, process }) {
    this.element.hidden = !diagnosis;
    if (!diagnosis) return;
    if (!this.#offered) {
      this.#offered = true;
      this.#ask("GET", "/texts").then((texts) => this.#offer(texts), () => (this.#offered = false));
    }
    const texts = diagnosis.texts ?? [];
    if ([...this.#raised.children].map(({ textContent }) => textContent).join("|") !== texts.join("|")) {
      this.#raised.replaceChildren(...texts.map((text) => html("li", {}, text)));
    }
    mark(this.#raised, "data-count", texts.length);
    const cut = diagnosis.overflow ? " (cut: Max_Diag_Data_Len)" : "";
    say(this.#octets, `Slave_Diag ${diagnosis.octets.map((octet) => octet.toString(16).toUpperCase().padStart(2, "0")).join(" ")}${cut}`);
    const slots = new Map((process ?? []).filter(({ slot }) => slot !== undefined && slot !== null).map(({ slot, name }) => [slot, name]));
    const offered = [...slots].join();
    if (offered === this.#slots) return;
    this.#slots = offered;
    this.#slot.replaceChildren(...[...slots].map(([slot, name]) => html("option", { value: slot }, name)));
  }

  /** As it is in the form: nothing else stays raised. */
  #raise() {
    const slot = Number(this.#slot.value);
    const chosen = [...this.#bits.selectedOptions].map(({ value }) => value.split(" "));
    const [area, first, value] = this.#areas.value.split(" ");
    const block = (type) => ({
      bits: chosen.filter(([of]) => of === type).map(([, number]) => Number(number)),
      areas: area === type && value !== undefined ? [{ first_bit: Number(first), value: Number(value) }] : [],
    });
    const types = new Set([...chosen.map(([type]) => type), area].filter((type) => type !== ""));
    const [direction, width] = [this.#direction.value, this.#width.value];
    this.#act("PUT", {
      ...block(""),
      statuses: [...types].map((type) => ({ type: Number(type), ...block(type) })),
      modules: this.#module.value === "" ? [] : [{ slot, state: this.#module.value }],
      identifiers: this.#identifier.checked ? [slot] : [],
      channels: this.#error.value === "" ? [] : [{ slot, channel: this.#channel.valueAsNumber, direction, width, error: Number(this.#error.value) }],
    });
  }
}

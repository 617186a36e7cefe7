// The diagnosis of a station: what is raised, and what can be, in the texts of its GSD.
import { html, say, mark } from "./dom.js";

const MODULE_STATES = { invalid: "data invalid", wrong: "wrong module", missing: "no module" };
const WIDTHS = ["bit", "two_bits", "four_bits", "octet", "word", "two_words"];

export class StationDiagnosis {
  #act;
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

  /** `act(method, body)` asks for another diagnosis. */
  constructor(root, act) {
    this.#act = act;
    const field = (name, input) => html("label", { class: "field" }, `${name} `, input);
    this.texts = html("div", { class: "form" }, this.#bits, this.#areas);
    const form = html(
      "form",
      {},
      this.texts,
      html("div", { class: "form" }, field("Slot", this.#slot), field("module status", this.#module), field("identifier", this.#identifier)),
      html("div", { class: "form" }, field("Channel error", this.#error), field("channel", this.#channel), field("direction", this.#direction), field("width", this.#width)),
      html("span", { class: "group" }, html("button", { type: "submit" }, "Raise"), html("button", { type: "button", onclick: () => act("DELETE") }, "End")),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#raise();
    });
    root.replaceChildren(this.#raised, this.#octets, form);
  }

  /** Nothing is known of the station. */
  clear() {
    this.#slots = "";
    this.offer({ bits: [], areas: [], channel_errors: [] });
    this.#raised.replaceChildren();
    say(this.#octets, "");
  }

  /** What the GSD has texts for. */
  offer({ bits, areas, channel_errors: errors }) {
    const option = (value, text) => html("option", { value }, text);
    this.#bits.replaceChildren(...bits.map(({ number, text }) => option(number, `${number}: ${text}`)));
    this.#bits.hidden = bits.length === 0;
    const values = areas.flatMap(({ first_bit: first, values }) => values.map(({ number, text }) => option(`${first} ${number}`, `from bit ${first}: ${text}`)));
    this.#areas.replaceChildren(option("", "no number"), ...values);
    this.#areas.hidden = values.length === 0;
    this.#error.replaceChildren(option("", "none"), ...errors.map(({ number, text }) => option(number, `${number}: ${text}`)));
  }

  show({ diagnosis, modules }) {
    const { texts } = diagnosis;
    if ([...this.#raised.children].map(({ textContent }) => textContent).join("|") !== texts.join("|")) {
      this.#raised.replaceChildren(...texts.map((text) => html("li", {}, text)));
    }
    mark(this.#raised, "data-count", texts.length);
    const cut = diagnosis.overflow ? " (cut: Max_Diag_Data_Len)" : "";
    say(this.#octets, `Slave_Diag ${diagnosis.octets.map((octet) => octet.toString(16).toUpperCase().padStart(2, "0")).join(" ")}${cut}`);
    const slots = modules.map(({ slot, name }) => [slot, `${slot}: ${name}`]);
    if (slots.join() !== this.#slots) {
      this.#slots = slots.join();
      this.#slot.replaceChildren(...slots.map(([slot, text]) => html("option", { value: slot }, text)));
    }
  }

  /** As it is in the form: nothing else stays raised. */
  #raise() {
    const slot = Number(this.#slot.value);
    const [first, value] = this.#areas.value.split(" ").map(Number);
    const [direction, width] = [this.#direction.value, this.#width.value];
    this.#act("PUT", {
      bits: [...this.#bits.selectedOptions].map(({ value }) => Number(value)),
      areas: this.#areas.value === "" ? [] : [{ first_bit: first, value }],
      modules: this.#module.value === "" ? [] : [{ slot, state: this.#module.value }],
      identifiers: this.#identifier.checked ? [slot] : [],
      channels: this.#error.value === "" ? [] : [{ slot, channel: this.#channel.valueAsNumber, direction, width, error: Number(this.#error.value) }],
    });
  }
}

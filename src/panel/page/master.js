// The master in this program: what it can be asked about the station, what it does, and the words that it sends. Without
// it, what `profidrive master` is told to do the same.
import { Rows, button, field, form, html, mark, say, typedNumber } from "./dom.js";
import { copyButton } from "./copy.js";

export class Master {
  #ask;
  #can = null;
  #title = html("h3", { id: "master-title" });
  #about = html("p", { id: "master-about", class: "hint" });
  #doing = html("p", { id: "master-doing", role: "status" });
  #acts = html("div", { class: "acts", role: "group", "aria-label": "What a master can do" });
  #rows = new Rows(this.#acts, (act) => this.#act(act));
  #place = html("input", { type: "text", class: "key mono", autocomplete: "off", spellcheck: "false" });
  #value = html("input", { type: "text", class: "number", autocomplete: "off", spellcheck: "false" });
  #octets = html("input", { type: "text", class: "mono", autocomplete: "off", spellcheck: "false", placeholder: "01 FF" });
  #access = form({ "aria-label": "Parameters over the bus" }, () => (document.activeElement === this.#value ? this.#write() : this.#read()), html("span", { class: "group" }, field("Parameter over the bus", this.#place), html("button", { type: "submit" }, "Read")), html("span", { class: "group" }, field("Value", this.#value), button("Write", () => this.#write())));
  #outputs = form({ "aria-label": "Outputs" }, () => this.#order({ act: "outputs", octets_hex: this.#octets.value }), field("Outputs", this.#octets), html("button", { type: "submit" }, "Send in each cycle"));
  #take = button("Take over", () => this.#order({ act: "take" }));
  #leave = button("Leave the line", () => this.#go());
  #sentTitle = html("h4", {}, "Sent");
  #sent = html("ol", { class: "log mono", tabindex: 0, "aria-label": "Words that the master has sent, newest first", id: "master-sent" });
  #lines = new Rows(this.#sent, ({ time_seconds: time, text }) => {
    const spans = [`${time.toFixed(3)} s`, text].map((part, place) => html("span", { class: ["time", "text"][place] }, part));
    return { element: html("li", {}, ...spans), show: () => {} };
  });
  #over = html("p", { class: "group" }, this.#take, this.#leave);
  element = html("section", { class: "card", id: "master", "aria-labelledby": "master-title", hidden: true }, this.#title, this.#about, this.#acts, this.#access, this.#outputs, this.#over, this.#doing, this.#sentTitle, this.#sent);

  /**
   * `ask(method, path, body)` asks the station. `advise(command)` gets the command that does what is advised. `below()` puts this
   * farther down the page, where there is nothing to click.
   */
  constructor(ask, { advise, below }) {
    this.#ask = ask;
    this.advise = advise;
    this.below = below;
  }

  /** What can be asked, which changes seldom. */
  async refresh() {
    const can = await this.#ask("GET", "/master").catch(() => null);
    if (can === null) return;
    this.#can = can;
    this.advise(can.next_command);
    const here = can.master !== null;
    if (!here) this.below();
    this.element.hidden = !here && can.acts.every(({ command }) => command === null);
    say(this.#title, here ? "The master in this program" : "For a master in a terminal");
    this.#rows.show(can.acts.filter(({ command }) => here || command !== null), ({ act }) => act);
    this.#access.hidden = !here || !can.reads;
    this.#outputs.hidden = !here || can.outputs === null;
    mark(this.#octets, "aria-description", can.outputs === null ? "" : `${can.outputs} octets, hexadecimal`);
    for (const part of [this.#over, this.#doing]) part.hidden = !here;
    if (!here) this.#sentTitle.hidden = this.#sent.hidden = true;
    if (here) this.#tell(can.master);
    else say(this.#about, "Each command does what its name says, with a master of its own. A master inside this program: --bench, or 'profidrive try'.");
  }

  /** What it does, as the state of the station has it. */
  show({ master }) {
    if (master) this.#tell(master);
  }

  #tell({ taken, own_address: own, doing, done, sent }) {
    const who = own === null ? "It" : `Master ${own}`;
    say(this.#about, taken ? `${who} has this station. It is part of this program, and no master of yours.` : "It is silent until it is asked something. It is part of this program, and no master of yours.");
    this.#leave.hidden = !taken;
    this.#take.hidden = taken || own === undefined;
    mark(this.#doing, "class", doing ? "" : done?.well === false ? "refused" : "done");
    say(this.#doing, doing ? `${doing} …` : done ? `${done.what}: ${done.text}` : "");
    this.#sentTitle.hidden = this.#sent.hidden = (sent ?? []).length === 0;
    this.#lines.show([...(sent ?? [])].reverse().map((line, place) => ({ ...line, place })), ({ time_seconds: time, text }) => `${time} ${text}`);
  }

  /** A button, with a field where a number is needed, and its command. */
  #act({ act, name, quantity, command }) {
    const value = quantity && html("input", { type: "text", class: "number", inputmode: "decimal", autocomplete: "off", "aria-label": `${quantity.name}, ${quantity.unit || "as the device counts"}`, value: "0" });
    const here = this.#can?.master !== null;
    const parts = [];
    if (here) parts.push(button(name, () => this.#do(act, value), { "data-act": act }));
    else parts.push(html("span", {}, name));
    if (value) parts.push(value, html("span", { class: "unit" }, quantity.unit));
    if (command) parts.push(copyButton("copy", `Copy the command: ${name}`, () => command.replace("{}", value ? value.value : "")));
    if (value && here) value.addEventListener("keydown", (event) => event.key === "Enter" && this.#do(act, value));
    return { element: html("span", { class: "act", "data-here": here }, ...parts), show: () => {} };
  }

  #do(act, input) {
    try {
      const value = input ? typedNumber(input.value) : undefined;
      if (value === null) throw new RangeError("Nothing is sent: there is no number.");
      this.#order({ act, value });
    } catch (error) {
      this.#refuse(error);
    }
  }

  #read() {
    this.#order({ act: "read", place: this.#place.value });
  }

  #write() {
    try {
      const value = typedNumber(this.#value.value);
      if (value === null) throw new RangeError("Nothing is written: there is no value.");
      this.#order({ act: "write", place: this.#place.value, value });
    } catch (error) {
      this.#refuse(error);
    }
  }

  async #order(order) {
    try {
      this.#tell(await this.#ask("POST", "/master", order));
    } catch (error) {
      this.#refuse(error);
    }
  }

  async #go() {
    try {
      await this.#ask("DELETE", "/master");
      await this.refresh();
    } catch (error) {
      this.#refuse(error);
    }
  }

  #refuse({ message }) {
    mark(this.#doing, "class", "refused");
    say(this.#doing, message);
  }
}

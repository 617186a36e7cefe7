// Records and alarms of a station of DP-V1: contents by slot and index, alarms that wait for the master, connections.
import { Table, button, field, form, html, mark, say } from "./dom.js";

const TYPES = { 1: "diagnostic", 2: "process", 3: "pull", 4: "plug", 5: "status", 6: "update" };
const SPECIFIERS = { none: "neither", appears: "appears", disappears: "disappears", still: "disappears, still disturbed" };
const STATES = { pending: "not read by the master", delivered: "read, not acknowledged" };
const ACCESS = { r: "read", w: "write", rw: "read and write", none: "none" };

export class Records {
  #ask;
  #wanted = false;
  #types = "";
  #records = new Table("Records, all of them", ["Slot and index", ">Octets", "Access", "Contents", "As text"], (item) => [item.key, String(item.length), ACCESS[item.access], item.data, item.text], (item) =>
    button(item.key, () => this.#choose(item), { class: "plain mono", "aria-label": `Choose record ${item.index} of slot ${item.slot}` }),
  );
  #alarms = new Table("Alarms", ["Alarm", "State", "Data"], ({ text, state, data }) => [text, STATES[state], data]);
  #identification = new Table("Identification and maintenance", ["Block", "Contents"], ({ block, text }) => [`I&M${block}`, text]);
  #channels = html("p", { class: "muted", id: "channels" });
  #slot = html("input", { type: "number", min: 0, max: 254, value: 0 });
  #index = html("input", { type: "number", min: 0, max: 254, value: 0 });
  #data = html("input", { type: "text", class: "mono", placeholder: "01 02 FF", autocomplete: "off", spellcheck: "false" });
  #type = html("select", {});
  #ofSlot = html("input", { type: "number", min: 0, max: 254, value: 0 });
  #specifier = html("select", {}, ...Object.entries(SPECIFIERS).map(([value, text]) => html("option", { value }, text)));
  #about = html("input", { type: "text", class: "mono", placeholder: "01 02 FF", autocomplete: "off", spellcheck: "false" });
  #more = html("input", { type: "checkbox" });
  #answer = html("p", { role: "status", id: "records-answer" });
  #change = form(
    {},
    () => this.#send("PUT", this.#place(), { data: this.#data.value }, ({ data }) => `contents: ${data}`),
    html("span", { class: "group" }, field("Slot", this.#slot), field("index", this.#index)),
    html("span", { class: "group" }, field("contents", this.#data), html("button", { type: "submit" }, "Change")),
  );
  #hint = html("p", { class: "hint" }, "A change is one of the device: also of a record that a master cannot write, and no master is told.");
  #raise = form(
    {},
    () => this.#send("POST", "/alarms", this.#alarm(), ({ text }) => `raised: ${text}`),
    field("Alarm", this.#type),
    field("slot", this.#ofSlot),
    field("what is reported", this.#specifier),
    field("data of the alarm", this.#about),
    field("wants an acknowledgement of the user, too", this.#more),
    html("span", { class: "group" }, html("button", { type: "submit" }, "Raise alarm"), button("Forget all", () => this.#send("DELETE", "/alarms", undefined, () => "no alarm waits any more"))),
  );

  /** `ask(method, path, body)` asks the station. */
  constructor(ask) {
    this.#ask = ask;
    this.element = html(
      "section",
      { class: "card", id: "records", "aria-labelledby": "records-title", hidden: true },
      html("h3", { id: "records-title" }, "Records and alarms"),
      this.#channels,
      this.#records.element,
      this.#change,
      this.#answer,
      this.#hint,
      this.#alarms.element,
      this.#raise,
      this.#identification.element,
    );
  }

  show({ has }) {
    this.#wanted = Boolean(has?.records);
    this.element.hidden = !this.#wanted;
  }

  /** What is not in the stream. */
  async refresh() {
    if (!this.#wanted) return;
    const answers = await Promise.all(["/records", "/alarms", "/acyclic"].map((path) => this.#ask("GET", path))).catch(() => null);
    if (!answers) return;
    const [{ records }, { alarms, types }, channels] = answers;
    this.#records.show(records.map((record) => ({ ...record, key: `${record.slot} / ${record.index}` })));
    // A drive of PROFIdrive has its parameters behind record 47, and nothing that could be changed here.
    for (const part of [this.#records.element, this.#change, this.#hint]) part.hidden = records.length === 0;
    this.#alarms.show(alarms.map((alarm) => ({ ...alarm, key: `${alarm.type} ${alarm.slot} ${alarm.sequence}` })));
    this.#alarms.element.hidden = alarms.length === 0;
    mark(this.element, "data-alarms", alarms.length);
    this.#offer(types);
    const blocks = channels.identification.map((block) => ({ ...block, key: block.block }));
    this.#identification.show(blocks);
    this.#identification.element.hidden = blocks.length === 0;
    const owner = channels.ms1.open ? `the owner, master ${channels.ms1.owner}, can read and write` : "MS1 is closed";
    const links = channels.ms2.map(({ sap, master }) => `master ${master} at SAP ${sap}`).join(", ");
    say(this.#channels, `${owner}; ${channels.max === 0 ? "no connections" : links === "" ? `none of ${channels.max} connections is open` : `connections: ${links}`}`);
  }

  #offer(types) {
    this.#raise.hidden = types.length === 0;
    if (types.join() === this.#types) return;
    this.#types = types.join();
    this.#type.replaceChildren(...types.map((type) => html("option", { value: type }, TYPES[type] ?? `of the manufacturer, ${type}`)));
  }

  #choose({ slot, index, data }) {
    this.#slot.value = slot;
    this.#index.value = index;
    this.#data.value = data;
    this.#data.focus();
  }

  #place() {
    return `/records/${this.#slot.value || 0}/${this.#index.value || 0}`;
  }

  #alarm() {
    return { type: Number(this.#type.value), slot: Number(this.#ofSlot.value), specifier: this.#specifier.value, additional_ack: this.#more.checked, data: this.#about.value };
  }

  async #send(method, path, body, words) {
    try {
      const answer = await this.#ask(method, path, body);
      this.#say(words(answer ?? {}), "done");
    } catch (error) {
      this.#say(error.message, "refused");
    }
    await this.refresh();
  }

  #say(text, kind) {
    mark(this.#answer, "class", kind);
    say(this.#answer, text);
  }
}

// The telegrams on the line in words, as long as they are recorded; a trigger or a fault ends the recording.
import { html, mark, say } from "./dom.js";
import { fileOf, lineOf } from "./api.js";
import { Lines, hasWords, wordsOf } from "./lines.js";

const KEPT = 5000;
/** So many are recorded after what ends the recording. */
const AFTER = 50;

export class Telegrams {
  #lines;
  #onRecord;
  #recording = false;
  #trigger = [];
  /** How many are still recorded after the trigger; `null`: nothing has triggered. */
  #left = null;
  /** The newest telegram in words, by who sent it to whom. */
  #newest = new Map();

  /** `onRecord(wanted)` is called when telegrams are wanted or not any more, `onPoint(time)` when somebody chooses one. */
  constructor(root, onRecord, onPoint) {
    this.#onRecord = onRecord;
    this.record = html("button", { type: "button", "aria-pressed": false, onclick: () => this.#record(!this.#recording) }, "Record telegrams");
    this.changes = html("input", { type: "checkbox", onchange: () => this.#lines.again() });
    this.atFault = html("input", { type: "checkbox" });
    const trigger = html("input", { type: "text", placeholder: "FDL_Status, 6041h ...", autocomplete: "off", spellcheck: "false", oninput: () => (this.#trigger = wordsOf(trigger.value)) });
    this.ended = html("span", { class: "muted ended" });
    this.save = html("a", { class: "button", download: "profidrive.pcapng" }, "Save as pcapng");
    this.#lines = new Lines(root, {
      label: "Telegrams",
      placeholder: "Set_Prm, -Data_Exchange, SDO ...",
      kept: KEPT,
      onPoint,
      tools: [
        this.record,
        html("label", { class: "field" }, this.changes, " changes only"),
        html("label", { class: "field" }, this.atFault, " stop on fault"),
        html("label", { class: "field", title: `The recording ends ${AFTER} telegrams after the first with these words` }, "Stop at ", trigger),
        this.ended,
        this.save,
      ],
      wanted: ({ same }) => !(same && this.changes.checked),
    });
  }

  /** The line whose capture is saved. */
  of(line) {
    this.save.hidden = line === null;
    if (line !== null) mark(this.save, "href", fileOf(`${lineOf(line)}/capture.pcapng`));
  }

  get wanted() {
    return this.#recording;
  }

  only(station) {
    this.#lines.only(station);
  }

  /** A line as `Lines` has it, with `route`: who sent it to whom. */
  add({ route, ...line }) {
    if (!this.#recording) return;
    const same = this.#newest.get(route) === line.text;
    this.#newest.set(route, line.text);
    const hit = this.#left === null && this.#trigger.length > 0 && hasWords(line, this.#trigger);
    this.#lines.add({ ...line, same: same && !hit, bad: line.bad || hit });
    if (hit) this.#endSoon(`ended by "${this.#trigger.join(" ")}" at ${line.time_s.toFixed(3)} s`);
    else if (this.#left !== null && (this.#left -= 1) <= 0) this.#record(false);
  }

  /** The trigger of the timeline has hit: the recording ends soon, so that what was before stays. */
  triggered({ time_s, text }) {
    if (this.#recording && this.#left === null) this.#endSoon(`ended by the trigger at ${time_s.toFixed(3)} s: ${text}`);
  }

  /** A station went to fault: the recording ends soon if it shall. */
  fault({ time_s, text }) {
    if (this.#recording && this.atFault.checked && this.#left === null) this.#endSoon(`ended by a fault at ${time_s.toFixed(3)} s: ${text}`);
  }

  paint() {
    this.#lines.paint();
  }

  /** Shows the newest telegram until `time`: what came before. */
  point(time) {
    this.#lines.point(time);
  }

  get shown() {
    return this.#lines.shown;
  }

  #endSoon(why) {
    this.#left = AFTER;
    say(this.ended, why);
  }

  #record(recording) {
    this.#recording = recording;
    this.#left = null;
    if (recording) {
      this.#newest.clear();
      say(this.ended, "");
    }
    mark(this.record, "aria-pressed", recording);
    this.#onRecord(recording);
  }
}

// One drive in all details: the state of the API given to the parts of the page.
import { html, say, mark } from "./dom.js";
import { DeviceDrawing, switchesText } from "./device.js";
import { Curves } from "./curves.js";
import { Faults, causeIsThere, wayOut } from "./faults.js";
import { Inputs } from "./inputs.js";
import { Parameters } from "./parameters.js";
import { Pkw } from "./pkw.js";
import { Values } from "./values.js";
import { Why } from "./why.js";
import { WordTable } from "./words.js";
import { busText, isLit, statusText } from "./leds.js";
import { inUnit, modelName, stateOf, unitOf } from "./states.js";
import { request } from "./api.js";

const STILL = matchMedia("(prefers-reduced-motion: reduce)");
const KEYS = { clockwise: "key_1", counter_clockwise: "key_2" };
const MOTOR = { released: "released", in_control: "in control", shorted: "shorted" };
const EEPROM = { in_memory: "in memory", writing: "is being written", stored: "in its file", failed: "NOT written, see the log" };
const TERMINATOR = { inactive: "off", active: "on", half: "half on: set SW9 and SW10 alike" };
/** What a drive does that needs no start: nothing stands against it then. */
const UNDER_WAY = {
  "travelling with velocity": "the setpoint is released",
  inching: "inching",
  "inching by key": "a key turns the shaft",
  "inching by key ends": "a key has turned the shaft",
};
/** The name of a bit without one. */
const NOT_USED = "not used";
/** Levels that need somebody, by word and key of the bit. */
const ALARMS = { zsw: [[3, true], [6, true], [7, true], [14, true]], ssw: [[5, true], [6, true], [8, true], [10, true], [12, true], [13, true], [15, true]], stw: [] };

export class DriveView {
  #address = null;
  #state = null;
  #seen = 0;
  #by;

  constructor() {
    this.#by = (id) => document.getElementById(id);
    const by = this.#by;
    this.drawing = new DeviceDrawing(by("device"), {
      flip: (index, on) => this.#flip(index, on),
      key: (name, pressed) => this.#act("POST", "/keys", { key: KEYS[name], pressed }),
    });
    this.saveCurves = html("a", { class: "button" }, "Save as CSV");
    this.curves = new Curves(by("curves"), this.saveCurves);
    this.values = new Values(by("values"));
    this.why = new Why(by("why"));
    this.inputs = new Inputs(by("inputs"), (changes) => this.#request("PATCH", "/inputs", changes));
    this.faults = new Faults(by("faults"), {
      provoke: (fault) => this.#act("POST", "/provoke", { fault }),
      takeBack: (inputs) => this.inputs.change(inputs),
    });
    this.words = Object.fromEntries(["stw", "zsw", "ssw"].map((word) => [word, new WordTable(by(word))]));
    this.pkw = new Pkw(by("pkw"), { read: (...of) => this.#readParameter(...of), write: (...of) => this.#writeParameter(...of) });
    this.parameters = new Parameters(by("parameters"), (parameter) => this.pkw.choose(parameter));
    this.powerText = html("p", {});
    this.powerButton = html("button", { type: "button", onclick: () => this.#act("PUT", "/power", { on: this.#state?.power === "off" }) }, "Power off");
    this.message = html("p", { class: "refused", role: "alert" });
    by("power").replaceChildren(this.powerText, this.powerButton, this.message);
  }

  /** Another drive is chosen; nothing of the last one stays. Says whether it is another. */
  choose(address) {
    if (this.#address === address) return false;
    this.drawing.releaseKeys();
    this.#address = address;
    this.#state = null;
    this.curves.clear();
    this.pkw.clear();
    this.inputs.clear();
    this.parameters.show([]);
    say(this.message, "");
    say(this.#by("drive-title"), `Drive ${address}`);
    mark(this.#by("drive"), "data-known", "asked");
    mark(this.saveCurves, "href", `/api/v1/drives/${address}/samples.csv`);
    mark(this.saveCurves, "download", `drive-${address}.csv`);
    return true;
  }

  /** What the server has kept of the chosen drive, as curves. */
  recall(samples) {
    this.curves.addBefore(
      samples.map((sample) => ({
        time_s: sample.time_seconds,
        position: sample.position_user_units,
        setpoint: sample.target_user_units,
        speed_setpoint_rpm: sample.setpoint_rpm,
        speed_rpm: sample.velocity_rpm,
        current_ma: sample.current_milliamperes,
        unit: unitOf(sample),
      })),
    );
  }

  /** Something that happened, as a mark in the curves if it is of the chosen drive. */
  mark(line) {
    if (line.stations.includes(this.#address)) this.curves.mark(line);
  }

  /** A complete state of the chosen drive; `gap`: states before it were lost. */
  show(state, gap) {
    if (state.address !== this.#address) return;
    this.#state = state;
    this.#seen = performance.now();
    mark(this.#by("drive"), "data-known", "there");
    this.#showHead(state);
    this.#showWhy(state);
    this.#showDevice(state);
    this.#showValues(state);
    this.#showWords(state);
    this.inputs.show(state.model, state.inputs);
    this.faults.show({
      model: state.model,
      gear: state.gear_ratio,
      inputs: state.inputs,
      latched: state.faults.latched,
      present: causeIsThere(state.faults),
      turnOnDisabled: state.state === "turn-on disabled",
      buffer: state.faults.buffer,
      count: state.faults.count,
    });
    this.#addSample(state, gap);
    this.#addJob(state);
    if (state.parameters) this.showParameters(state.parameters);
  }

  /** There is no drive at this address, and nothing to show of one: the sentence takes the place of everything. */
  gone(sentence) {
    this.#state = null;
    this.drawing.releaseKeys();
    this.curves.clear();
    mark(this.#by("drive"), "data-known", "gone");
    mark(this.#by("drive-state"), "data-kind", "off");
    say(this.#by("drive-dp"), "");
    this.#by("drive-state").replaceChildren(html("span", { class: "shape", "aria-hidden": "true" }), "not present");
    this.why.show({ title: sentence, kind: "fault", reasons: [], refused: "" });
  }

  showParameters(parameters) {
    this.parameters.show(parameters.map(parameterRow));
  }

  /** What moves by itself between two states: LEDs, curves. */
  paint() {
    const state = this.#state;
    if (state) {
      const ms = performance.now() - this.#seen;
      // For those who want nothing to move, the text says that it blinks.
      const steady = STILL.matches && state.status_led.pattern === "blinking";
      this.drawing.light({
        status: steady || isLit(state.status_led, ms),
        bus: isLit(state.bus_led, ms),
        statusText: statusText(state),
        busText: busText(state.bus_led),
      });
    }
    this.curves.paint();
  }

  #showHead(state) {
    const { kind } = stateOf(state);
    const head = this.#by("drive-state");
    const text = state.fault === null ? state.state : `fault ${state.fault}`;
    if (head.dataset.kind !== kind || head.textContent !== text) {
      mark(head, "data-kind", kind);
      head.replaceChildren(html("span", { class: "shape", "aria-hidden": "true" }), text);
    }
    const { watchdog_milliseconds: watchdog } = state.dp;
    const minded = watchdog === null ? "no watchdog" : `watchdog ${watchdog / 1000} s`;
    const owner = state.owner_address === null ? "no master" : `master ${state.owner_address}, ${minded}`;
    say(this.#by("drive-dp"), `${modelName(state)}, gear ${state.gear_ratio}:1 · ${state.dp_state}, ${owner}`);
  }

  #showWhy(state) {
    const { possible, reasons, next } = state.start;
    const busy = state.mode === "positioning" && state.motion.job_active && reasons.length === 1;
    const start = state.mode === "velocity" ? "STW.6 = 1 releases the setpoint" : "an edge of STW.6 starts a travel job";
    let title = possible ? `Ready: ${start}` : "It does not start, because";
    const doing = busy ? reasons[0].text : UNDER_WAY[state.state];
    if (doing !== undefined) title = `Active: ${doing}`;
    const { latched } = state.faults;
    let way = "";
    if (latched !== null) {
      const present = causeIsThere(state.faults);
      title = `Fault ${latched.text}. ${present ? "Its cause is still present." : "Its cause is gone."}`;
      way = wayOut(present, next);
    }
    const kind = state.fault !== null ? "fault" : possible || doing !== undefined ? "ready" : "waiting";
    const texts = reasons.map(({ text }) => text);
    if (!possible && next !== null && latched === null) texts.push(`Next: ${next}`);
    const { last_refusal: refusal } = state;
    const ago = refusal === null ? 0 : Math.max(0, Math.round(state.time_seconds - refusal.time_seconds));
    const when = ago < 60 ? `${ago} s ago` : `${Math.round(ago / 60)} min ago`;
    this.why.show({ title, kind, reasons: doing !== undefined ? [] : texts, way, refused: refusal === null ? "" : `Last refusal, ${when}: ${refusal.text}` });
  }

  #showDevice(state) {
    const { switches, keys } = state;
    this.drawing.show({
      name: `${modelName(state)}  ${state.gear_ratio}:1`,
      switches: switches.positions,
      keys: [...(keys.key_1_pressed ? ["clockwise"] : []), ...(keys.key_2_pressed ? ["counter_clockwise"] : [])],
      // Counter-clockwise counts positive there, clockwise here.
      shaft: -state.motion.shaft_revolutions,
    });
    const meaning = switches.factory_reset ? `factory reset of ${switches.factory_reset} parameters` : `address ${switches.address}`;
    const waits = switches.address !== state.address || switches.factory_reset ? " from the next power-on" : "";
    say(this.powerText, `${switchesText(switches.positions)}: ${meaning}${waits}, terminator ${TERMINATOR[switches.terminator]}. EEPROM ${EEPROM[state.eeprom]}.`);
    say(this.powerButton, state.power === "off" ? "Power on" : "Power off");
  }

  #showValues({ motion, measured, model }) {
    const unit = unitOf(motion);
    const volts = (value) => ({ value: value.toFixed(1), unit: "V" });
    this.values.show([
      { name: "Position", value: inUnit(motion.position_user_units, unit), unit: unit.name, main: true },
      { name: "Speed", value: String(motion.velocity_rpm), unit: "rpm", main: true },
      { name: "Current", value: String(measured.current_milliamperes), unit: "mA", main: true },
      { name: "Target", value: motion.target_user_units === null ? "–" : inUnit(motion.target_user_units, unit), unit: motion.target_user_units === null ? "" : unit.name },
      { name: "To go", value: motion.distance_to_go_user_units === null ? "–" : inUnit(motion.distance_to_go_user_units, unit), unit: motion.distance_to_go_user_units === null ? "" : unit.name },
      { name: "Output stage", value: measured.stage_temperature_celsius.toFixed(1), unit: "°C" },
      { name: "Intermediate circuit", ...volts(measured.dc_link_volts) },
      ...(model === "ag03-1" ? [{ name: "Output supply", ...volts(measured.output_supply_volts) }] : []),
      { name: "Control supply", ...volts(measured.control_supply_volts) },
      { name: "Battery", value: measured.battery_volts.toFixed(2), unit: "V" },
      { name: "Motor", value: MOTOR[motion.motor] },
    ]);
  }

  #showWords({ words, mode }) {
    for (const [name, table] of Object.entries(this.words)) {
      const bits = words[name].bits.map((bit) => ({
        bit: bit.bit,
        name: bit.name,
        meaning: bit.meaning === bit.name || bit.name === NOT_USED ? "" : bit.meaning,
        set: bit.set,
        used: bit.used,
        alarm: ALARMS[name].some(([number, level]) => number === bit.bit && level === bit.set && bit.used),
      }));
      table.show({ raw: words[name].value, mode: `${mode} mode`, bits });
    }
  }

  #addSample(state, gap) {
    const { motion, measured } = state;
    const released = state.state === "travelling with velocity";
    this.curves.add(
      {
        time_s: state.time_seconds,
        position: motion.position_user_units,
        // Of the job in progress: what HSW is meanwhile is a number on the bus and no target.
        setpoint: motion.target_user_units,
        speed_setpoint_rpm: released ? motion.setpoint_rpm : null,
        speed_rpm: motion.velocity_rpm,
        current_ma: measured.current_milliamperes,
        unit: unitOf(motion),
      },
      gap,
    );
  }

  #addJob({ time_seconds: time_s, ppo }) {
    this.pkw.see("master", time_s, ppo.outputs.pkw);
    this.pkw.see("drive", time_s, ppo.inputs.pkw);
  }

  #flip(index, on) {
    const positions = this.#state?.switches.positions.with(index, on);
    if (positions) this.#act("PUT", "/switches", { positions });
  }

  async #readParameter(pnu, subindex) {
    return sentence(await this.#request("GET", `/parameters/${pnu}${element(subindex)}`));
  }

  async #writeParameter(pnu, subindex, value) {
    return sentence(await this.#request("PUT", `/parameters/${pnu}${element(subindex)}`, { value }));
  }

  #request(method, path, body) {
    return request(method, `/drives/${this.#address}${path}`, body);
  }

  async #act(method, path, body) {
    try {
      await this.#request(method, path, body);
      say(this.message, "");
    } catch (error) {
      say(this.message, error.message);
    }
  }
}

function element(subindex) {
  return subindex === null ? "" : `?subindex=${subindex}`;
}

function sentence({ pnu, subindex, name, text }) {
  const which = subindex === null ? "" : `, element ${subindex}`;
  return `PNU ${pnu}${which}, ${name}: ${text}`;
}

function parameterRow({ pnu, name, text, elements, access, low, high }) {
  const range = access === "read_only" ? "read only" : low === null ? "" : `${low} to ${high}`;
  // Of the fault buffer, what is empty says nothing.
  const shown = elements ? text.replace(/(, no fault)+$/, "") : text;
  return { pnu, name, value: access === "write_only" ? "" : shown, range, array: Boolean(elements) };
}

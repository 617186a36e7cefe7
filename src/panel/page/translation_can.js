// Nodes of a CAN bus as stations.
import { Keys } from "./translation_keys.js";

const LINE = "can";
const UNITS = { volts: "V", celsius: "°C", metres: "Nm", revolutions: "turns", rpm: "rpm", percent: "%" };
/** What a COB-ID is for, in the predefined connection set. */
const SERVICES = { 1: "EMCY", 3: "TPDO1", 4: "RPDO1", 5: "TPDO2", 6: "RPDO2", 7: "TPDO3", 8: "RPDO3", 9: "TPDO4", 10: "RPDO4", 11: "SDO answer", 12: "SDO request", 14: "heartbeat" };
/** News that stand out. */
const FAULTS = ["emcy", "error_control"];
const DEVICES = ["ag03-1", "ap10", "asda-a2"].map((device) => ({ device, text: device }));
/** How a fault is written, and what the master gets (docs/faults.md). */
const FAULT_KINDS = Object.entries({
  "boot-up-missing": "no boot-up",
  "boot-up-twice": "two boot-ups",
  "sdo-late=20ms": "SDO answers 20 ms later",
  "sdo-lost": "no SDO answer",
  "sdo-twice": "SDO answers twice",
  "sdo-other-index": "SDO answers of another object",
  "sdo-wrong-toggle": "segments with the wrong toggle bit",
  "sdo-abort=08000022": "an abort in place of SDO answers",
  "heartbeat-jitter=50ms": "every second heartbeat later",
  "heartbeat-lost": "no heartbeat",
  "heartbeat-stuck=05": "heartbeats always with this state",
  "guarding-toggle-stuck": "guarding answers without toggle",
  "tpdo-short": "TPDOs without their last octet",
  "tpdo-stale": "TPDOs with old data",
  "tpdo-swapped": "a TPDO after the next one",
  "emcy-storm=100ms": "EMCY again and again",
  "pre-operational": "the node leaves OPERATIONAL by itself",
  "brown-out=500ms": "the supply fails and returns",
  "frame-lost": "nobody hears a frame",
  "frame-late=20ms": "frames 20 ms later",
  "frame-twice": "frames twice",
  "frame-damaged": "error frames: 32 lead to bus off",
  "frame-not-acknowledged": "no acknowledge: 16 lead to error passive",
}).map(([fault, text]) => ({ fault, text }));

export class Can {
  #ask;
  #keys = new Keys();

  constructor(ask) {
    this.#ask = ask;
  }

  query({ station, kinds, interval_milliseconds: interval }) {
    const wanted = kinds.map((kind) => (kind === "telegram" ? "frame" : kind)).join(",");
    return { kinds: wanted, interval_milliseconds: interval, ...(station === null ? {} : { address: station.address }) };
  }

  event(name, data) {
    if (name === "state") return [name, data.drives ? stations(data) : stateOf(data)];
    if (name === "frame") return ["telegram", telegram(data)];
    return [name, name === "news" ? newsOf(data) : data];
  }

  /** There are no curves and captures of this bus to save. */
  file() {
    return null;
  }

  async request(method, path, body) {
    const [, address, rest] = /^\/lines\/[^/]+\/stations\/(\d+)(.*)$/.exec(path) ?? [];
    if (address !== undefined) return this.#station(method, `/drives/${address}`, rest, body);
    if (path === "/stations" && method === "GET") return stations(await this.#ask("GET", "/drives"));
    if (path === "/stations") return this.#ask(method, "/drives", { address: body.address, device: body.device });
    if (path === "/lines") return { lines: [{ line: LINE, bus: "canopen", link: "CAN", rate_bits_per_second: 0 }] };
    if (path === `/lines/${LINE}`) return busOf(await this.#ask("GET", "/bus"));
    if (path === "/events/recent") {
      const recent = await this.#ask("GET", path);
      return { ...recent, events: recent.events.map(newsOf) };
    }
    return this.#ask(method, path.replace(`/lines/${LINE}`, "/bus"), body);
  }

  async #station(method, node, rest, body) {
    if (rest === "" && method === "GET") return stateOf(await this.#ask("GET", node));
    if (rest === "/samples") return { samples: [] };
    if (rest === "/keys") return this.#keys.press(this.#ask, node, body);
    if (rest === "/provoke" && body.provoked === false) return this.#ask("DELETE", `${node}/inputs`);
    if (rest === "/provoke") return this.#ask(method, `${node}/provoke`, { fault: body.fault });
    return this.#ask(method, node + rest, body);
  }
}

function stations({ time_seconds: time, drives }) {
  return { time_seconds: time, stations: drives.map(summary) };
}

function summary({ address, device, product, power, nmt_state: nmt, error_register: register, display }) {
  const fault = register ? { fault: `error register ${hex(register)}h`, text: "" } : null;
  const arrow = display.arrow ? [`turn ${display.arrow}`] : [];
  return {
    line: LINE,
    bus: "canopen",
    address,
    device,
    product,
    power,
    exchanging: nmt === "OPERATIONAL",
    bus_state: nmt,
    state: null,
    state_text: nmt ?? "silent",
    moving: false,
    fault,
    warning: null,
    display: { rows: display.lines, signs: [...arrow, ...display.signs], leds: display.leds },
    headline: [],
  };
}

function stateOf(node) {
  const { inputs, input_ranges: ranges, does_not_move: reasons, emcy_history: history } = node;
  const turns = inputs.shaft_revolutions;
  return {
    ...summary(node),
    time_seconds: node.time_seconds,
    words: node.words.map(({ object, name, value, bits }) => ({ key: object.slice(0, 4), name: `${object} ${name}`, value, bits: bits.map(bitOf) })),
    values: turns === undefined ? [] : [{ key: "shaft", name: "Shaft", unit: "turns", value: turns, group: "motion", digits: 2 }],
    process: node.pdos.map(processOf),
    inputs: ranges.map((range) => ({ ...range, value: inputs[range.input], unit: UNITS[range.input.split("_").at(-1)] ?? null })),
    keys: node.keys,
    faults: node.faults.map((fault) => ({ ...fault, provoked: fault.present })),
    history: history.map(({ code, information, text }) => ({ code: `${code}h`, text, when: `${information}h` })),
    why: reasons === null ? null : { moving: false, reasons: reasons.map((text) => ({ text })), next: null },
    has: { objects: true, power: true },
  };
}

function bitOf({ bit, set, name }) {
  return { bit, set, name, meaning: "", used: name !== "", alarm: set && /fault|error/.test(name) && !/reset/.test(name) };
}

function processOf({ pdo, valid, cob_id: id, transmission_type: type, entries }) {
  const shown = entries.map(({ object, name, value }) => ({ name, place: object, value, unit: null }));
  return { key: pdo, name: `${pdo}, COB-ID ${id}h${valid ? "" : " off"}, type ${type}`, from_master: pdo.startsWith("R"), octets_hex: "", details: null, entries: shown };
}

function busOf({ nodes, ...bus }) {
  return { ...bus, stations: nodes.map(({ address, error_state: state }) => ({ address, error_state: state, counters: {} })), fault_kinds: FAULT_KINDS, devices: DEVICES };
}

function newsOf(news) {
  return { ...news, line: LINE, class: FAULTS.includes(news.kind) ? "fault" : "event" };
}

/** A frame with what its COB-ID is for, and of which node. */
function telegram({ time_seconds, id, remote, octets_hex: octets, of_node: own }) {
  const cob = Number.parseInt(id, 16);
  const node = cob > 0x80 && cob < 0x800 && SERVICES[cob >> 7] ? cob & 0x7f : null;
  const service = node === null ? ({ 0: "NMT", 0x80: "SYNC", 0x100: "TIME" }[cob] ?? "") : `${SERVICES[cob >> 7]} of node ${node}`;
  const object = SERVICES[cob >> 7]?.startsWith("SDO") ? objectOf(octets) : "";
  return { time_seconds, line: LINE, from_address: own ? node : null, to_address: own ? null : node, octets_hex: octets, text: `${id}  ${remote ? "remote request" : octets}  ${service}${object}`, mark: null };
}

/** The object that an SDO frame names: command, index low octet first, subindex. */
function objectOf(octets) {
  const [command, low, high, sub] = octets.split(" ");
  // Segments carry no object.
  return sub === undefined || Number.parseInt(command, 16) >> 5 === 0 ? "" : ` ${high}${low}h:${sub}`;
}

function hex(number) {
  return number.toString(16).toUpperCase().padStart(2, "0");
}

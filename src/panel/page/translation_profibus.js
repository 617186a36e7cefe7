// Drives, drives of PROFIDRIVE version 2, and stations from a GSD on PROFIBUS as stations.
import { Keys } from "./translation_keys.js";
import { driveState, driveSummary, HEALTHY, sampleOf } from "./translation_drive.js";

const LINE = "line";
/** Where each kind of station has its routes. */
const ROUTES = { drive: "/drives", gsd: "/stations", ppo: "/ppo-drives" };
const NEWS = { command_refused: "refusal", job_refused: "refusal", fault: "fault" };
const OUTPUTS = { unowned: "no master exchanges data", live: "Data_Exchange", cleared: "outputs cleared by the master", fail_safe: "Fail_Safe: no outputs", watchdog_expired: "watchdog expired" };
const DEVICES = [["ag03-1", "AG03/1"], ["ag03", "AG03"]].map(([device, text]) => ({ device, text }));
const NO_LOAD_CHANGE = 10;
/** How a fault on the line is written, and what the master gets (docs/faults.md). */
const FAULT_KINDS = Object.entries({
  "no-reply": "no reply",
  "late=20ms": "replies 20 ms later",
  duplicate: "replies twice",
  truncated: "replies without their end",
  "bit-errors=1": "one bit inverted",
  "wrong-fcs": "a wrong frame check sequence",
  "wrong-length": "wrong LE and LEr",
  "wrong-source": "the reply of another station",
  "noise=4": "noise before the reply",
  "drop-request": "requests are not heard",
  "diag-storm": "a diagnosis announced each time",
  "not-ready=2s": "Station_Not_Ready for 2 s",
  "refuse-prm": "Set_Prm is refused",
  "refuse-cfg": "Chk_Cfg is refused",
  "lose-prm": "the slave waits for Set_Prm again",
  "pkw-delay=10": "PKW answers 10 exchanges later",
  "pkw-wrong-ak": "PKW answers with a wrong AK",
  "pkw-wrong-pnu": "PKW answers with a wrong PNU",
  "pkw-torn": "PKW answers torn in two",
}).map(([fault, text]) => ({ fault, text }));

export class Profibus {
  #ask;
  #keys = new Keys();
  /** The kind of each station, by its address. */
  #kinds = new Map();
  /** Stations that the stream of all drives does not tell of. */
  #others = [];

  constructor(ask) {
    this.#ask = ask;
  }

  query({ station, kinds, interval_milliseconds: interval }) {
    return { kinds: kinds.join(","), interval_milliseconds: interval, ...(station === null ? {} : { address: station.address }) };
  }

  event(name, data) {
    if (name === "state" && data.drives) return [name, { time_seconds: data.time_seconds, stations: [...data.drives.map(driveSummary), ...this.#others].map(placed) }];
    if (name === "state") return [name, stateOf(data)];
    if (name === "news") return [name, newsOf(data)];
    return [name, name === "telegram" ? { ...data, line: LINE } : data];
  }

  /** Where a file is to be had, null if there is none. */
  file(path) {
    const [, address, rest] = /^\/lines\/[^/]+\/stations\/(\d+)(.*)$/.exec(path) ?? [];
    if (address === undefined) return path.replace(`/lines/${LINE}`, "");
    return this.#kinds.get(Number(address)) === "drive" ? `/drives/${address}${rest}` : null;
  }

  async request(method, path, body) {
    const [, address, rest] = /^\/lines\/[^/]+\/stations\/(\d+)(.*)$/.exec(path) ?? [];
    if (address !== undefined) return this.#station(method, Number(address), rest, body);
    if (path === "/stations" && method === "GET") return this.#stations();
    if (path === "/stations") return this.#ask(method, "/drives", { address: body.address, model: body.device });
    if (path === "/lines") return { lines: [{ line: LINE, bus: "profibus", link: "PROFIBUS" }] };
    if (path === `/lines/${LINE}`) return { ...(await this.#ask("GET", "/bus")), fault_kinds: FAULT_KINDS, devices: DEVICES };
    if (path === "/events/recent") {
      const recent = await this.#ask("GET", path);
      return { ...recent, events: recent.events.map(newsOf) };
    }
    return this.#ask(method, path.replace(`/lines/${LINE}`, "/bus"), body);
  }

  async #stations() {
    const [{ drives, time_seconds }, { stations }, { ppo_drives: ppo }] = await Promise.all(Object.values(ROUTES).map((route) => this.#ask("GET", route)));
    this.#kinds = new Map([["drive", drives], ["gsd", stations], ["ppo", ppo]].flatMap(([kind, list]) => list.map(({ address }) => [address, kind])));
    this.#others = [...stations.map(gsdSummary), ...ppo.map(ppoSummary)];
    return { time_seconds, stations: [...drives.map(driveSummary), ...this.#others].map(placed) };
  }

  async #station(method, address, rest, body) {
    if (!this.#kinds.has(address)) await this.#stations();
    const kind = this.#kinds.get(address) ?? "drive";
    const base = `${ROUTES[kind]}/${address}`;
    if (rest === "" && method === "GET") return stateOf(await this.#ask("GET", base));
    if (rest === "/samples") return kind === "drive" ? { samples: (await this.#ask("GET", `${base}/samples`)).samples.map(sampleOf) } : { samples: [] };
    if (rest === "/keys") return this.#keys.press(this.#ask, base, body);
    if (rest === "/provoke" && body.provoked === false) return this.#ask("PATCH", `${base}/inputs`, await this.#healthy(base, body.fault));
    if (rest === "/provoke") return this.#ask(method, `${base}/provoke`, { fault: body.fault });
    if (rest === "/inputs" && kind === "ppo") return this.#ppoInputs(base, method === "DELETE" ? { warning_number: 0, load_percent: NO_LOAD_CHANGE } : body);
    if (rest === "/parameters") return { parameters: (await this.#ask("GET", base + rest)).parameters.map(parameterOf) };
    return this.#ask(method, base + rest.replace(/^(\/parameters\/\d+)\.(\d+)$/, "$1?subindex=$2"), body);
  }

  /** The inputs that take the cause of a fault back, of those that the drive has. */
  async #healthy(base, fault) {
    const { inputs } = driveState(await this.#ask("GET", base));
    const known = new Set(inputs.map(({ input }) => input));
    return Object.fromEntries(Object.entries(HEALTHY[fault] ?? {}).filter(([input]) => known.has(input)));
  }

  async #ppoInputs(base, { fault_number: fault, warning_number: warning, load_percent: load }) {
    if (fault !== undefined) await this.#ask("POST", `${base}/fault`, { number: fault });
    if (warning !== undefined) await this.#ask("PUT", `${base}/warning`, { number: warning });
    if (load !== undefined) await this.#ask("PUT", `${base}/load`, { percent: load });
  }
}

function placed(station) {
  return { ...station, line: LINE, bus: "profibus" };
}

function stateOf(state) {
  if (state.modules) return placed(gsdState(state));
  return placed(state.stw_bits ? ppoState(state) : driveState(state));
}

function newsOf(news) {
  return { ...news, line: LINE, class: NEWS[news.kind] ?? "event" };
}

/** Of a drive, or of one of PROFIDRIVE version 2, which has its values as numbers. */
function parameterOf({ pnu, text, values, scale, unit, writable, access, ...parameter }) {
  const shown = (number) => (number === null ? "?" : scale === 1 ? String(number) : `${number} (${Number((number * scale).toPrecision(6))})`);
  const numbers = values && `${values.slice(0, 4).map(shown).join(", ")}${values.length > 4 ? ", ..." : ""} ${unit}`;
  return { ...parameter, key: String(pnu), text: text ?? numbers, access: access ?? (writable ? "read_write" : "read_only") };
}

function gsdSummary({ vendor, model, outputs_are: outputs, faulty, ...station }) {
  return {
    ...station,
    device: "gsd-station",
    product: `${vendor} ${model}`,
    power: null,
    exchanging: station.dp_state === "DATA-EXCH",
    bus_state: station.dp_state,
    state: null,
    state_text: OUTPUTS[outputs] ?? outputs,
    fault: faulty ? { fault: "diagnosis", text: "raised" } : null,
    warning: outputs === "live" || outputs === "unowned" ? null : (OUTPUTS[outputs] ?? outputs),
    display: null,
    headline: [],
  };
}

function slaveValues({ ident_number: ident, watchdog_milliseconds: watchdog }) {
  const number = `0x${ident.toString(16).toUpperCase().padStart(4, "0")}`;
  return [
    { key: "ident", name: "Ident number", unit: null, value: number, group: "slave" },
    { key: "watchdog", name: "Watchdog", unit: "ms", value: watchdog, group: "slave" },
  ];
}

/** The newest refused telegram, as long as it keeps the master from exchanging data. */
function refusalOf({ dp_state: dp, last_refusal: refusal }) {
  return dp === "DATA-EXCH" || !refusal ? null : { text: refusal };
}

function counted(counters) {
  return Object.entries(counters).map(([key, value]) => ({ key, name: key.replaceAll("_", " "), unit: null, value }));
}

function hexOf(octets) {
  return octets.map((octet) => octet.toString(16).toUpperCase().padStart(2, "0")).join(" ");
}

function gsdState(station) {
  const side = ({ slot, name }, what, octets, forced) => ({ key: `slot${slot} ${what}`, slot, name: `Slot ${slot}: ${name}`, from_master: what === "outputs", octets_hex: hexOf(octets), forced_hex: forced && hexOf(forced), details: null, entries: [] });
  const sides = (module) => [
    ...(module.inputs.length > 0 || module.outputs.length === 0 ? [side(module, "inputs", module.inputs, module.forced)] : []),
    ...(module.outputs.length > 0 ? [side(module, "outputs", module.outputs)] : []),
  ];
  return {
    ...gsdSummary(station),
    values: slaveValues(station),
    process: station.modules.flatMap(sides),
    last_refusal: refusalOf(station),
    diagnosis: station.diagnosis,
    counters: counted(station.counters),
    has: { modules: true },
  };
}

function ppoSummary({ ppo, fault, warning, faults, warnings, ...drive }) {
  const numbers = (list) => (list?.length > 0 ? list.join(", ") : "");
  return {
    ...drive,
    device: "ppo-drive",
    product: ppo ?? "PROFIDRIVE version 2",
    power: null,
    exchanging: drive.dp_state === "DATA-EXCH",
    bus_state: drive.dp_state,
    state: fault ? "fault" : drive.operation_enabled ? "enabled" : "ready",
    state_text: drive.state,
    moving: drive.turning ?? drive.speed_rpm !== 0,
    fault: fault ? { fault: numbers(faults) || "active", text: "" } : null,
    warning: warning ? `warning ${numbers(warnings)}` : null,
    display: null,
    headline: [
      { key: "speed", name: "Speed", unit: "rpm", value: Math.round(drive.speed_rpm) },
      { key: "actual", name: "Actual value", unit: "%", value: drive.actual_percent, digits: 1 },
    ],
  };
}

function ppoState(drive) {
  const word = (key, name, value, bits) => ({ key, name, value, bits: bits.map((bit) => ({ ...bit, meaning: "", used: true, alarm: key === "zsw" && bit.bit === 3 && bit.set })) });
  const said = (words) => (words === null ? null : `${words.words_hex}  ${words.text}`);
  const amount = (key, name, unit, value, more = {}) => ({ key, name, unit, value, group: "motion", ...more });
  const number = (input, text, value, high, unit = null) => ({ input, text, value, low: 0, high, unit, step: 1, may_be_null: false });
  return {
    ...ppoSummary(drive),
    words: [word("stw", "Control word", drive.stw, drive.stw_bits), word("zsw", "Status word", drive.zsw, drive.zsw_bits)],
    values: [
      amount("speed", "Speed", "rpm", drive.speed_rpm, { curve: true, digits: 0 }),
      amount("actual", "Actual value", "%", drive.actual_percent, { curve: true, digits: 1 }),
      amount("setpoint", "Setpoint", "%", drive.setpoint_percent, { setpoint_of: "actual", digits: 1 }),
      amount("reference", "Reference speed", "rpm", drive.reference_speed_rpm, { digits: 0 }),
      amount("torque", "Torque", "%", drive.torque_percent, { digits: 0 }),
      amount("current", "Current", "A", drive.current_amperes, { curve: true, digits: 1 }),
      ...slaveValues(drive),
    ],
    process: [
      { key: "outputs", name: "Parameter channel and STW, setpoint", from_master: true, octets_hex: "", details: said(drive.pkw_job), entries: [] },
      { key: "inputs", name: "Parameter channel and ZSW, actual value", from_master: false, octets_hex: "", details: said(drive.pkw_reply), entries: [] },
    ],
    inputs: [
      number("fault_number", "raise the fault of this number", drive.faults[0] ?? 0, 65535),
      number("warning_number", "warning, 0 ends it", drive.warnings[0] ?? 0, 65535),
      number("load_percent", "load, of the rated torque", drive.load_percent, 1000, "%"),
    ],
    history: [...drive.faults.map((code) => ({ code, text: "not acknowledged (947)" })), ...drive.faults_acknowledged.map((code) => ({ code, text: "acknowledged" })), ...drive.warnings.map((code) => ({ code, text: "warning (953)" }))],
    last_refusal: refusalOf(drive),
    why: { moving: drive.turning, reasons: drive.why.map((text) => ({ text })), next: null },
    counters: counted(drive.counters),
    has: { parameters: true },
  };
}

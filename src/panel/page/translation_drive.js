// The drives AG03 and AG03/1 as stations.

/** What the API calls the models, and the manuals. The test facts::the_page_has_the_models_of_the_crate compares them. */
export const MODELS = {
  ag03: "AG03",
  "ag03-1": "AG03/1",
};
/** Bits of the system status word that are warnings (ag03.md 6). */
const WARNINGS = [[12, "battery low"], [13, "current"], [15, "lag error"]];
/** Levels that need somebody, by word and bit. */
const ALARMS = { stw: [], zsw: [3, 6, 7, 14], ssw: [5, 6, 8, 10, 12, 13, 15] };
const WORDS = { stw: "Control word", zsw: "Status word", ssw: "System status word" };
const MOTOR = { released: "released", in_control: "in control", shorted: "shorted" };
const EEPROM = { in_memory: "in memory", writing: "is being written", stored: "in its file", failed: "NOT written, see the log" };
const TERMINATOR = { inactive: "off", active: "on", half: "half on: set SW9 and SW10 alike" };
/** What the switches set (chapters 2.4, 7.8 and 7.10). */
const SWITCHES = [...[1, 2, 4, 8, 16, 32, 64].map((weight, index) => `SW${index + 1}, address ${weight}`), "SW8, factory reset", "SW9, bus terminator", "SW10, bus terminator"];
/** States in which the shaft turns by itself. */
const UNDER_WAY = ["travelling with velocity", "inching", "inching by key", "inching by key ends", "travel job active"];
const ACKNOWLEDGE = "the master acknowledges with STW.7 from 0 to 1 and gives OFF1 (STW.0 = 0) once";

/** The inputs: name, text, unit, low, high, value of a healthy drive, and the model that has it. */
const INPUTS = [
  ["control_supply_volts", "Control supply", "V", 0, 60, 24],
  ["output_supply_volts", "Output stage supply", "V", 0, 60, 24, "ag03-1"],
  ["enable", "Enable input", null, null, null, true, "ag03"],
  ["blocked", "Shaft blocked", null, null, null, false],
  ["load_torque_newton_metres", "Load, pulls clockwise", "Nm", -10, 10, 0],
  ["friction_torque_newton_metres", "Friction", "Nm", 0, 10, 0],
  ["battery_volts", "Battery", "V", 0, 4, 3],
  ["ambient_temperature_celsius", "Air", "°C", -50, 120, 25],
  ["stage_temperature_celsius", "Output stage temperature", "°C", -50, 150, null],
  ["dc_link_volts", "Intermediate circuit", "V", 0, 60, null],
  ["encoder_fault", "SIN/COS error of the encoder", null, null, null, false, "ag03-1"],
  ["internal_fault", "Internal error", null, null, null, false],
];
/** The faults: what makes each (docs/drive.md), and the model that has it. */
const FAULTS = {
  A: ["supply below 18 V and more than 200 mA, once the shaft is commanded to turn"],
  B: ["shaft blocked, once the shaft is commanded to turn"],
  C: ["more than 2.4 A for more than 4 s, once the shaft is commanded to turn"],
  D: ["output stage above 90 °C"],
  E: ["SIN/COS monitoring", "ag03-1"],
  F: ["internal error"],
  G: ["intermediate circuit above 35 V"],
  J: ["battery below 2.2 V", "ag03-1"],
};
/** The inputs that take the cause of a fault back. */
export const HEALTHY = {
  A: { control_supply_volts: 24, output_supply_volts: 24 },
  B: { blocked: false },
  C: { friction_torque_newton_metres: 0 },
  D: { stage_temperature_celsius: null },
  E: { encoder_fault: false },
  F: { internal_fault: false },
  G: { dc_link_volts: null },
  J: { battery_volts: 3 },
};

/** Positions in increments as they are, in hundredths of mm as mm. */
function length(value, unit) {
  const millimetres = unit === "hundredth_millimetres";
  return { value: value === null || value === undefined || !millimetres ? (value ?? null) : value / 100, unit: millimetres ? "mm" : "inc", digits: millimetres ? 2 : 0 };
}

function ledOf(led, { pattern, lit, ...rhythm }, text) {
  const glow = pattern === "alternating" ? (lit ? "on" : "off") : pattern;
  return { ...rhythm, led, colour: led.split(" ").at(-1), glow, text };
}

function ledText({ pattern, blinks }, fault, on) {
  if (pattern === "blinking") return `${blinks} ${blinks === 1 ? "blink" : "blinks"}: fault ${fault}`;
  return pattern === "alternating" ? "alternates: reset" : pattern === "on" ? on : "dark";
}

function faceState({ power, fault, state, operation_enabled: enabled }) {
  if (power !== "on") return "off";
  if (fault !== null) return "fault";
  if (state === "turn-on disabled") return "inhibited";
  return enabled ? "enabled" : state.startsWith("not ready") ? "not_ready" : "ready";
}

/** What is seen of a drive at a glance. */
export function driveSummary(drive) {
  const { model, gear_ratio: gear, fault, warning, ssw, status_led: status, bus_led: bus, dp_state: dp } = drive;
  const lamps = [ledOf("status green", status, ledText(status, fault, model === "ag03" ? "lit: enabled" : "lit: supplied")), ledOf("bus orange", bus, ledText(bus, fault, "lit: Data_Exchange"))];
  return {
    address: drive.address,
    device: model,
    product: `${MODELS[model] ?? model}, gear ${gear}:1`,
    power: drive.power,
    presence: drive.presence,
    exchanging: dp === "DATA-EXCH",
    bus_state: dp,
    owner_address: drive.owner_address,
    state: faceState(drive),
    state_text: drive.state,
    moving: drive.travelling,
    fault: fault === null ? null : { fault, text: drive.faults?.latched?.text ?? fault },
    warning: warning ? (WARNINGS.find(([bit]) => (ssw >> bit) & 1)?.[1] ?? "warning") : null,
    display: { rows: [], signs: [], leds: lamps },
    headline: [
      { key: "position", name: "Position", ...length(drive.position_user_units, drive.user_unit) },
      { key: "speed", name: "Speed", unit: "rpm", value: drive.velocity_rpm },
      { key: "current", name: "Current", unit: "mA", value: drive.current_milliamperes },
    ],
  };
}

/** The complete state of a drive. */
export function driveState(drive) {
  const { model, keys, faults, switches, words, counters, eeprom, last_refusal: refusal, time_seconds } = drive;
  const has = (only) => only === undefined || only === model;
  const bits = (name) => words[name].bits.map((bit) => ({ ...bit, alarm: bit.used && bit.set && ALARMS[name].includes(bit.bit) }));
  return {
    ...driveSummary(drive),
    time_seconds,
    words: Object.entries(WORDS).map(([key, name]) => ({ key, name, value: words[key].value, bits: bits(key) })),
    values: valuesOf(drive),
    process: processOf(drive.ppo, drive.motion),
    inputs: inputsOf(drive),
    keys: [{ key: "key_1", text: "Key 1, clockwise", pressed: keys.key_1_pressed }, { key: "key_2", text: "Key 2, counter-clockwise", pressed: keys.key_2_pressed }],
    faults: Object.entries(FAULTS).filter(([, [, only]]) => has(only)).map(([fault, [text]]) => ({ fault, text, present: causeOf(faults, fault), provoked: faults.provoked.some(({ code }) => code === fault) })),
    switches: { positions: switches.positions, names: SWITCHES, text: switchesText(drive) },
    history: faults.buffer.map(({ code, text }) => ({ code, text })),
    last_refusal: refusal,
    why: whyOf(drive),
    counters: [{ key: "faults", name: "faults (PNU 952)", value: faults.count, unit: null }, ...Object.entries(counters).map(([key, value]) => ({ key, name: key.replaceAll("_", " "), unit: null, value }))],
    eeprom: EEPROM[eeprom] ?? eeprom,
    has: { parameters: true, samples: true, switches: true, power: true },
  };
}

/** The inputs that the model has; ranges are those that the drive tells, if it does. */
function inputsOf({ model, inputs, measured, input_ranges: ranges }) {
  const told = new Map((ranges ?? []).map((range) => [range.input, range]));
  const known = INPUTS.filter(([input, , , , , , only]) => (ranges ? told.has(input) : only === undefined || only === model));
  return known.map(([input, text, unit, low, high, nominal]) => {
    const range = told.get(input) ?? { low, high, may_be_null: low !== null && nominal === null };
    return { ...range, input, text, unit, nominal, value: inputs[input], calculated: measured[input] };
  });
}

function causeOf({ latched, causes, provoked }, fault) {
  return provoked.some(({ code }) => code === fault) || (latched?.code === fault && causes.length > 0);
}

function valuesOf({ motion, measured, model, dp, state }) {
  const { user_unit: unit } = motion;
  const volts = (key, name) => ({ key, name, unit: "V", value: measured[`${key}_volts`], digits: key === "battery" ? 2 : 1, group: "measured" });
  const released = state === "travelling with velocity";
  const moved = (key, name, value, more) => ({ key, name, ...length(value, unit), group: "motion", ...more });
  return [
    moved("position", "Position", motion.position_user_units, { curve: true }),
    { key: "speed", name: "Speed", unit: "rpm", value: motion.velocity_rpm, group: "motion", curve: true },
    { key: "current", name: "Current", unit: "mA", value: measured.current_milliamperes, group: "measured", curve: true },
    // Of the job in progress: what HSW is meanwhile is a number on the bus and no target.
    moved("target", "Target", motion.target_user_units, { setpoint_of: "position" }),
    moved("to_go", "To go", motion.distance_to_go_user_units, {}),
    ...(released ? [{ key: "speed_setpoint", name: "Speed setpoint", unit: "rpm", value: motion.setpoint_rpm, group: "motion", setpoint_of: "speed" }] : []),
    { key: "stage", name: "Output stage", unit: "°C", value: measured.stage_temperature_celsius, digits: 1, group: "measured" },
    volts("dc_link", "Intermediate circuit"),
    ...(model === "ag03-1" ? [volts("output_supply", "Output supply")] : []),
    volts("control_supply", "Control supply"),
    volts("battery", "Battery"),
    { key: "motor", name: "Motor", unit: null, value: MOTOR[motion.motor] ?? motion.motor, group: "measured" },
    // Counter-clockwise counts positive there, clockwise here.
    { key: "shaft", name: "Shaft", unit: "turns", value: -motion.shaft_revolutions, digits: 2, group: "motion" },
    { key: "watchdog", name: "Watchdog", unit: "ms", value: dp.watchdog_milliseconds, group: "slave" },
  ];
}

function processOf({ outputs, inputs }, { user_unit: unit }) {
  const side = (key, name, fromMaster, words, value, word) => ({
    key,
    name,
    from_master: fromMaster,
    octets_hex: words.words_hex,
    details: `${words.pkw.words_hex}  ${words.pkw.text}`,
    entries: [{ name: word, place: "octets 11 to 14", ...length(value, unit) }],
  });
  return [side("outputs", "PPO outputs", true, outputs, outputs.hsw, "HSW"), side("inputs", "PPO inputs", false, inputs, inputs.hiw, "HIW")];
}

function switchesText({ switches, address }) {
  const digits = switches.positions.map((on) => (on ? "1" : "0")).join("");
  const meaning = switches.factory_reset ? `factory reset of ${switches.factory_reset} parameters` : `address ${switches.address}`;
  const waits = switches.address !== address || switches.factory_reset ? " from the next power-on" : "";
  return `${digits.slice(0, 7)} ${digits.slice(7, 8)} ${digits.slice(8)}: ${meaning}${waits}, terminator ${TERMINATOR[switches.terminator]}`;
}

function whyOf({ start, faults, state, motion }) {
  const { latched, causes, provoked } = faults;
  const moving = motion.moving || UNDER_WAY.includes(state);
  if (latched === null) return { moving, reasons: start.possible ? [] : start.reasons, next: start.possible || moving ? null : start.next };
  const present = causes.length > 0 || provoked.some(({ code }) => code === latched.code);
  return { moving: false, reasons: start.reasons, next: present ? `remove its cause. Then ${ACKNOWLEDGE}` : (start.next ?? ACKNOWLEDGE) };
}

/** A sample of a drive, by the keys of its values. */
export function sampleOf(sample) {
  const { user_unit: unit, position_user_units: position, target_user_units: target } = sample;
  return {
    time_seconds: sample.time_seconds,
    position: length(position, unit).value,
    target: length(target, unit).value,
    speed: sample.velocity_rpm,
    speed_setpoint: sample.setpoint_rpm,
    current: sample.current_milliamperes,
  };
}

// The state of a drive in one word and one kind. The kind is a shape on the page, and a colour besides.

/** Short words for the states of the drive (ag03.md 8), as a tile has room for. */
const SHORT = {
  "not ready: a supply is missing": "no supply",
  "ready-to-run": "ready-to-run",
  "operation enabled": "enabled",
  "operation disabled, the shaft still brakes": "disabling",
  "travel job active": "travels",
  "travel job paused, brakes": "pausing",
  "travel job interrupted by the torque deactivation, brakes": "torque limit",
  "travel job paused": "paused",
  "travel job interrupted by the torque deactivation": "torque limit",
  "travel job stopped, the shaft still brakes": "stopping",
  inching: "inching",
  "travelling with velocity": "turns",
  "inching by key": "key inching",
  "inching by key ends": "key inching",
  "turn-on disabled": "turn-on dis.",
};

/** Bits of the system status word that are warnings (ag03.md 6), and short words for them. */
const WARNINGS = [[12, "battery low"], [13, "current"], [15, "lag error"]];

/** `{ kind, word }` of a drive; `word` is short. Kinds: fault, warning, moving, ready, idle, off. */
export function stateOf(drive) {
  if (drive.power === "factory_reset") return { kind: "warning", word: "reset" };
  if (drive.power === "off") return { kind: "off", word: "off" };
  if (drive.fault !== null) return { kind: "fault", word: `fault ${drive.fault}` };
  if (drive.presence !== "active") return { kind: "off", word: drive.presence === "joining" ? "listening" : "address taken" };
  const word = SHORT[drive.state] ?? drive.state;
  if (drive.warning) return { kind: "warning", word: warningOf(drive) };
  if (drive.state === "turn-on disabled") return { kind: "warning", word };
  if (drive.travelling) return { kind: "moving", word };
  if (drive.dp_state !== "DATA-EXCH") return { kind: "idle", word: "no exchange" };
  return { kind: drive.operation_enabled ? "ready" : "idle", word };
}

/** Which warning, the gravest first; "warning" of one that is new to this page. */
function warningOf({ ssw }) {
  return WARNINGS.find(([bit]) => (ssw >> bit) & 1)?.[1] ?? "warning";
}

/**
 * The models: what the API calls them, and the manuals. The test facts::the_page_has_the_models_of_the_crate compares
 * them.
 */
export const MODELS = {
  ag03: "AG03",
  "ag03-1": "AG03/1",
};

export function modelName({ model }) {
  return MODELS[model] ?? model;
}

/** What positions are counted in, and how they are told: in increments as they are, hundredths of mm as mm. */
const UNITS = { increments: { name: "inc", each: 1, digits: 0 }, hundredth_millimetres: { name: "mm", each: 100, digits: 2 } };

/** The unit of the positions of a drive: `{ name, each, digits }`. Always the same object for the same unit. */
export function unitOf({ user_unit }) {
  return UNITS[user_unit] ?? UNITS.increments;
}

/** The position of a drive in the overview, with its unit if the server says which. */
export function positionOf(drive) {
  const { position_user_units: position, user_unit } = drive;
  if (user_unit === undefined) return String(position);
  const unit = unitOf(drive);
  return `${inUnit(position, unit)} ${unit.name}`;
}

/** A position as text, without its unit. */
export function inUnit(position, { each, digits }) {
  return (position / each).toFixed(digits);
}

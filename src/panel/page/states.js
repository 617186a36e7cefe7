// The state of a drive in one word and one kind. The kind is a shape on the page, and a colour besides.

/** Short words for the states of the drive (ag03.md 8), as a tile has room for. */
const SHORT = {
  "not ready: a supply is missing": "no supply",
  "ready-to-run": "ready-to-run",
  "operation enabled": "enabled",
  "operation disabled, the shaft still brakes": "disabling",
  "travel job active": "travels",
  "travel job paused": "paused",
  "travel job interrupted by the torque deactivation": "torque limit",
  "travel job stopped, the shaft still brakes": "stopping",
  inching: "inching",
  "travelling with velocity": "turns",
  "inching by key": "key inching",
  "inching by key ends": "key inching",
  "turn-on disabled": "turn-on dis.",
};

/** `{ kind, word }` of a drive; `word` is short. Kinds: fault, warning, moving, ready, idle, off. */
export function stateOf(drive) {
  if (drive.power === "factory_reset") return { kind: "warning", word: "reset" };
  if (drive.power === "off") return { kind: "off", word: "off" };
  if (drive.fault !== null) return { kind: "fault", word: `fault ${drive.fault}` };
  if (drive.presence !== "active") return { kind: "off", word: drive.presence === "joining" ? "listening" : "address taken" };
  const word = SHORT[drive.state] ?? drive.state;
  if (drive.warning) return { kind: "warning", word: "warning" };
  if (drive.state === "turn-on disabled") return { kind: "warning", word };
  if (drive.travelling) return { kind: "moving", word };
  if (drive.dp_state !== "DATA-EXCH") return { kind: "idle", word: "no exchange" };
  return { kind: drive.operation_enabled ? "ready" : "idle", word };
}

export function modelName(drive) {
  return drive.model === "ag03-1" ? "AG03/1" : "AG03";
}

/** A position with the unit the drive counts in. */
export function unitOf(motion) {
  return motion.user_unit === "increments" ? "inc" : "0.01 mm";
}

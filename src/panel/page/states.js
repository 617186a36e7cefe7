// The state of a station in one word and one kind. The kind is a shape on the page, and a colour besides.
import { numberText } from "./dom.js";

const PRESENCE = { joining: "listening", refused: "address taken" };

/** `{ kind, word }` of a station. Kinds: fault, warning, moving, ready, idle, off. */
export function stateOf(station) {
  const { power, fault, presence, warning, state, moving, bus_state: bus } = station;
  if (power === "factory_reset") return { kind: "warning", word: "reset" };
  if (power === "off") return { kind: "off", word: "off" };
  if (fault) return { kind: "fault", word: `fault ${fault.fault}` };
  if (presence && presence !== "active") return { kind: "off", word: PRESENCE[presence] ?? presence };
  const word = station.state_text ?? bus ?? "";
  if (warning) return { kind: "warning", word: warning };
  if (state === "inhibited") return { kind: "warning", word };
  if (moving) return { kind: "moving", word };
  if (!isExchanging(station)) return { kind: "idle", word: bus ?? word };
  return { kind: state === null || state === undefined || state === "enabled" ? "ready" : "idle", word };
}

/** Whether a master works with it. */
function isExchanging({ exchanging, owner_address: owner }) {
  return exchanging ?? (owner !== null && owner !== undefined);
}

/** A fault in words, with its code once. */
export function faultText({ fault, text }) {
  if (!text || text === fault) return fault;
  return text.startsWith(fault) ? text : `${fault} (${text})`;
}

/** A value with its unit. */
export function valueText({ value, unit, digits }) {
  return unit && value !== null ? `${numberText(value, digits)} ${unit}` : numberText(value, digits);
}

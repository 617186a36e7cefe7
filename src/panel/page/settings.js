// Settings of a station in a file, and what differs from one.
import { html } from "./dom.js";

/** The form of the file. */
const FORM = 1;

/** Saves a text as a file. */
export function saveText(name, text, type) {
  const link = html("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Saves settings `{ key, name, value }` of a kind. */
export function save(name, kind, settings) {
  saveText(name, `${JSON.stringify({ profidrive: FORM, kind, settings }, null, 1)}\n`, "application/json");
}

/** The settings in a file. Throws a sentence. */
export function read(text, kind) {
  let file;
  try {
    file = JSON.parse(text);
  } catch {
    throw new RangeError("The file is no JSON. Nothing is written.");
  }
  if (file?.profidrive !== FORM || file.kind !== kind || !Array.isArray(file.settings)) {
    throw new RangeError(`The file has no ${kind} that this page has saved. Nothing is written.`);
  }
  const wrong = file.settings.find(({ key, value }) => typeof key !== "string" || !["number", "string"].includes(typeof value));
  if (wrong) throw new RangeError(`The file has a setting without key or value: ${JSON.stringify(wrong)}. Nothing is written.`);
  return file.settings;
}

/** The settings that the items have otherwise. */
export function differences(settings, items, numberOf) {
  return settings.filter(({ key, value }) => items.some((item) => item.key === key && numberOf(item) !== value));
}

// What is copied for another program.
import { button, say } from "./dom.js";

const SAID_MS = 1500;

async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    // Not every browser gives its clipboard to a page of another machine.
    window.prompt("Copy this:", text);
    return false;
  }
}

/** A button that copies what `text()` gives; it says so. `what` is what it copies. */
export function copyButton(name, what, text) {
  const made = button(name, async () => {
    if (!(await copy(text()))) return;
    say(made, "Copied");
    setTimeout(() => say(made, name), SAID_MS);
  }, { class: "copy", "aria-label": what });
  return made;
}

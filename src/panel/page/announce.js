// What is said to those who do not see the page: faults and refusals, and nothing that changes by itself.
import { html, say } from "./dom.js";

/** Of several in this time only the newest is said: who listens cannot follow more. */
const PACE_MS = 1000;

class Region {
  #element;
  #timer = 0;
  #next = null;

  constructor(role) {
    this.#element = html("p", { class: "announced", role });
    document.body.append(this.#element);
  }

  /** What is said already is not said again. */
  speak(text) {
    this.#next = text;
    if (this.#timer === 0) this.#flush();
  }

  #flush() {
    this.#timer = 0;
    if (this.#next === null) return;
    say(this.#element, this.#next);
    this.#next = null;
    this.#timer = setTimeout(() => this.#flush(), PACE_MS);
  }
}

const faults = new Region("alert");
const refusals = new Region("status");

/** A fault, of a station or of the connection. */
export function announceFault(text) {
  faults.speak(text);
}

/** Something was asked for and not done. */
export function announceRefusal(text) {
  refusals.speak(text);
}

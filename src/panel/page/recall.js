// What was before the page came, or while it was not connected: events that the server has kept.
import { request } from "./api.js";

/** Numbers of events that are remembered, so that none is shown twice. */
const REMEMBERED = 5000;

export class Recall {
  #seen = new Set();
  #started = null;
  #asking = false;

  /** Whether an event is new here. Those without a number always are. */
  isNew({ number }) {
    if (number === null || number === undefined) return true;
    if (this.#seen.has(number)) return false;
    this.#seen.add(number);
    if (this.#seen.size > REMEMBERED) this.#seen.delete(this.#seen.values().next().value);
    return true;
  }

  /**
   * The events that the server has kept: `{ all, fresh, again }`, `fresh` are those that were not shown, `again` says that
   * the emulator was started again since the last time. Null if they are not to be had: the stream says what is wrong.
   */
  async events() {
    if (this.#asking) return null;
    this.#asking = true;
    try {
      const { started_unix_seconds: started, events } = await request("GET", "/events/recent");
      const again = this.#started !== null && this.#started !== started;
      if (again) this.#seen.clear();
      this.#started = started;
      return { all: events, fresh: events.filter((event) => this.isNew(event)), again };
    } catch {
      return null;
    } finally {
      this.#asking = false;
    }
  }
}

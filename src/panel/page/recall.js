// What was before the page came, or while it was not connected: events and samples that the server has kept.
import { request } from "./api.js";

/** Numbers of events that are remembered, so that none is shown twice. */
const REMEMBERED = 5000;

export class Recall {
  #seen = new Set();
  #started = null;

  /** Whether an event is new here. Those without a number always are. */
  isNew({ number }) {
    if (number === null) return true;
    if (this.#seen.has(number)) return false;
    this.#seen.add(number);
    if (this.#seen.size > REMEMBERED) this.#seen.delete(this.#seen.values().next().value);
    return true;
  }

  /**
   * The events that the server has kept, of one station or of all: `{ all, fresh, again }`, `fresh` are those that were not
   * shown, `again` says that the emulator was started again since the last time.
   */
  async events(address) {
    const of = address === null ? "" : `?address=${address}`;
    const { started_unix_seconds: started, events } = await request("GET", `/events/recent${of}`);
    const again = this.#started !== null && this.#started !== started;
    if (again) this.#seen.clear();
    this.#started = started;
    return { all: events, fresh: events.filter((event) => this.isNew(event)), again };
  }

  /** The samples of a drive. */
  async samples(address) {
    const { samples } = await request("GET", `/drives/${address}/samples`);
    return samples;
  }
}

/**
 * What happened before or meanwhile, into the log; `address` is null for everybody's, `lineOf` makes a line of an event.
 * Resolves to all lines that the server has kept.
 */
export async function recallInto(log, recall, address, lineOf) {
  // Without it there is less to see, and nothing that is wrong; the stream says what is.
  const recalled = await recall.events(address).catch(() => null);
  if (recalled === null) return [];
  if (recalled.again) {
    log.beginAnew();
    log.add({ time_s: null, kind: "line", text: "the emulator was started again; its time begins at 0", stations: [] });
  }
  log.merge(recalled.fresh.map(lineOf));
  return recalled.all.map(lineOf);
}

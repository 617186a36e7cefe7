// The connection to the emulator: whether it is there, what was lost on the way, and that values are old without it.
import { announceFault } from "./announce.js";
import { many, say, mark } from "./dom.js";

/** For so long a loss is told: who sees it later, thinks that it goes on. */
const LOSS_TOLD_MS = 10_000;
const THINGS = { states: "sample", news: "event", telegrams: "telegram" };

export class Connection {
  #losses = [];
  #streaming = true;
  #sign = document.getElementById("connection");
  #main = document.getElementById("main");

  /** It is there, by a stream, or by a question once a second. */
  live(streaming = this.#streaming) {
    this.#streaming = streaming;
    if (this.#sign.dataset.kind === "lost") announceFault("Connected again.");
    const sum = (what) => this.#losses.reduce((sum, loss) => sum + (loss[what] ?? 0), 0);
    const lost = counts(Object.fromEntries(Object.keys(THINGS).map((what) => [what, sum(what)])));
    const how = streaming ? "live" : "live, once a second";
    mark(this.#sign, "data-kind", lost === "" && streaming ? "live" : "lossy");
    mark(this.#sign, "title", streaming ? "" : "Other readers have the streams: no telegrams here.");
    say(this.#sign, lost === "" ? how : `${how}, ${lost} lost`);
    mark(this.#main, "data-stale", false);
  }

  /** It is gone: every value on the page is one of before, and looks so. */
  gone(reason) {
    if (this.#sign.dataset.kind !== "lost") announceFault(`Not connected: ${reason}. The values are old.`);
    mark(this.#sign, "data-kind", "lost");
    say(this.#sign, `not connected: ${reason}. The values are old. Trying again ...`);
    mark(this.#main, "data-stale", true);
  }

  /** `lost` holds how many states, news and telegrams did not come; what was lost, in words. */
  loses(lost) {
    this.#losses.push({ ...lost, at: performance.now() });
    this.live();
    return counts(lost);
  }

  /** What was lost some time ago is not told any more. */
  paint() {
    if (this.#losses.length === 0 || performance.now() - this.#losses[0].at < LOSS_TOLD_MS) return;
    this.#losses.shift();
    if (this.#sign.dataset.kind !== "lost") this.live();
  }
}

/** What was lost, in words; "" if nothing was. */
function counts(lost) {
  return Object.entries(lost)
    .filter(([, count]) => count > 0)
    .map(([what, count]) => many(count, THINGS[what] ?? what))
    .join(", ");
}

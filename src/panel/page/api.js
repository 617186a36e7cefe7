// The HTTP API of the emulator: requests, and the stream of what happens.

const ROOT = "/api/v1";
const RETRY_MS = 1000;
/** Nothing for so long, and the stream is taken for dead: a state comes once a second at least. */
const SILENCE_MS = 4000;
/** An answer comes within this, or none does. */
const ANSWER_MS = 5000;
const NO_ANSWER = "the emulator does not answer";

/** A request that was refused, or reached nobody (`status` 0). `message` is a sentence for a person. */
export class Refused extends Error {
  constructor(message, status = 0) {
    super(message);
    this.status = status;
  }
}

/** Asks the server; the body and the answer are JSON. A server that is frozen reaches nobody either. */
export async function request(method, path, body) {
  let response;
  let text;
  try {
    response = await fetch(ROOT + path, {
      method,
      headers: body === undefined ? {} : { "content-type": "application/json" },
      body: body === undefined ? undefined : JSON.stringify(body),
      // The release of a key arrives even if the page goes at the same time.
      keepalive: body !== undefined,
      signal: AbortSignal.timeout(ANSWER_MS),
    });
    text = await response.text();
  } catch {
    throw new Refused(NO_ANSWER);
  }
  let answer = null;
  try {
    answer = text === "" ? null : JSON.parse(text);
  } catch {
    throw new Refused(`not understood: ${text.slice(0, 200)}`, response.status);
  }
  if (!response.ok) throw new Refused(answer?.detail ?? response.statusText, response.status);
  return answer;
}

/**
 * What happens, as it happens. Connects again by itself when the stream ends; `on` holds functions by event, `events` are
 * those there are, and `on.open()` and `on.closed(error)` for the connection itself.
 */
export class Stream {
  #source = null;
  #timer = 0;
  #silence = 0;
  /** Whether the server has taken the subscription. */
  #open = false;
  #on;
  #events;
  #query = "";

  constructor(on, events = ["state", "news", "telegram", "lost"]) {
    this.#on = on;
    this.#events = events;
    window.addEventListener("pagehide", () => this.#end());
    window.addEventListener("pageshow", ({ persisted }) => persisted && this.#connect());
  }

  /** Subscribes to something else. */
  subscribe(wanted) {
    this.#query = new URLSearchParams(wanted).toString();
    this.#connect();
  }

  #connect() {
    this.#end();
    const source = new EventSource(`${ROOT}/events?${this.#query}`);
    this.#source = source;
    source.addEventListener("open", () => {
      this.#open = true;
      this.#watch();
      this.#on.open();
    });
    source.addEventListener("error", () => this.#retry());
    for (const event of this.#events) {
      source.addEventListener(event, ({ data }) => {
        this.#watch();
        this.#on[event](JSON.parse(data));
      });
    }
    this.#watch();
  }

  /** A stream that says nothing for long is dead, even if nobody has said so. */
  #watch() {
    clearTimeout(this.#silence);
    this.#silence = setTimeout(() => {
      // Said at once: who asks a frozen server why gets no answer.
      this.#on.closed(new Refused(NO_ANSWER));
      this.#retry();
    }, SILENCE_MS);
  }

  #end() {
    clearTimeout(this.#timer);
    clearTimeout(this.#silence);
    this.#source?.close();
    this.#source = null;
    this.#open = false;
  }

  async #retry() {
    this.#end();
    const query = this.#query;
    this.#timer = setTimeout(() => this.#connect(), RETRY_MS);
    const address = new URLSearchParams(query).get("address");
    // An EventSource does not say why it ended; requests do.
    const reason = await (address === null ? request("GET", "/bus") : isThere(address)).then(
      () => whyRefused(query),
      (error) => error,
    );
    if (query === this.#query && !this.#open) this.#on.closed(reason);
  }
}

/** Whether a drive or a station of any kind has an address; the reason of the drive if none has. */
function isThere(address) {
  const other = () => request("GET", `/stations/${address}`).catch(() => request("GET", `/ppo-drives/${address}`));
  return request("GET", `/drives/${address}/inputs`).catch((error) => other().catch(() => Promise.reject(error)));
}

/** Why the stream is not to be had; one that is to be had after all is given up at once. */
async function whyRefused(query) {
  const asking = new AbortController();
  const limit = setTimeout(() => asking.abort(), ANSWER_MS);
  try {
    const response = await fetch(`${ROOT}/events?${query}`, { signal: asking.signal });
    if (response.ok) return new Refused("the stream ended");
    return new Refused((await response.json()).detail, response.status);
  } catch {
    return new Refused(NO_ANSWER);
  } finally {
    clearTimeout(limit);
    asking.abort();
  }
}

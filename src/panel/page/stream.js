// What happens, as it happens: a stream while this tab has one, else a question once a second.
import { NO_ANSWER, Refused, eventsAddress, request, stationOf } from "./api.js";

const RETRY_MS = 1000;
/** Nothing for so long, and the stream is taken for dead: a state comes once a second at least. */
const SILENCE_MS = 4000;
/** How often a tab without a stream asks. */
const POLL_MS = 1000;
/**
 * A browser holds six connections to a server, for all its tabs together, and a stream takes one for good. So many tabs
 * have one, those that were used last; buttons of all tabs have the other connections.
 */
const STREAMS = 3;
/** A tab that has a stream says so again; one that did not for long is gone without a word. */
const TELL_MS = 5000;
const GONE_MS = 12_000;

/** Which tabs of this browser may hold a stream: the tabs tell each other when they were used last. */
class Turn {
  #id = `${Date.now()} ${Math.random()}`;
  #used = Date.now();
  /** When the other tabs were used, and when they said so last. */
  #others = new Map();
  #channel = new BroadcastChannel("profidrive streams");

  /** `changed()` is called when this tab may have lost or got its turn. */
  constructor(changed) {
    this.changed = changed;
    this.#channel.addEventListener("message", ({ data: { id, used, gone } }) => {
      if (gone) this.#others.delete(id);
      else this.#others.set(id, { used, told: Date.now() });
      this.changed();
    });
    for (const use of ["focus", "pointerdown", "keydown"]) window.addEventListener(use, () => this.#use(), true);
    document.addEventListener("visibilitychange", () => (document.hidden ? this.changed() : this.#use()));
    window.addEventListener("pagehide", () => this.#channel.postMessage({ id: this.#id, gone: true }));
    window.addEventListener("pageshow", () => this.#tell());
    setInterval(() => this.#refresh(), TELL_MS);
    this.#tell();
  }

  get isMine() {
    const newer = [...this.#others.values()].filter(({ used }) => used > this.#used);
    return newer.length < STREAMS;
  }

  #use() {
    const had = this.isMine;
    this.#used = Date.now();
    if (had) return;
    this.#tell();
    this.changed();
  }

  #tell() {
    this.#channel.postMessage({ id: this.#id, used: this.#used });
  }

  #refresh() {
    this.#tell();
    for (const [id, { told }] of this.#others) if (Date.now() - told > GONE_MS) this.#others.delete(id);
    this.changed();
  }
}

/**
 * Connects again by itself when the stream ends. `on` has functions: `state(state)`, `news(event)`, `telegram(telegram)`,
 * `lost(counts)`, `open(live)` (`live`: by a stream, not by questions) and `closed(error)`.
 */
export class Stream {
  #source = null;
  #timer = 0;
  #silence = 0;
  /** What is polled, by a number of its own: answers to what is not wanted any more are dropped. */
  #polling = null;
  /** Whether the server has taken the subscription. */
  #open = false;
  #on;
  #wanted = null;
  #turn = new Turn(() => this.#take());

  constructor(on) {
    this.#on = on;
    window.addEventListener("pagehide", () => this.#end());
    window.addEventListener("pageshow", ({ persisted }) => persisted && this.#connect());
  }

  /** Subscribes to something else: `station` is null for all, `kinds` and `interval_milliseconds` as the API has them. */
  subscribe(wanted) {
    this.#wanted = wanted;
    this.#connect();
  }

  /** Streams if it is this tab's turn, asks if not. */
  #take() {
    if (this.#wanted === null) return;
    if (this.#turn.isMine && this.#polling !== null) this.#connect();
    else if (!this.#turn.isMine && this.#polling === null) this.#poll();
  }

  #connect() {
    if (!this.#turn.isMine) {
      this.#poll();
      return;
    }
    this.#end();
    const source = new EventSource(eventsAddress(this.#wanted));
    this.#source = source;
    source.addEventListener("open", () => {
      this.#open = true;
      this.#watch();
      this.#on.open(true);
    });
    source.addEventListener("error", () => this.#retry());
    for (const event of ["state", "news", "telegram", "lost"]) {
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
    this.#polling = null;
  }

  /** Asks once, and if the server answers, that is as good as a stream that is slow. */
  async #retry() {
    this.#end();
    const mine = (this.#polling = {});
    const stream = () => this.#connect();
    this.#timer = setTimeout(stream, RETRY_MS);
    await this.#ask(mine);
  }

  #poll() {
    this.#end();
    const mine = (this.#polling = {});
    const again = async () => {
      await this.#ask(mine);
      if (this.#polling === mine) this.#timer = setTimeout(again, POLL_MS);
    };
    again();
  }

  async #ask(mine) {
    const { station } = this.#wanted;
    try {
      const state = await request("GET", station === null ? "/stations" : stationOf(station));
      if (this.#polling !== mine) return;
      this.#on.open(false);
      this.#on.state(state);
    } catch (error) {
      if (this.#polling === mine) this.#on.closed(error);
    }
  }
}

// What the counters of a line are per second: telegrams, cycle, retries; masters, and how long replies took.
import { Figures, Rows, Table, field, html, many, say } from "./dom.js";

/** Rates are those of this time: shorter, and they jump; longer, and what is new is hardly seen. */
const SPAN_S = 6;

export class BusRates {
  /** The newest answers of the server, oldest first. */
  #before = [];
  #station = "all";
  #figures = new Figures();
  #table = new Table("Rates of the stations", [">Address", ">Master", ">Cycle", ">Requests/s", ">Retries"], ({ texts }) => texts);
  #times;

  constructor() {
    const times = html("ol", { class: "histogram", "aria-label": "Reply times" });
    this.choose = html("select", { onchange: () => this.#choose() }, html("option", { value: "all" }, "all stations"));
    this.none = html("p", { class: "muted" }, "No reply yet.");
    this.slaves = html("div", {}, this.#table.element, html("h4", {}, "Reply times"), field("Of", this.choose), this.none, times);
    this.element = html("div", {}, this.#figures.element, this.slaves);
    this.#times = new Rows(times, ({ name }) => {
      const bar = html("meter", { min: 0, max: 1, "aria-hidden": "true" });
      const count = html("span", { class: "right" });
      const show = ({ count: times, most }) => {
        bar.value = times / most;
        say(count, String(times));
      };
      return { element: html("li", {}, html("span", { class: "right" }, name), bar, count), show };
    });
  }

  /** What the server says of the bus now. */
  show(bus) {
    // Counters that go back are those of another start.
    if (this.#before.at(-1)?.time_seconds > bus.time_seconds) this.#before = [];
    this.#before.push(bus);
    while (this.#before.length > 2 && bus.time_seconds - this.#before[1].time_seconds >= SPAN_S) this.#before.shift();
    const [then] = this.#before;
    const seconds = bus.time_seconds - then.time_seconds;
    const per = (now, before) => (seconds > 0 ? (now - before) / seconds : 0);
    const busy = bus.busy_seconds === undefined ? [] : [{ name: "Load", text: share(bus.busy_seconds - then.busy_seconds, seconds) }];
    const passed = { name: "Telegrams", text: `${per(total(bus), total(then)).toFixed(0)} /s` };
    const asked = (bus.stations ?? []).filter(({ counters }) => counters?.requests !== undefined);
    this.slaves.hidden = asked.length === 0;
    const rates = asked.map((station) => rateOf(station, then.stations.find(({ address }) => address === station.address), per));
    const [requests, retries] = ["requests", "retries"].map((what) => rates.reduce((sum, rate) => sum + rate[what], 0));
    const cycles = rates.map(({ cycle }) => cycle).filter((cycle) => cycle !== null);
    const polled = [
      { name: "Cycle", text: cycles.length === 0 ? "–" : milliseconds(Math.max(...cycles)) },
      { name: "Retries", text: share(retries, requests) },
      { name: "Masters", text: masters(asked) },
    ];
    this.#figures.show([passed, ...busy, ...(asked.length === 0 ? [] : polled)]);
    const row = ({ address, owner, cycle, requests, retries }) => ({
      key: address,
      texts: [String(address), owner === null ? "–" : String(owner), cycle === null ? "–" : milliseconds(cycle), requests.toFixed(0), share(retries, requests)],
    });
    this.#table.show(rates.map(row));
    this.#offer(asked.map(({ address }) => String(address)));
    this.#showTimes(asked);
  }

  #choose() {
    this.#station = this.choose.value;
    if (this.#before.length > 0) this.#showTimes(this.#before.at(-1).stations ?? []);
  }

  #offer(addresses) {
    const offered = [...this.choose.options].slice(1).map(({ value }) => value);
    if (offered.join() === addresses.join()) return;
    if (!addresses.includes(this.#station)) this.#station = "all";
    this.choose.replaceChildren(this.choose.options[0], ...addresses.map((address) => html("option", { value: address }, `station ${address}`)));
    this.choose.value = this.#station;
  }

  #showTimes(stations) {
    const chosen = stations.filter(({ address }) => this.#station === "all" || String(address) === this.#station);
    const counts = new Map();
    for (const { reply_times: times = [] } of chosen) for (const { up_to_microseconds: limit, count } of times) counts.set(limit, (counts.get(limit) ?? 0) + count);
    const all = [...counts].map(([limit, count]) => ({ limit, count }));
    const [first, last] = [all.findIndex(({ count }) => count > 0), all.findLastIndex(({ count }) => count > 0)];
    const shown = first < 0 ? [] : all.slice(first, last + 1);
    const most = Math.max(1, ...shown.map(({ count }) => count));
    this.none.hidden = shown.length > 0;
    this.#times.show(shown.map(({ limit, count }) => ({ name: limit === null ? "longer" : `≤ ${time(limit)}`, count, most })), ({ name }) => name);
  }
}

/** Telegrams or frames that have passed. */
export function total({ telegrams_sent: sent = 0, telegrams_heard: heard = [], frames = 0 }) {
  return heard.reduce((sum, { count }) => sum + count, sent + frames);
}

/** Of a station: requests and retries per second, ms between two requests, its owner. */
function rateOf({ address, owner_address: owner, counters }, then, per) {
  const before = then?.counters ?? counters;
  const requests = per(counters.requests, before.requests);
  const retries = per(counters.retries, before.retries);
  const cycles = requests - retries;
  return { address, owner, requests, retries, cycle: owner === null || cycles <= 0 ? null : 1000 / cycles };
}

/** Who owns which stations. */
function masters(stations) {
  const owned = new Map();
  for (const { owner_address: owner, address } of stations) if (owner !== null) owned.set(owner, [...(owned.get(owner) ?? []), address]);
  if (owned.size === 0) return "none owns a station";
  return [...owned].map(([master, addresses]) => `${master} owns ${addresses.length > 4 ? many(addresses.length, "station") : addresses.join(", ")}`).join("; ");
}

function milliseconds(ms) {
  return `${ms.toPrecision(3)} ms`;
}

export function share(part, whole) {
  return whole > 0 ? `${((100 * part) / whole).toFixed(1)} %` : "–";
}

function time(microseconds) {
  return microseconds >= 1000 ? `${microseconds / 1000} ms` : `${microseconds} µs`;
}

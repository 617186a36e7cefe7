// The panel: which view is shown, and what comes from the stream to it.
import { html, say, mark } from "./dom.js";
import { Alarms } from "./alarms.js";
import { announceRefusal } from "./announce.js";
import { isSame, linkOf, nameOf, request, stationOf } from "./api.js";
import { BusView } from "./bus.js";
import { Connection } from "./connection.js";
import { Log } from "./log.js";
import { Overview } from "./overview.js";
import { Recall } from "./recall.js";
import { Scenario } from "./scenario.js";
import { StationView } from "./station.js";
import { Stream } from "./stream.js";
import { Telegrams } from "./telegrams.js";

const VIEWS = ["stations", "station", "bus"];
/** How often states come: of one station, smooth enough for curves; of all, often enough to see what goes on. */
const INTERVAL_MS = { stations: 250, station: 50, bus: 1000 };
/** How often is asked for what is not in the stream: parameters, counters, which stations there are. */
const ASK_MS = 2000;

class Panel {
  #by = (id) => document.getElementById(id);
  #view = null;
  /** The station that is shown, and its view. */
  #station = null;
  #shown = null;
  #stations = [];
  #gap = false;
  #choose = html("select", { id: "choose", onchange: () => (location.hash = this.#choose.value) });
  #chooseField = html("label", { class: "field", hidden: true }, "Station ", this.#choose);

  constructor() {
    const by = this.#by;
    this.connection = new Connection();
    this.alarms = new Alarms(by("alarms"));
    this.recall = new Recall();
    this.bus = new BusView();
    this.overview = new Overview();
    this.log = new Log(by("log-lines"), (time) => this.#point(time, "log"));
    this.telegrams = new Telegrams(by("telegram-lines"), () => this.#subscribe(), (time) => this.#point(time, "telegrams"));
    new Scenario(by("scenario-steps"));
    this.stream = new Stream({
      open: (live) => this.#connected(live),
      closed: (error) => this.#disconnected(error),
      state: (state) => this.#state(state),
      news: (news) => this.#news(news),
      telegram: (telegram) => this.#telegram(telegram),
      lost: (lost) => this.#loses(lost),
    });
    window.addEventListener("hashchange", () => this.#route());
    // A finger that leaves the window has left the key.
    for (const leaving of ["blur", "pagehide"]) window.addEventListener(leaving, () => this.#shown?.leave());
    document.addEventListener("visibilitychange", () => document.hidden && this.#shown?.leave());
    this.#route();
    setInterval(() => this.#ask(), ASK_MS);
    const paint = () => {
      requestAnimationFrame(paint);
      this.#shown?.paint();
      this.log.paint();
      this.telegrams.paint();
      this.connection.paint();
    };
    requestAnimationFrame(paint);
  }

  /** Shows what the address of the page says: #stations, #station/LINE/5, #station/5, #bus. Without any, the only station or all. */
  async #route() {
    const hash = location.hash;
    const [, view, line, address] = /^#(\w+)(?:\/([^/]+))??(?:\/(\d+))?$/.exec(hash) ?? [];
    let station = address === undefined ? null : { line: line === undefined ? null : decodeURIComponent(line), address: Number(address) };
    const unknown = !VIEWS.includes(view) || (view === "station" && station === null && this.#station === null);
    if (unknown || (station !== null && station.line === null)) {
      const stations = await this.#list();
      if (location.hash !== hash) return;
      if (unknown) {
        location.replace(stations?.length === 1 ? linkOf(stations[0]) : "#stations");
        return;
      }
      station.line = stations?.find((one) => one.address === station.address)?.line ?? stations?.[0]?.line ?? "line";
    }
    this.#view = view;
    if (view === "station") this.#open(station ?? this.#station);
    else this.#shown?.leave();
    for (const name of VIEWS) {
      this.#by(name).hidden = name !== view;
      if (name === view) mark(this.#by(`to-${name}`), "aria-current", "page");
      else this.#by(`to-${name}`).removeAttribute("aria-current");
    }
    this.#by("telegrams").hidden = view === "stations";
    document.title = view === "station" ? `Station ${this.#station.address} – profidrive` : "profidrive";
    const only = view === "station" ? this.#station : null;
    this.log.only(only);
    this.telegrams.only(only);
    this.#subscribe();
    this.#ask();
  }

  /** Another station has a view of its own; nothing of the last one stays. */
  #open(station) {
    if (this.#shown && isSame(this.#station, station)) return;
    this.#shown?.leave();
    this.#station = station;
    this.#shown = new StationView(this.#by("station"), station, {
      choose: this.#chooseField,
      lines: this.#lineCount,
      onPoint: (time) => this.#point(time, "curves"),
      onTrigger: (hit) => this.telegrams.triggered(hit),
      told: () => ({ events: this.log.shown, telegrams: this.telegrams.shown }),
      note: (line) => this.#note(line),
    });
    mark(this.#by("to-station"), "href", linkOf(station));
    say(this.#by("to-station"), `Station ${nameOf(station, this.#lineCount)}`);
    this.#by("to-station").hidden = false;
  }

  /** One time for all: what somebody chose in the curves, the events or the telegrams is shown in the others. */
  #point(time, chosen) {
    if (chosen !== "curves" && time !== null) this.#shown?.curves.point(time);
    if (chosen !== "log") this.log.point(time);
    if (chosen !== "telegrams") this.telegrams.point(time);
  }

  /** Something that somebody notes, beside what happens by itself. */
  #note(line) {
    this.log.add(line);
    this.#mark(line);
  }

  get #lineCount() {
    return new Set(this.#stations.map(({ line }) => line)).size;
  }

  #subscribe() {
    if (this.#view === null) return;
    const kinds = ["state", "news", ...(this.telegrams.wanted && this.#view !== "stations" ? ["telegram"] : [])];
    this.#gap = true;
    const station = this.#view === "station" ? this.#station : null;
    this.telegrams.of(station?.line ?? (this.#view === "bus" ? this.bus.line : null));
    this.stream.subscribe({ station, kinds, interval_milliseconds: INTERVAL_MS[this.#view] });
  }

  /** What is not understood is not shown; what comes next may be. */
  #state(state) {
    if (Array.isArray(state?.stations)) {
      this.#showStations(state.stations);
    } else if (this.#view === "station" && isSame(state, this.#station)) {
      this.#shown.show(state, this.#gap);
      this.alarms.showOne(state);
      this.#gap = false;
    }
  }

  #news(news) {
    if (!this.recall.isNew(news)) return;
    const line = lineOf(news);
    this.log.add(line);
    this.#mark(line);
    if (line.kind === "fault") this.telegrams.fault(line);
    if (line.kind === "refusal") announceRefusal(line.text);
  }

  /** In the curves, if it is of the station that has them. */
  #mark(line) {
    const own = line.line === undefined || line.line === this.#station?.line;
    if (own && line.stations.includes(this.#station?.address)) this.#shown?.curves.mark(line);
  }

  #connected(live) {
    this.connection.live(live);
    this.#recallEvents();
  }

  /** What happened before, or meanwhile. */
  async #recallEvents() {
    const recalled = await this.recall.events();
    if (recalled === null) return;
    if (recalled.again) this.log.beginAnew();
    if (recalled.fresh.length > 0) this.log.merge(recalled.fresh.map(lineOf));
    for (const news of recalled.all) this.#mark(lineOf(news));
  }

  #telegram({ time_seconds: time_s, line, text, octets_hex: octets, mark: kind, from_address: from, to_address: to }) {
    const said = kind === "invalid" ? `${text}  [${octets}]` : text;
    this.telegrams.add({ time_s, kind: "telegram", text: said, line, stations: listed(from, to), bad: kind === "invalid" || kind === "mistake", route: `${line} ${from} ${to} ${kind === undefined ? text.split(" ")[0] : ""}` });
  }

  #loses(lost) {
    this.#gap ||= lost.states > 0;
    const told = this.connection.loses(lost);
    if (lost.news + lost.telegrams > 0) this.log.add({ time_s: null, kind: "lost", text: `${told} lost: this page reads too slowly`, stations: [] });
  }

  #disconnected({ message, status }) {
    const missing = this.#view === "station" && (status === 404 || status === 400);
    this.connection.gone(missing ? "no such station" : message);
    if (missing) this.#shown.gone(message);
    this.#gap = true;
  }

  /** What is not in the stream. */
  async #ask() {
    if (document.hidden) return;
    try {
      const stations = await this.#list();
      if (this.#view === "bus") await this.bus.refresh();
      if (this.#view === "stations") await this.overview.refresh();
      if (this.#view !== "station") return;
      // The stream of a station that was taken away does not end.
      const there = stations === null || stations.some((station) => isSame(station, this.#station));
      if (there) await this.#shown.refresh();
      else await request("GET", stationOf(this.#station));
    } catch (error) {
      if (this.#view === "station" && error.status >= 400) this.#subscribe();
    }
  }

  async #list() {
    try {
      const { stations } = await request("GET", "/stations");
      this.#showStations(stations);
      return stations;
    } catch {
      return null;
    }
  }

  #showStations(stations) {
    this.#stations = [...stations].sort((a, b) => String(a.line).localeCompare(String(b.line)) || a.address - b.address);
    this.alarms.show(this.#stations);
    if (this.#view === "stations") this.overview.show(this.#stations);
    this.#chooseField.hidden = this.#stations.length < 2;
    const links = this.#stations.map(linkOf);
    if ([...this.#choose.options].map(({ value }) => value).join() !== links.join()) {
      this.#choose.replaceChildren(...this.#stations.map((station) => html("option", { value: linkOf(station) }, nameOf(station, this.#lineCount))));
    }
    if (document.activeElement !== this.#choose && this.#station) this.#choose.value = linkOf(this.#station);
  }
}

/** An event as a line. */
function lineOf({ number, time_seconds: time_s, line, address, kind, class: kindOf, text }) {
  const known = kindOf === "fault" || kindOf === "refusal" ? kindOf : kind;
  return { number: number ?? undefined, time_s, kind: known, text, line, stations: listed(address) };
}

/** The addresses that are known. */
function listed(...addresses) {
  return addresses.filter((address) => address !== null && address !== undefined);
}

new Panel();

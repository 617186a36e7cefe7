// The panel: which view is shown, and what comes from the stream to it.
import { html, say, mark } from "./dom.js";
import { Alarms } from "./alarms.js";
import { announceRefusal } from "./announce.js";
import { Stream, request } from "./api.js";
import { BusView } from "./bus.js";
import { Connection } from "./connection.js";
import { DriveView } from "./drive.js";
import { Log } from "./log.js";
import { Overview } from "./overview.js";
import { PpoTiles, PpoView } from "./ppo.js";
import { modelName, positionOf, stateOf } from "./states.js";
import { Recall, recallInto } from "./recall.js";
import { StationTiles, StationView } from "./station.js";
import { Telegrams } from "./telegrams.js";

const VIEWS = ["drives", "drive", "station", "ppo", "bus"];
/** How often states come: of one drive, smooth enough for curves; of all, often enough to see what goes on. */
const INTERVAL_MS = { drives: 250, drive: 50, station: 100, ppo: 100, bus: 1000 };
/** How often is asked for what is not in the stream: parameters, counters, which drives there are. */
const ASK_MS = 2000;
/** Of a drive that is not there, and of an address that no drive can have. */
const NO_DRIVE = [400, 404];
const KINDS = { command_refused: "refusal", job_refused: "refusal", fault: "fault", dp: "dp", drive: "drive", parameter: "drive", input: "drive", power: "power", line: "line", hint: "hint" };

class Panel {
  #by = (id) => document.getElementById(id);
  #view = null;
  #address = null;
  /** The station from a GSD that is shown. */
  #station = null;
  /** The drive of PROFIDRIVE version 2 that is shown. */
  #ppo = null;
  #gap = false;

  constructor() {
    const by = this.#by;
    this.connection = new Connection();
    this.alarms = new Alarms(by("alarms"));
    this.recall = new Recall();
    this.drive = new DriveView();
    this.station = new StationView();
    this.stationTiles = new StationTiles();
    this.ppo = new PpoView();
    this.ppoTiles = new PpoTiles();
    this.bus = new BusView();
    this.overview = new Overview({ tiles: by("tiles"), filter: by("drives-filter"), count: by("drives-count"), none: by("drives-none") });
    this.log = new Log(by("log-lines"));
    this.telegrams = new Telegrams(by("telegram-lines"), () => this.#subscribe(), { file: "/api/v1/capture.pcapng" });
    this.stream = new Stream({
      open: () => this.#connected(),
      closed: (error) => this.#disconnected(error),
      state: (state) => this.#state(state),
      news: (news) => this.#news(news),
      telegram: (telegram) => this.#telegram(telegram),
      lost: (lost) => this.#loses(lost),
    });
    by("choose").addEventListener("change", (event) => (location.hash = `#drive/${event.target.value}`));
    window.addEventListener("hashchange", () => this.#route());
    this.#route();
    setInterval(() => this.#ask(), ASK_MS);
    const paint = () => {
      this.drive.paint();
      this.log.paint();
      this.telegrams.paint();
      this.connection.paint();
      requestAnimationFrame(paint);
    };
    requestAnimationFrame(paint);
  }

  /** Shows what the address of the page says: #drives, #drive/5, #bus. Without any, the only drive or all of them. */
  async #route() {
    const [, view, address] = /^#(\w+)(?:\/(\d+))?$/.exec(location.hash) ?? [];
    const last = { drive: this.#address, station: this.#station, ppo: this.#ppo };
    const nobody = view in last && last[view] === null;
    if (!VIEWS.includes(view) || (address === undefined && nobody)) {
      const [drives, stations, ppo] = [await this.#drives(), await this.stationTiles.refresh(), await this.ppoTiles.refresh()];
      const all = [["drive", drives], ["station", stations], ["ppo", ppo]].flatMap(([kind, list]) => (list ?? []).map(({ address }) => `#${kind}/${address}`));
      location.replace(all.length === 1 ? all[0] : "#drives");
      return;
    }
    this.#view = view;
    if (view === "drive") {
      this.#address = Number(address ?? this.#address);
      this.#chooseDrive();
      mark(this.#by("to-drive"), "href", `#drive/${this.#address}`);
      say(this.#by("to-drive"), `Drive ${this.#address}`);
      this.#by("to-drive").hidden = false;
    }
    if (view === "station") {
      this.#station = Number(address ?? this.#station);
      this.station.choose(this.#station);
      mark(this.#by("to-station"), "href", `#station/${this.#station}`);
      say(this.#by("to-station"), `Station ${this.#station}`);
      this.#by("to-station").hidden = false;
    }
    if (view === "ppo") {
      this.#ppo = Number(address ?? this.#ppo);
      this.ppo.choose(this.#ppo);
      mark(this.#by("to-ppo"), "href", `#ppo/${this.#ppo}`);
      say(this.#by("to-ppo"), `Drive ${this.#ppo}`);
      this.#by("to-ppo").hidden = false;
    }
    for (const name of VIEWS) {
      this.#by(name).hidden = name !== view;
      if (name === view) mark(this.#by(`to-${name}`), "aria-current", "page");
      else this.#by(`to-${name}`).removeAttribute("aria-current");
    }
    this.#by("telegrams").hidden = view === "drives";
    const shown = { drive: this.#address, station: this.#station, ppo: this.#ppo }[view] ?? null;
    document.title = shown === null ? "profidrive" : `${view === "station" ? "Station" : "Drive"} ${shown} – profidrive`;
    this.log.only(shown);
    this.telegrams.only(shown);
    this.#subscribe();
    this.#ask();
  }

  async #chooseDrive() {
    const address = this.#address;
    if (!this.drive.choose(address)) return;
    const samples = await this.recall.samples(address).catch(() => []);
    if (address === this.#address) this.drive.recall(samples);
  }

  #subscribe() {
    const kinds = ["state", "news", ...(this.telegrams.wanted && this.#view !== "drives" ? ["telegram"] : [])];
    const wanted = { kinds: kinds.join(","), interval_milliseconds: INTERVAL_MS[this.#view] };
    this.#gap = true;
    const address = { drive: this.#address, station: this.#station, ppo: this.#ppo }[this.#view];
    this.stream.subscribe(address === undefined ? wanted : { ...wanted, address });
  }

  #state(state) {
    if (this.#view === "drive" && state.address === this.#address) {
      this.drive.show(state, this.#gap);
      this.alarms.showOne(state);
      this.#gap = false;
    } else if (this.#view === "station" && state.address === this.#station) {
      this.station.show(state);
    } else if (this.#view === "ppo" && state.address === this.#ppo) {
      this.ppo.show(state);
    } else if (state.drives) {
      this.#showDrives(state.drives);
    }
  }

  #news(news) {
    if (!this.recall.isNew(news)) return;
    const line = lineOf(news);
    this.log.add(line);
    this.drive.mark(line);
    if (line.kind === "fault") this.telegrams.fault(line);
    if (line.kind === "refusal") announceRefusal(line.text);
  }

  #connected() {
    this.connection.live();
    this.#recallEvents();
  }

  /** What happened before, or meanwhile. */
  async #recallEvents() {
    const shown = { drive: this.#address, station: this.#station, ppo: this.#ppo }[this.#view] ?? null;
    for (const line of await recallInto(this.log, this.recall, shown, lineOf)) this.drive.mark(line);
  }

  #telegram({ time_seconds: time_s, text, octets_hex: octets, mark: kind, from_address: from, to_address: to }) {
    const said = kind === "invalid" ? `${text}  [${octets}]` : text;
    this.telegrams.add({ time_s, kind: "telegram", text: said, stations: listed(from, to), bad: kind === "invalid" || kind === "mistake", route: `${from} ${to}` });
  }

  #loses(lost) {
    this.#gap ||= lost.states > 0;
    const told = this.connection.loses(lost);
    if (lost.news + lost.telegrams > 0) this.log.add({ time_s: null, kind: "lost", text: `${told} lost: this page reads too slowly`, stations: [] });
  }

  #disconnected({ message, status }) {
    const missing = this.#view === "drive" && NO_DRIVE.includes(status);
    this.connection.gone(missing ? "no such drive" : message);
    if (missing) this.drive.gone(message);
    if (this.#view === "station" && NO_DRIVE.includes(status)) this.station.gone(`there is no station from a GSD at address ${this.#station}`);
    if (this.#view === "ppo" && NO_DRIVE.includes(status)) this.ppo.gone(`there is no PROFIDRIVE drive at address ${this.#ppo}`);
    this.#gap = true;
  }

  /** What is not in the stream. */
  async #ask() {
    if (document.hidden) return;
    try {
      if (this.#view === "bus") await this.bus.refresh();
      if (this.#view === "drives") await Promise.all([this.stationTiles.refresh(), this.ppoTiles.refresh()]);
      if (this.#view === "station" || this.#view === "ppo") await this.#drives();
      if (this.#view === "ppo") await this.ppo.refresh();
      if (this.#view === "drive") {
        await this.#drives();
        const address = this.#address;
        const { parameters } = await request("GET", `/drives/${address}/parameters`);
        if (address === this.#address) this.drive.showParameters(parameters);
      }
    } catch (error) {
      // The stream of a drive that was taken away does not end. All else that is wrong, the stream says.
      if (this.#view === "drive" && NO_DRIVE.includes(error.status)) this.#subscribe();
    }
  }

  async #drives() {
    try {
      const { drives } = await request("GET", "/drives");
      this.#showDrives(drives);
      return drives;
    } catch {
      return null;
    }
  }

  #showDrives(drives) {
    this.alarms.show(drives);
    const sorted = [...drives].sort((a, b) => a.address - b.address);
    if (this.#view === "drives") {
      this.overview.show(
        sorted.map((drive) => ({ address: drive.address, name: `${modelName(drive)} ${drive.gear_ratio}:1`, position: positionOf(drive), ...stateOf(drive) })),
      );
    }
    this.#by("choose-field").hidden = sorted.length < 2;
    const choose = this.#by("choose");
    const listed = [...choose.options].map(({ value }) => Number(value));
    if (listed.join() !== sorted.map(({ address }) => address).join()) {
      choose.replaceChildren(...sorted.map(({ address }) => html("option", { value: address }, String(address))));
    }
    if (document.activeElement !== choose) choose.value = this.#address;
  }
}

/** An event as a line. Of a station the text begins with which. */
function lineOf({ number, time_seconds: time_s, address, kind, text }) {
  return { number: number ?? undefined, time_s, kind: KINDS[kind] ?? kind, text, stations: listed(address) };
}

/** The addresses that are known. */
function listed(...addresses) {
  return addresses.filter((address) => address !== null && address !== undefined);
}

new Panel();

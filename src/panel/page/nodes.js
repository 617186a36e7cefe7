// The panel of a bus of CAN: which view is shown, and what comes from the stream to it.
import { say, mark } from "./dom.js";
import { announceFault } from "./announce.js";
import { Stream, request } from "./api.js";
import { CanBusView } from "./can_bus.js";
import { Connection } from "./connection.js";
import { Log } from "./log.js";
import { NodeView } from "./node.js";
import { Overview } from "./overview.js";
import { Recall, recallInto } from "./recall.js";
import { Telegrams } from "./telegrams.js";

const VIEWS = ["drives", "drive", "bus"];
/** How often states come. */
const INTERVAL_MS = { drives: 250, drive: 50, bus: 250 };
/** How often is asked for what is not in the stream: the dictionary, which nodes there are. */
const ASK_MS = 2000;
/** What the log calls news that stand out. */
const KINDS = { emcy: "fault", error_control: "fault" };

class Panel {
  #by = (id) => document.getElementById(id);
  #view = null;
  #address = null;

  constructor() {
    const by = this.#by;
    this.connection = new Connection();
    this.recall = new Recall();
    this.node = new NodeView();
    this.bus = new CanBusView();
    this.overview = new Overview({ tiles: by("tiles"), filter: by("drives-filter"), count: by("drives-count"), none: by("drives-none") }, "node");
    this.log = new Log(by("log-lines"));
    this.frames = new Telegrams(by("telegram-lines"), () => this.#subscribe(), { named: "frames", placeholder: "585, -705 ..." });
    this.stream = new Stream(
      {
        open: () => this.#connected(),
        closed: (error) => this.#closed(error),
        state: (state) => this.#state(state),
        news: (news) => this.#news(news),
        frame: ({ time_seconds: time_s, id, remote, octets_hex: octets, of_node: own }) =>
          this.frames.add({ time_s, kind: "telegram", word: own ? "node" : "master", text: `${id}  ${remote ? "remote request" : octets}`, stations: [], route: id }),
        lost: ({ news }) => this.log.add({ time_s: null, kind: "lost", text: `${news} events and frames lost: this page reads too slowly`, stations: [] }),
      },
      ["state", "news", "frame", "lost"],
    );
    window.addEventListener("hashchange", () => this.#route());
    this.#route();
    setInterval(() => this.#ask(), ASK_MS);
    const paint = () => {
      this.log.paint();
      this.frames.paint();
      requestAnimationFrame(paint);
    };
    requestAnimationFrame(paint);
  }

  /** Shows what the address of the page says: #drives, #drive/5. Without any, the only node or all of them. */
  async #route() {
    const [, view, address] = /^#(\w+)(?:\/(\d+))?$/.exec(location.hash) ?? [];
    if (!VIEWS.includes(view) || (view === "drive" && address === undefined && this.#address === null)) {
      const nodes = await request("GET", "/drives").catch(() => null);
      location.replace(nodes?.drives.length === 1 ? `#drive/${nodes.drives[0].address}` : "#drives");
      return;
    }
    this.#view = view;
    if (view === "drive") {
      this.#address = Number(address ?? this.#address);
      this.node.choose(this.#address);
      mark(this.#by("to-drive"), "href", `#drive/${this.#address}`);
      say(this.#by("to-drive"), `Node ${this.#address}`);
      this.#by("to-drive").hidden = false;
    }
    for (const name of VIEWS) {
      this.#by(name).hidden = name !== view;
      if (name === view) mark(this.#by(`to-${name}`), "aria-current", "page");
      else this.#by(`to-${name}`).removeAttribute("aria-current");
    }
    this.#by("telegrams").hidden = view === "drives";
    document.title = view === "drive" ? `Node ${this.#address} – profidrive` : view === "bus" ? "Bus – profidrive" : "profidrive";
    this.log.only(view === "drive" ? this.#address : null);
    this.#subscribe();
    this.#ask();
  }

  #subscribe() {
    const kinds = ["state", "news", ...(this.frames.wanted && this.#view !== "drives" ? ["frame"] : [])];
    const wanted = { kinds: kinds.join(","), interval_milliseconds: INTERVAL_MS[this.#view] };
    this.stream.subscribe(this.#view === "drive" ? { ...wanted, address: this.#address } : wanted);
  }

  #news(news) {
    if (!this.recall.isNew(news)) return;
    const line = lineOf(news);
    this.log.add(line);
    if (line.kind !== "fault") return;
    this.frames.fault(line);
    announceFault(news.address === null ? line.text : `Node ${news.address}: ${line.text}`);
  }

  #connected() {
    this.connection.live();
    recallInto(this.log, this.recall, this.#view === "drive" ? this.#address : null, lineOf);
  }

  #state(state) {
    if (this.#view === "drive" && state.address === this.#address) this.node.show(state);
    else if (this.#view === "drives" && state.drives) this.overview.show(state.drives.map(tile));
  }

  #closed({ message, status }) {
    const missing = this.#view === "drive" && status === 404;
    this.connection.gone(missing ? "no such node" : message);
    if (missing) this.node.gone(message);
  }

  /** What is not in the stream. */
  async #ask() {
    if (document.hidden) return;
    // That it failed, the stream says.
    if (this.#view === "bus") await this.bus.refresh().catch(() => {});
    if (this.#view !== "drive") return;
    const address = this.#address;
    try {
      const { objects } = await request("GET", `/drives/${address}/objects`);
      if (address === this.#address) this.node.showObjects(objects);
    } catch {
      // All that is wrong, the stream says; a node without supply has no dictionary.
      if (address === this.#address) this.node.showObjects([]);
    }
  }
}

/** An event as a line of the log. */
function lineOf({ number, time_seconds: time_s, address, kind, text }) {
  return { number, time_s, kind: KINDS[kind] ?? kind, text, stations: address === null ? [] : [address] };
}

/** A node as a tile: what its display shows, or what its LEDs say. */
function tile({ address, product, power, nmt_state: nmt, error_register: register, display }) {
  const kind = power === "off" ? "off" : register ? "fault" : nmt === "OPERATIONAL" ? "ready" : "waiting";
  const word = power === "off" ? "off" : register ? `error ${register.toString(16).toUpperCase().padStart(2, "0")}h, ${nmt}` : nmt;
  return { address, name: product, kind, word, position: display.lines.map(({ text }) => text.trim()).join("  ") };
}

new Panel();

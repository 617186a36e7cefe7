// A server of the panel with devices that nobody has ever built: what the page shows of them, it has from the API alone.
import { once } from "node:events";
import { readFile } from "node:fs/promises";
import http from "node:http";
import { basename, extname } from "node:path";
import { fileURLToPath } from "node:url";

const PAGE = fileURLToPath(new URL("../../src/panel/page/", import.meta.url));
const TYPES = { ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".html": "text/html" };

/** What a pump tells of itself; `fields` are others. */
export function pump(address, fields = {}) {
  return {
    line: "cellar",
    bus: "canopen",
    address,
    device: "pump-9000",
    product: "Pump 9000",
    power: "on",
    presence: "active",
    exchanging: true,
    bus_state: "OPERATIONAL",
    state: "enabled",
    state_text: "pumps",
    moving: true,
    fault: null,
    warning: null,
    display: { rows: [{ text: "12.5", flashing: false }], signs: ["dry"], leds: [{ led: "run green", colour: "green", glow: "blinking", blinks: 2 }] },
    headline: [{ key: "flow", name: "Flow", unit: "l/s", value: 12.5 }],
    time_seconds: 1,
    words: [{ key: "6040", name: "6040h:00 Controlword", value: 3, bits: [{ bit: 0, set: true, key: "go", name: "go", meaning: "pump", note: null, used: true }] }],
    values: [
      { key: "flow", name: "Flow", unit: "l/s", value: 12.5, group: "motion", curve: true },
      { key: "impeller", name: "Impeller", unit: "turns", value: 3.25, group: "motion" },
    ],
    process: [{ key: "rpdo1", name: "RPDO1", from_master: true, octets_hex: "0300", details: null, entries: [{ name: "go", place: "6040h:00", value: 3, unit: null }] }],
    inputs: [
      { input: "level_metres", text: "level of the cellar", value: 1, low: 0, high: 31, may_be_null: false, unit: "m", nominal: 1 },
      { input: "clogged", text: "the filter is clogged", value: false, low: null, high: null, may_be_null: false, unit: null, nominal: false },
    ],
    keys: [{ key: "prime", pressed: false }],
    faults: [{ fault: "dry-run", text: "no water", present: false, provoked: false }],
    switches: null,
    history: [{ code: "dry-run", text: "no water", when: "at 0.5 s" }],
    last_refusal: null,
    why: { moving: true, reasons: [], next: null },
    diagnosis: null,
    counters: [{ key: "starts", name: "starts", unit: null, value: 4 }],
    eeprom: null,
    has: { parameters: false, objects: true, modules: false, samples: true, switches: false, power: true },
    ...fields,
  };
}

export class MadeUp {
  /** The requests that changed something: `{ method, path, body }`. */
  asked = [];
  /** The streams that are open. */
  streams = new Set();
  telegrams = [];
  events = [];
  bus = { time_seconds: 1, rate_bits_per_second: 500_000, frames: 12, stations: [], faults: [], fault_kinds: [{ fault: "frame-lost", text: "nobody hears a frame" }], devices: [{ device: "pump-9000", text: "Pump 9000" }] };

  static async start(stations) {
    const server = new MadeUp();
    server.stations = stations;
    server.http = http.createServer((request, response) => server.#serve(request, response));
    server.http.listen(0, "127.0.0.1");
    await once(server.http, "listening");
    server.panel = `http://127.0.0.1:${server.http.address().port}/`;
    return server;
  }

  async stop() {
    this.http.closeAllConnections();
    this.http.close();
  }

  /** Sends an event to everybody who reads. */
  tell(event, data) {
    for (const stream of this.streams) stream.write(`event: ${event}\ndata: ${JSON.stringify(data)}\n\n`);
  }

  async #serve(request, response) {
    const { pathname, searchParams } = new URL(request.url, this.panel);
    let text = "";
    for await (const part of request) text += part;
    const answer = (body, status = 200) => response.writeHead(status, { "content-type": "application/json" }).end(JSON.stringify(body));
    if (pathname === "/" || pathname.startsWith("/page/")) {
      const name = pathname === "/" ? "index.html" : basename(pathname);
      response.writeHead(200, { "content-type": TYPES[extname(name)] }).end(await readFile(PAGE + name));
      return;
    }
    const path = pathname.replace("/api/v1", "");
    if (request.method !== "GET") this.asked.push({ method: request.method, path, body: text === "" ? null : JSON.parse(text) });
    if (path === "/events") this.#stream(response, searchParams);
    else if (path === "/openapi.json") answer({ paths: {} });
    else if (path === "/stations") answer({ time_seconds: 1, stations: this.stations });
    else if (path === "/lines") answer({ time_seconds: 1, lines: [{ line: "cellar", bus: "canopen", link: "slcan", rate_bits_per_second: 500_000 }] });
    else if (path === "/lines/cellar") answer(this.bus);
    else if (path === "/events/recent") answer({ started_unix_seconds: 1, events: this.events });
    else this.#station(path, answer);
  }

  #station(path, answer) {
    const [, address, rest] = /^\/lines\/cellar\/stations\/(\d+)(.*)$/.exec(path) ?? [];
    const station = this.stations.find((station) => station.address === Number(address));
    if (!station) answer({ detail: `there is no station at address ${address}` }, 404);
    else if (rest === "/samples") answer({ samples: [] });
    else if (rest === "/objects") answer({ objects: [{ index: "1017", sub: "00", name: "heartbeat", type: "UNSIGNED16", access: "rw", value: 100 * address }] });
    else if (rest.startsWith("/objects/")) answer({ index: "1017", sub: "00", name: "heartbeat", value: 250 });
    else answer(station);
  }

  #stream(response, wanted) {
    const address = wanted.get("address");
    const state = () => (address === null ? { time_seconds: 1, stations: this.stations } : this.stations.find((station) => station.address === Number(address)));
    if (state() === undefined) {
      response.writeHead(404, { "content-type": "application/json" }).end(JSON.stringify({ detail: `there is no station at address ${address}` }));
      return;
    }
    response.writeHead(200, { "content-type": "text/event-stream" });
    const send = () => state() && response.write(`event: state\ndata: ${JSON.stringify(state())}\n\n`);
    const timer = setInterval(send, 100);
    send();
    this.streams.add(response);
    response.on("close", () => {
      clearInterval(timer);
      this.streams.delete(response);
    });
  }
}

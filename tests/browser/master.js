// A DP master of class 1 for the browser tests: small, and independent of the crate under test.
//
// It asks one station after the other over a TCP link of the emulator: Slave_Diag, Set_Prm, Chk_Cfg, then
// Data_Exchange for ever. The PPO is PKW (4 words), STW or ZSW, and 32 bits of setpoint or actual value, high octet first.
import net from "node:net";
import { once } from "node:events";

// Not 1 to 125: the tests have drives at all of them.
const MASTER = 0;
// A station that was there is waited for: on a loaded machine its reply may be late. One that was not, need not hold up
// the others.
const REPLY_LIMIT_MS = { known: 5_000, unknown: 200 };
const SAP = { diag: 60, prm: 61, cfg: 62, master: 62 };
// Lock and watchdog of 20 s, min T_SDR 11, ident number 0AC5, no group.
const SET_PRM = [0x88, 20, 100, 11, 0x0a, 0xc5, 0];
const CHK_CFG = [0xf3, 0xf2];

/** One drive as the master sees it. Set `stw`, `hsw` and `pkw`; read the rest. */
class Station {
  setPrm = SET_PRM;
  chkCfg = CHK_CFG;
  inputLength = 14;
  stw = 0;
  hsw = 0;
  pkw = [0, 0, 0, 0];
  zsw = 0;
  hiw = 0;
  reply = [0, 0, 0, 0];
  exchanges = 0;
  exchanging = false;
  #count = null;

  constructor(address) {
    this.address = address;
  }

  /** The function code of the next request: SRD high, with the frame count that tells it from a repeated one. */
  frameControl() {
    if (this.#count === null) {
      this.#count = true;
      return 0x6d;
    }
    this.#count = !this.#count;
    return this.#count ? 0x7d : 0x5d;
  }

  lost() {
    this.exchanging = false;
    this.#count = null;
  }

  outputs() {
    const octets = Buffer.alloc(14);
    this.pkw.forEach((word, index) => octets.writeUInt16BE(word, 2 * index));
    octets.writeUInt16BE(this.stw, 8);
    octets.writeInt32BE(this.hsw, 10);
    return octets;
  }

  take(inputs) {
    this.reply = [0, 2, 4, 6].map((offset) => inputs.readUInt16BE(offset));
    this.zsw = inputs.readUInt16BE(8);
    this.hiw = inputs.readInt32BE(10);
    this.exchanges += 1;
  }

  bit(number) {
    return (this.zsw >> number & 1) === 1;
  }
}

/** A station from a GSD: set `sent`, read `inputs` and `diagnosis`. */
export class PlainStation extends Station {
  inputs = [];
  diagnosis = [];

  /** Of `ident`, with user parameters, a configuration, and as many octets as that has. */
  constructor(address, { ident, prm = [], cfg, outputLength, inputLength }) {
    super(address);
    this.setPrm = [0x88, 20, 100, 11, ident >> 8, ident & 0xff, 0, ...prm];
    this.chkCfg = cfg;
    this.inputLength = inputLength;
    this.sent = Buffer.alloc(outputLength);
  }

  outputs() {
    return this.sent;
  }

  take(inputs) {
    this.inputs = [...inputs];
    this.exchanges += 1;
  }
}

export class Master {
  #socket;
  #octets = Buffer.alloc(0);
  #arrived = () => {};
  #running = true;
  #waiting = new Set();
  #loop;

  static async connect(port, addresses) {
    const socket = net.connect(port, "127.0.0.1");
    await once(socket, "connect");
    return new Master(socket, addresses);
  }

  constructor(socket, addresses) {
    this.#socket = socket.setNoDelay(true);
    this.stations = new Map(addresses.map((of) => (of instanceof Station ? [of.address, of] : [of, new Station(of)])));
    socket.on("data", (octets) => {
      this.#octets = Buffer.concat([this.#octets, octets]);
      this.#arrived();
    });
    socket.on("error", () => {});
    socket.on("close", () => {
      this.#running = false;
    });
    this.#loop = this.#run();
  }

  station(address) {
    return this.stations.get(address);
  }

  async close() {
    this.#running = false;
    this.#socket.destroy();
    this.#arrived();
    await this.#loop;
  }

  /** Exchanges data until `condition` holds for the station at `address`. */
  async until(address, what, condition, limit = 60_000) {
    const station = this.station(address);
    if (condition(station)) return;
    await new Promise((resolve, reject) => {
      const entry = { check: () => condition(station), done: null };
      const timer = setTimeout(() => {
        this.#waiting.delete(entry);
        const zsw = station.zsw.toString(16).padStart(4, "0");
        reject(new Error(`drive ${address}: ${what} did not come; ZSW ${zsw}, actual value ${station.hiw}`));
      }, limit);
      entry.done = () => {
        clearTimeout(timer);
        this.#waiting.delete(entry);
        resolve();
      };
      this.#waiting.add(entry);
    });
  }

  /** Sends a control word and a setpoint, and waits until the drive has had time to act on both. */
  async command(address, stw, hsw = this.station(address).hsw) {
    const station = this.station(address);
    Object.assign(station, { stw, hsw });
    const seen = station.exchanges + 5;
    await this.until(address, "data exchange", () => station.exchanges >= seen);
  }

  async exchanging(address) {
    await this.until(address, "Data_Exchange", (station) => station.exchanging && station.exchanges > 0);
  }

  /** Enables operation, with all that a travel job needs. */
  async enable(address) {
    await this.command(address, 0x0000);
    await this.command(address, 0x003b);
    await this.until(address, "operation enabled", (station) => station.bit(2));
  }

  /** Starts a travel job; the edge of STW.6 goes to the other level than before. */
  async travel(address, target) {
    const station = this.station(address);
    const level = station.stw & 0x40;
    await this.command(address, 0x3b | level, target);
    await this.command(address, 0x3b | (level ^ 0x40), target);
  }

  async #run() {
    while (this.#running) {
      for (const station of this.stations.values()) {
        if (!this.#running) return;
        await this.#serve(station);
      }
      for (const entry of [...this.#waiting]) if (entry.check()) entry.done();
      // The drives run once in 1 ms: there is nothing new to hear before.
      await new Promise((resolve) => setTimeout(resolve, 2));
    }
  }

  async #serve(station) {
    if (!station.exchanging) {
      await this.#startUp(station);
      return;
    }
    const reply = await this.#request(station, null, station.outputs());
    if (reply?.data?.length === station.inputLength) {
      station.take(reply.data);
    } else {
      station.lost();
    }
  }

  async #startUp(station) {
    const diagnosis = await this.#request(station, SAP.diag, []);
    if (!diagnosis) return;
    await this.#request(station, SAP.prm, station.setPrm);
    await this.#request(station, SAP.cfg, station.chkCfg);
    const ready = await this.#request(station, SAP.diag, []);
    // Prm_Fault, Cfg_Fault, Station_Not_Ready, and Prm_Req of the second octet.
    if (ready?.data && (ready.data[0] & 0x46) === 0 && (ready.data[1] & 0x01) === 0) {
      station.exchanging = true;
    } else {
      station.lost();
    }
  }

  async #request(station, sap, data) {
    const extension = sap === null ? 0 : 0x80;
    const saps = sap === null ? [] : [sap, SAP.master];
    const body = [station.address | extension, MASTER | extension, station.frameControl(), ...saps, ...data];
    const sum = body.reduce((sum, octet) => sum + octet, 0) & 0xff;
    this.#octets = Buffer.alloc(0);
    this.#socket.write(Buffer.from([0x68, body.length, body.length, 0x68, ...body, sum, 0x16]));
    const reply = await this.#receive(station.address, station.exchanging ? REPLY_LIMIT_MS.known : REPLY_LIMIT_MS.unknown);
    if (!reply) station.lost();
    return reply;
  }

  /** The reply of a station, or null if none comes in time. */
  async #receive(address, limit) {
    const end = Date.now() + limit;
    while (this.#running) {
      const reply = this.#decode(address);
      if (reply) return reply;
      const left = end - Date.now();
      if (left <= 0) return null;
      await new Promise((resolve) => {
        const timer = setTimeout(resolve, left);
        this.#arrived = () => {
          clearTimeout(timer);
          resolve();
        };
      });
    }
    return null;
  }

  #decode(address) {
    const octets = this.#octets;
    if (octets[0] === 0xe5) return { data: null };
    if (octets.length >= 6 && octets[0] === 0x10) return { data: null };
    if (octets.length < 4 || octets[0] !== 0x68 || octets.length < octets[1] + 6) return null;
    const body = octets.subarray(4, 4 + octets[1]);
    const saps = body[0] & 0x80 ? 2 : 0;
    return (body[1] & 0x7f) === address ? { data: body.subarray(3 + saps) } : null;
  }
}

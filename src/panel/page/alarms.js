// The stations that are in fault, in sight whatever is shown, and announced once.
import { html, Rows, say } from "./dom.js";
import { announceFault } from "./announce.js";
import { linkOf, nameOf, request, stationOf } from "./api.js";
import { faultText } from "./states.js";

/** So many are named; of more there is a number. */
const NAMED = 6;

export class Alarms {
  /** The stations in fault, by their link. */
  #faults = new Map();
  #lines = 1;
  #links;
  #more = html("a", { href: "#stations" });

  constructor(root) {
    this.root = root;
    const list = html("span", { class: "group" });
    root.replaceChildren(html("span", {}, "Fault"), list, this.#more);
    this.#links = new Rows(list, (station) => {
      const element = html("a", { href: linkOf(station) });
      return { element, show: ({ fault }) => say(element, `${nameOf(station, this.#lines)}: ${fault.fault}`) };
    });
  }

  /** All stations there are, as summaries. */
  show(stations) {
    const before = this.#faults;
    this.#lines = new Set(stations.map(({ line }) => line)).size;
    this.#faults = new Map(stations.filter(({ fault }) => fault).map((station) => [linkOf(station), station]));
    for (const [link, station] of this.#faults) this.#announce(before.get(link), station);
    this.#paint();
  }

  /** One station, as soon as its state is known. */
  showOne(station) {
    const before = this.#faults.get(linkOf(station));
    if ((before?.fault.fault ?? null) === (station.fault?.fault ?? null)) return;
    if (station.fault) this.#faults.set(linkOf(station), station);
    else this.#faults.delete(linkOf(station));
    this.#announce(before, station);
    this.#paint();
  }

  #announce(before, station) {
    if (!station.fault || before?.fault.fault === station.fault.fault) return;
    const say = ({ fault }) => announceFault(`Station ${nameOf(station, this.#lines)}: fault ${faultText(fault)}`);
    if (station.fault.text !== station.fault.fault) say(station);
    // In the words of the device, where they are to be had.
    else request("GET", stationOf(station)).then((state) => say(state.fault ? state : station), () => say(station));
  }

  #paint() {
    const all = [...this.#faults.values()].sort((a, b) => a.address - b.address);
    this.root.hidden = all.length === 0;
    this.#links.show(all.slice(0, NAMED), linkOf);
    this.#more.hidden = all.length <= NAMED;
    say(this.#more, `and ${all.length - NAMED} more`);
  }
}

// The drives that are in fault, in sight whatever is shown, and announced once.
import { html, Rows, say } from "./dom.js";
import { announceFault } from "./announce.js";
import { request } from "./api.js";

/** So many are named; of more there is a number. */
const NAMED = 6;

export class Alarms {
  /** The code of the fault by address. */
  #faults = new Map();
  #links;
  #more = html("a", { href: "#drives" });

  constructor(root) {
    this.root = root;
    const list = html("span", { class: "group" });
    root.replaceChildren(html("span", {}, "Fault"), list, this.#more);
    this.#links = new Rows(list, ({ address }) => {
      const element = html("a", { href: `#drive/${address}` });
      return { element, show: ({ code }) => say(element, `${address}: ${code}`) };
    });
  }

  /** All drives there are: `{ address, fault }`. */
  show(drives) {
    const before = this.#faults;
    this.#faults = new Map(drives.filter(({ fault }) => fault !== null).map(({ address, fault }) => [address, fault]));
    for (const [address, code] of this.#faults) if (before.get(address) !== code) announce(address, code);
    this.#paint();
  }

  /** One drive, as soon as its state is known. */
  showOne({ address, fault, faults }) {
    if ((this.#faults.get(address) ?? null) === fault) return;
    if (fault === null) this.#faults.delete(address);
    else {
      this.#faults.set(address, fault);
      announceFault(`Drive ${address}: fault ${faults.latched.text}`);
    }
    this.#paint();
  }

  #paint() {
    const all = [...this.#faults].map(([address, code]) => ({ address, code })).sort((a, b) => a.address - b.address);
    this.root.hidden = all.length === 0;
    this.#links.show(all.slice(0, NAMED), ({ address }) => address);
    this.#more.hidden = all.length <= NAMED;
    say(this.#more, `and ${all.length - NAMED} more`);
  }
}

/** In the words of the drive, where they are to be had. */
async function announce(address, code) {
  const state = await request("GET", `/drives/${address}`).catch(() => null);
  announceFault(`Drive ${address}: fault ${state?.faults.latched?.text ?? code}`);
}

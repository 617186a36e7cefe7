// Keys that are held.

/** Keys of a server that knows no leases: it is asked once when a key goes down, and once when it goes up. */
export class Keys {
  #held = new Set();

  /** Asks with `send` what has to be asked. */
  press(send, station, { key, pressed }) {
    const name = `${station} ${key}`;
    if (pressed && this.#held.has(name)) return null;
    if (pressed) this.#held.add(name);
    else this.#held.delete(name);
    return send("POST", `${station}/keys`, { key, pressed });
  }
}

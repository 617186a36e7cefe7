// Why the drive does not start: conditions that are not met now, the way out of a fault, and the last request it refused.
import { html, say, mark, Rows } from "./dom.js";

export class Why {
  #reasons;

  constructor(root) {
    this.root = root;
    this.title = root.querySelector("h3");
    this.way = root.querySelector(".way");
    this.refused = root.querySelector(".last-refusal");
    this.#reasons = new Rows(root.querySelector("ul"), () => {
      const element = html("li");
      return { element, show: (reason) => say(element, reason) };
    });
  }

  /**
   * `title` is one sentence, `kind` ready, fault or waiting, `reasons` are sentences, `way` is the way out of a
   * fault or "", `refused` the last refusal in one line or "".
   */
  show({ title, kind, reasons, way = "", refused }) {
    mark(this.root, "data-kind", kind);
    say(this.title, title);
    this.#reasons.show(reasons, (reason) => reason);
    say(this.way, way);
    say(this.refused, refused);
  }
}

// Why the drive does not start: conditions that are not met now, and the last request it refused.
import { html, say, mark, Rows } from "./dom.js";

export class Why {
  #reasons;

  constructor(root) {
    this.root = root;
    this.title = root.querySelector("h3");
    this.refused = root.querySelector("[role=status]");
    this.#reasons = new Rows(root.querySelector("ul"), () => {
      const element = html("li");
      return { element, show: (reason) => say(element, reason) };
    });
  }

  /**
   * `title` is one sentence, `kind` ready, fault or waiting, `reasons` are sentences, `refused` is the last refusal in
   * one line or "".
   */
  show({ title, kind, reasons, refused }) {
    mark(this.root, "data-kind", kind);
    say(this.title, title);
    this.#reasons.show(reasons, (reason) => reason);
    say(this.refused, refused);
  }
}

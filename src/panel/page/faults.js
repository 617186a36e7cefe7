// The faults of a drive: the one it is in and what to do, the buffer, and how to provoke each.
import { html, say, mark, Rows } from "./dom.js";

/**
 * What makes each fault (docs/drive.md), as inputs of the API. A, B and C need a shaft that shall turn; a 24:1 gear
 * needs half the friction for C.
 */
const CAUSES = {
  A: { title: "supply below 18 V, and more than 200 mA", inputs: { control_supply_volts: 17, output_supply_volts: 17 } },
  B: { title: "shaft blocked", inputs: { blocked: true } },
  C: { title: "more than 2.4 A for 4 s", inputs: { friction_newton_metres: 5 } },
  D: { title: "output stage above 90 °C", inputs: { stage_temperature_celsius: 95 } },
  E: { title: "SIN/COS monitoring", inputs: { encoder_fault: true }, only: "AG03/1" },
  F: { title: "internal error", inputs: { internal_fault: true } },
  G: { title: "intermediate circuit above 35 V", inputs: { dc_link_volts: 36 } },
  J: { title: "battery below 2.2 V", inputs: { battery_volts: 2.1 }, only: "AG03/1" },
};
const HEALTHY = {
  control_supply_volts: 24,
  output_supply_volts: 24,
  blocked: false,
  friction_newton_metres: 0,
  stage_temperature_celsius: null,
  encoder_fault: false,
  internal_fault: false,
  dc_link_volts: null,
  battery_volts: 3,
};

export class Faults {
  #change;
  #buttons = new Map();
  #buffer;

  /** `change(inputs)` changes inputs of the drive. */
  constructor(root, change) {
    this.#change = change;
    const list = html("ol", { class: "buffer", "aria-label": "Fault buffer, newest first" });
    this.count = html("p", { class: "muted" });
    this.steps = html("p", { class: "steps" });
    this.provoke = html("div", { class: "provoke", role: "group", "aria-label": "Provoke a fault" }, html("span", { class: "muted" }, "Provoke"));
    for (const [code, { title }] of Object.entries(CAUSES)) {
      const button = html("button", { type: "button", title, "aria-label": `Provoke fault ${code}: ${title}`, "aria-pressed": false, onclick: () => this.#toggle(code) }, code);
      this.#buttons.set(code, button);
      this.provoke.append(button);
    }
    root.replaceChildren(this.provoke, this.steps, list, this.count);
    this.#buffer = new Rows(list, () => {
      const element = html("li");
      return {
        element,
        show: ({ text, title }) => {
          say(element, text);
          mark(element, "title", title);
          element.classList.toggle("empty", text === "–");
        },
      };
    });
  }

  /**
   * `model` and the `inputs` in effect, the `fault` latched or null, whether turn-on is disabled, the ten codes of the
   * `buffer` (newest first, null where empty) and the `count` of PNU 952.
   */
  show({ model, inputs, fault, turnOnDisabled, buffer, count }) {
    for (const [code, button] of this.#buttons) {
      const { only } = CAUSES[code];
      button.hidden = only !== undefined && only !== model;
      mark(button, "aria-pressed", present(code, model, inputs));
    }
    say(this.steps, advice(fault, turnOnDisabled, fault !== null && present(fault, model, inputs)));
    this.#buffer.show(
      buffer.map((code, index) => ({ index, text: code ?? "–", title: code ? `${code}: ${CAUSES[code]?.title ?? ""}` : "empty" })),
      ({ index }) => index,
    );
    say(this.count, `${count} since the buffer was cleared (PNU 952); the newest comes first (PNU 945)`);
  }

  #toggle(code) {
    const cause = CAUSES[code].inputs;
    const pressed = this.#buttons.get(code).getAttribute("aria-pressed") === "true";
    const back = Object.fromEntries(Object.keys(cause).map((field) => [field, HEALTHY[field]]));
    this.#change(pressed ? back : cause);
  }
}

/** Whether the inputs make this fault, as far as they do by themselves. */
function present(code, model, inputs) {
  const tests = {
    A: () => inputs.control_supply_volts < 18 || (model === "AG03/1" && inputs.output_supply_volts < 18),
    B: () => inputs.blocked,
    C: () => inputs.friction_newton_metres >= 4.7,
    D: () => inputs.stage_temperature_celsius !== null && inputs.stage_temperature_celsius > 90,
    E: () => inputs.encoder_fault,
    F: () => inputs.internal_fault,
    G: () => inputs.dc_link_volts !== null && inputs.dc_link_volts > 35,
    J: () => inputs.battery_volts < 2.2,
  };
  return tests[code]?.() ?? false;
}

function advice(fault, turnOnDisabled, stillThere) {
  if (fault !== null) {
    const first = stillThere ? "take its cause back, then let the master acknowledge" : "its cause is gone: let the master acknowledge";
    return `Fault ${fault}, ${CAUSES[fault]?.title ?? "unknown"}: ${first} with STW.7 from 0 to 1.`;
  }
  if (turnOnDisabled) return "Acknowledged. Turning on is disabled until the master gives OFF1 (STW.0 = 0) once.";
  return "No fault.";
}

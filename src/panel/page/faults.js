// The faults of a drive: the one it is in and what to do, the buffer, and how to provoke each.
import { html, many, say, mark, Rows } from "./dom.js";

/** Friction that takes more than 2.4 A, Nm per unit of the gear: 4.7 Nm at 48:1, half of it at 24:1. */
const FRICTION_OF_C = 4.7 / 48;
/** The faults: what makes each (docs/drive.md), whether `inputs` do, and the inputs that take the cause back. */
const FAULTS = {
  A: {
    title: "supply below 18 V and more than 200 mA, once the shaft is commanded to turn",
    made: (inputs, model) => inputs.control_supply_volts < 18 || (model === "ag03-1" && inputs.output_supply_volts < 18),
    healthy: { control_supply_volts: 24, output_supply_volts: 24 },
  },
  B: { title: "shaft blocked, once the shaft is commanded to turn", made: (inputs) => inputs.blocked, healthy: { blocked: false } },
  C: {
    title: "more than 2.4 A for more than 4 s, once the shaft is commanded to turn",
    made: (inputs, model, gear) => inputs.friction_torque_newton_metres >= FRICTION_OF_C * gear,
    healthy: { friction_torque_newton_metres: 0 },
  },
  D: { title: "output stage above 90 °C", made: (inputs) => inputs.stage_temperature_celsius > 90, healthy: { stage_temperature_celsius: null } },
  E: { title: "SIN/COS monitoring", made: (inputs) => inputs.encoder_fault, healthy: { encoder_fault: false }, only: "ag03-1" },
  F: { title: "internal error", made: (inputs) => inputs.internal_fault, healthy: { internal_fault: false } },
  G: { title: "intermediate circuit above 35 V", made: (inputs) => inputs.dc_link_volts > 35, healthy: { dc_link_volts: null } },
  J: { title: "battery below 2.2 V", made: (inputs) => inputs.battery_volts < 2.2, healthy: { battery_volts: 3 }, only: "ag03-1" },
};
const BUFFER_LENGTH = 10;

export class Faults {
  #act;
  #model = null;
  #buttons = new Map();
  #buffer;

  /** `act.provoke(code)` makes a cause, `act.takeBack(inputs)` changes inputs so that it goes. */
  constructor(root, act) {
    this.#act = act;
    const list = html("ol", { class: "buffer", "aria-label": "Fault buffer, PNU 945" });
    this.count = html("p", { class: "muted" });
    this.steps = html("p", { class: "steps" });
    this.provoke = html("div", { class: "provoke", role: "group", "aria-label": "Provoke a fault" }, html("span", { class: "muted" }, "Provoke"));
    for (const [code, { title }] of Object.entries(FAULTS)) {
      const button = html("button", { type: "button", title, "aria-label": `Provoke fault ${code}: ${title}`, "aria-pressed": false, onclick: () => this.#toggle(code) }, code);
      this.#buttons.set(code, button);
      this.provoke.append(button);
    }
    root.replaceChildren(this.provoke, this.steps, list, this.count);
    this.#buffer = new Rows(list, () => {
      const element = html("li");
      return {
        element,
        show: ({ code, title }) => {
          say(element, code);
          mark(element, "title", title);
          element.classList.toggle("empty", code === "–");
        },
      };
    });
  }

  /**
   * The `model`, its `gear` and its `inputs`, the fault `latched` or null, whether its cause is `present`, whether turn-on
   * is disabled, the `buffer` of PNU 945, and the `count` of PNU 952.
   */
  show({ model, gear, inputs, latched, present, turnOnDisabled, buffer, count }) {
    this.#model = model;
    for (const [code, button] of this.#buttons) {
      const { only } = FAULTS[code];
      button.hidden = only !== undefined && only !== model;
      mark(button, "aria-pressed", FAULTS[code].made(inputs, model, gear));
    }
    say(this.steps, advice(latched, present, turnOnDisabled));
    const places = Array.from({ length: BUFFER_LENGTH }, (_, index) => ({ index, code: buffer[index]?.code ?? "–", title: buffer[index]?.text ?? "empty" }));
    this.#buffer.show(places, ({ index }) => index);
    say(this.count, `${many(count, "fault")} counted (PNU 952); the last ten above (PNU 945).`);
  }

  #toggle(code) {
    const pressed = this.#buttons.get(code).getAttribute("aria-pressed") === "true";
    if (!pressed) {
      this.#act.provoke(code);
      return;
    }
    const { output_supply_volts: output, ...both } = FAULTS[code].healthy;
    const ofAg03_1 = output !== undefined && this.#model === "ag03-1";
    this.#act.takeBack(ofAg03_1 ? { ...both, output_supply_volts: output } : both);
  }
}

/**
 * Whether the cause of the latched fault persists. Blocked shaft and friction are causes only while the motor turns, and
 * in the way as long as they are there.
 */
export function causeIsThere({ latched, causes, provoked }) {
  return causes.length > 0 || (latched !== null && provoked.some(({ code }) => code === latched.code));
}

/** The way out of a fault; `next` are the control words to send, null if none helps yet. */
export function wayOut(present, next) {
  if (present) return "Next: remove its cause. Then the master acknowledges with STW.7 from 0 to 1 and gives OFF1 (STW.0 = 0) once.";
  return `Next: ${next ?? "the master acknowledges with STW.7 from 0 to 1 and gives OFF1 (STW.0 = 0) once"}.`;
}

function advice(latched, present, turnOnDisabled) {
  if (latched !== null) {
    const first = present ? "Remove its cause, then let the master acknowledge" : "Its cause is gone: let the master acknowledge";
    return `Fault ${latched.text}. ${first} with STW.7 from 0 to 1.`;
  }
  if (turnOnDisabled) return "Acknowledged. Turning on is disabled until the master gives OFF1 (STW.0 = 0) once.";
  return "No fault.";
}

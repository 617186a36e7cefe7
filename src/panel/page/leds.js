// The two LEDs: whether they are lit at a time, and what they tell.

/**
 * Whether an LED as the API describes it is lit `ms` after the sample. Both LEDs of a factory reset alternate; there the
 * sample says which is on.
 */
export function isLit(led, ms) {
  if (led.pattern !== "blinking") return led.lit;
  const blink = led.on_milliseconds + led.off_milliseconds;
  const sequence = led.blinks * blink + led.pause_milliseconds;
  const within = (led.phase_milliseconds + ms) % sequence;
  return within < led.blinks * blink && within % blink < led.on_milliseconds;
}

/** What the status LED of a drive tells (ag03.md 3.5): short, it has to fit on the housing. */
export function statusText({ status_led: led, fault, model, power, inputs }) {
  const enabling = model === "ag03";
  switch (led.pattern) {
    case "blinking":
      return `${led.blinks} ${led.blinks === 1 ? "blink" : "blinks"}: fault ${fault}`;
    case "alternating":
      return "alternates: reset";
    case "on":
      return enabling ? "lit: enabled" : "lit: supplied";
    default:
      return enabling && power === "on" && !inputs.enable ? "dark: no enable" : "dark: no supply";
  }
}

/** What the bus LED tells. */
export function busText(led) {
  switch (led.pattern) {
    case "alternating":
      return "alternates: reset";
    case "on":
      return "lit: Data_Exchange";
    default:
      return "dark: no exchange";
  }
}

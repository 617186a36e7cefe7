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

/** What the status LED tells. */
export function statusText(led, fault) {
  switch (led.pattern) {
    case "blinking":
      return `blinks ${led.blinks === 1 ? "once" : `${led.blinks} times`}: fault ${fault}`;
    case "alternating":
      return "alternates: reset";
    case "on":
      return "lit: supplied";
    default:
      return "dark: no supply";
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

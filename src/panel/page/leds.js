// The two LEDs: what they tell, and whether they are lit at a time.

/** How the status LED blinks: lit, dark, and a pause after the last blink (profidrive::drive::leds). */
const BLINK_ON_MS = 250;
const BLINK_OFF_MS = 250;
const BLINK_PAUSE_MS = 1250;

/** Whether an LED that blinks so often is lit `ms` after a sequence began. */
export function isLit(blinks, ms) {
  const blink = BLINK_ON_MS + BLINK_OFF_MS;
  const within = ms % (blinks * blink + BLINK_PAUSE_MS);
  return within < blinks * blink && within % blink < BLINK_ON_MS;
}

// The curves on their canvas: axes, lanes, marks of what happened, the cursor.

export const LEFT = 64;
export const RIGHT = 20;
const TOP = 22;
const BOTTOM = 24;
const GAP = 38;
/** Between two lines of time in pixels: room for a label. */
const TICK = 68;
/** How high a lane is; the first one is twice as high: where something is matters most. */
const LANE = 65;
/** A lane shows so much of its unit at least: noise is not a curve. */
const LEAST = { mA: 200, A: 0.5 };
const LEAST_OF_OTHERS = 10;
/** The colours of the lanes, in their order. */
const LANE_COLORS = ["accent", "curve-speed", "curve-current", "ink"];

/** The height of a canvas with so many lanes. */
export function height(lanes) {
  return TOP + BOTTOM + LANE * (lanes + 1) + GAP * (lanes - 1);
}

/** Paints the samples between two times; `cursor` is a share of the width or null, `pins` are chosen times or null. */
export function paint(context, { width, height, left, right, samples, marks, lanes, cursor, pins, colors }) {
  const x = (time) => LEFT + (time - left) / (right - left) * (width - LEFT - RIGHT);
  const share = (height - TOP - BOTTOM - GAP * (lanes.length - 1)) / (lanes.length + 1);
  paintTime(context, colors, x, left, right, height);
  for (const mark of marks) paintMark(context, colors, mark, x(mark.time_s), height);
  let top = TOP;
  lanes.forEach((lane, index) => {
    const tall = index === 0 ? 2 * share : share;
    paintLane(context, colors, { ...lane, color: colors[LANE_COLORS[index % LANE_COLORS.length]], level: index > 0 }, samples, x, { top, bottom: top + tall, width });
    top += tall + GAP;
  });
  const [pinned, measured] = pins;
  if (pinned !== null && measured !== null) {
    context.fillStyle = colors.line;
    context.globalAlpha = 0.5;
    context.fillRect(x(Math.min(...pins)), TOP, Math.abs(x(measured) - x(pinned)), height - TOP - BOTTOM);
    context.globalAlpha = 1;
  }
  context.strokeStyle = colors.ink;
  for (const pin of pins) if (pin !== null && pin >= left && pin <= right) line(context, Math.round(x(pin)) + 0.5, TOP - 4, Math.round(x(pin)) + 0.5, height - BOTTOM);
  if (cursor === null) return;
  const at = Math.round(LEFT + cursor * (width - LEFT - RIGHT)) + 0.5;
  context.strokeStyle = colors.ink;
  context.setLineDash([2, 3]);
  line(context, at, TOP - 4, at, height - BOTTOM);
  context.setLineDash([]);
}

function paintTime(context, colors, x, left, right, height) {
  const step = nice((right - left) * TICK / (x(right) - x(left)));
  context.fillStyle = colors.muted;
  context.strokeStyle = colors.line;
  context.textAlign = "center";
  for (let time = Math.ceil(left / step) * step; time <= right; time += step) {
    if (time < 0) continue;
    const at = Math.round(x(time)) + 0.5;
    line(context, at, TOP, at, height - BOTTOM);
    context.fillText(`${Number(time.toFixed(2))} s`, at, height - 7);
  }
}

/** A line with a head for something that happened. */
function paintMark(context, colors, { kind }, place, height) {
  const at = Math.round(place) + 0.5;
  context.strokeStyle = context.fillStyle = colors[kind] ?? colors.muted;
  context.setLineDash([1, 4]);
  line(context, at, TOP, at, height - BOTTOM);
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(at - 4, TOP - 6);
  context.lineTo(at + 4, TOP - 6);
  context.lineTo(at, TOP);
  context.fill();
}

function paintLane(context, colors, lane, samples, x, { top, bottom, width }) {
  const keys = [...lane.setpoints, lane.key];
  const values = samples.flatMap((sample) => keys.map((key) => numberOf(sample.values[key]))).filter((value) => value !== null);
  const { low, high } = range(values, LEAST[lane.unit] ?? LEAST_OF_OTHERS, lane.level);
  const y = (value) => bottom - (value - low) / (high - low) * (bottom - top);
  context.textAlign = "left";
  context.fillStyle = colors.ink;
  context.fillText(lane.unit ? `${lane.name}, ${lane.unit}` : lane.name, LEFT, top - 9);
  context.textAlign = "right";
  context.strokeStyle = colors.line;
  context.fillStyle = colors.muted;
  const step = nice((high - low) / Math.max((bottom - top) / 32, 1));
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
    const at = Math.round(y(value)) + 0.5;
    line(context, LEFT, at, width - RIGHT, at);
    context.fillText(value.toFixed(digits).replace(/^-(?=0*\.?0*$)/, ""), LEFT - 7, at + 4);
  }
  context.save();
  context.beginPath();
  context.rect(LEFT, top - 3, width - LEFT - RIGHT, bottom - top + 6);
  context.clip();
  for (const key of lane.setpoints) paintLine(context, samples, key, { color: colors.muted, setpoint: true }, x, y);
  paintLine(context, samples, lane.key, { color: lane.color, setpoint: false }, x, y);
  context.restore();
}

function paintLine(context, samples, key, { color, setpoint }, x, y) {
  context.strokeStyle = color;
  context.lineWidth = setpoint ? 1.25 : 1.75;
  context.setLineDash(setpoint ? [5, 4] : []);
  context.lineJoin = "round";
  context.beginPath();
  let down = false;
  let before = null;
  for (const sample of samples) {
    const value = numberOf(sample.values[key]);
    if (value === null) {
      down = false;
      continue;
    }
    if (!down || sample.gap) context.moveTo(x(sample.time_s), y(value));
    // A setpoint does not move to its next value, it is another one.
    else if (setpoint) context.lineTo(x(sample.time_s), y(before));
    context.lineTo(x(sample.time_s), y(value));
    before = value;
    down = true;
  }
  context.stroke();
  context.setLineDash([]);
  context.lineWidth = 1;
}

function numberOf(value) {
  return typeof value === "number" ? value : null;
}

function line(context, x1, y1, x2, y2) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

/** What an axis shows: all values with some air, and not less than `least`; `fromZero` puts 0 at an edge if it can be. */
function range(values, least, fromZero) {
  let low = 0;
  let high = 0;
  if (values.length > 0) {
    low = values.reduce((a, b) => Math.min(a, b));
    high = values.reduce((a, b) => Math.max(a, b));
  }
  const air = (high - low) * 0.08;
  if (fromZero && low >= 0) return { low: 0, high: Math.max(high + air, least) };
  if (fromZero && high <= 0) return { low: Math.min(low - air, -least), high: 0 };
  const more = Math.max(air, (least - (high - low)) / 2);
  return { low: low - more, high: high + more };
}

/** The next step of 1, 2 or 5 times a power of ten. */
function nice(step) {
  const power = 10 ** Math.floor(Math.log10(step));
  return [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= step);
}

/** The colours of the page in effect, for the canvas. */
export function colors(element) {
  const style = getComputedStyle(element);
  const color = (name) => style.getPropertyValue(`--${name}`).trim();
  const own = ["ink", "muted", "line", "fault", ...LANE_COLORS];
  return { font: style.fontFamily, refusal: color("warn"), ...Object.fromEntries(own.map((name) => [name, color(name)])) };
}

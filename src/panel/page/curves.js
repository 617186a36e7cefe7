// Position, speed and current against the time of the bus, with a cursor and zoom.
import { html, say } from "./dom.js";
import { inUnit } from "./states.js";

const SPANS_S = [5, 10, 30, 60, 120, 300];
const KEPT = 20_000;
const RARE_S = 0.12;
/** A state comes once a second at least: a shaft that stands at both ends of a gap no longer than this has not moved. */
const SILENCE_S = 1.3;
/** The time axis is not shorter than this, however few samples there are. */
const LEAST_S = 1;
/** What is drawn. A position has the unit of the samples; the others go from 0 as long as nothing is below. */
const LANES = [
  { name: "Position", unit: null, lines: [{ key: "setpoint", class: "setpoint" }, { key: "position", class: "position" }], least: 10 },
  { name: "Speed", unit: "rpm", lines: [{ key: "speed_setpoint_rpm", class: "setpoint" }, { key: "speed_rpm", class: "speed" }], least: 10 },
  { name: "Current", unit: "mA", lines: [{ key: "current_ma", class: "current" }], least: 200 },
];
/** What happened, so many at most; how near the cursor must be in pixels to tell of it. */
const MARKS = 500;
const NEAR = 6;
const LEFT = 64;
const RIGHT = 20;
const TOP = 22;
const BOTTOM = 24;
const GAP = 38;
/** Between two lines of time in pixels: room for a label. */
const TICK = 68;

export class Curves {
  #samples = [];
  #span = 10;
  /** The time at the right edge in s; `null` while the curves follow the newest sample. */
  #end = null;
  /** Where the cursor is between the left edge (0) and the right one (1), or `null` without one. */
  #cursor = null;
  #drag = null;
  #dirty = true;
  #colors = {};
  /** What happened, by number. */
  #marks = new Map();

  /** `save` is a link that saves them. */
  constructor(root, save) {
    this.canvas = html("canvas", {
      class: "curves",
      tabindex: 0,
      role: "img",
      "aria-label": "Position, speed and current against time",
      "aria-describedby": "curves-keys",
    });
    this.readout = html("p", { class: "readout" });
    this.follow = html("button", { type: "button", "aria-pressed": true, onclick: () => this.#go(this.#end === null ? this.#newest() : null) }, "Follow");
    this.scale = html("span", { class: "scale" });
    this.happened = html("p", { class: "happened" });
    root.replaceChildren(
      html(
        "div",
        { class: "toolbar" },
        this.readout,
        html("span", { class: "spacer" }),
        html(
          "span",
          { class: "group" },
          html("button", { type: "button", "aria-label": "Show more time", onclick: () => this.#zoom(1) }, "−"),
          this.scale,
          html("button", { type: "button", "aria-label": "Show less time", onclick: () => this.#zoom(-1) }, "+"),
          this.follow,
          save,
        ),
      ),
      this.canvas,
      this.happened,
      html("p", { class: "hint", id: "curves-keys" }, "Point at the curves or use ← → to move the cursor. Drag, or Page Up and Page Down: earlier or later. + −: zoom. Home: follow."),
    );
    this.#listen();
    const look = () => {
      this.#colors = colors(this.canvas);
      this.#dirty = true;
    };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", look);
    new ResizeObserver(look).observe(this.canvas);
  }

  /** Another drive: its curves begin anew. */
  clear() {
    this.#samples = [];
    this.#marks.clear();
    this.#cursor = null;
    this.#go(null);
  }

  /** Samples of before; of those that are there already none comes twice. */
  addBefore(samples) {
    const first = this.#samples[0];
    const older = first ? samples.filter(({ time_s, unit }) => time_s < first.time_s && unit === first.unit) : samples;
    const unit = older.at(-1)?.unit;
    this.#samples.unshift(...older.filter((sample) => sample.unit === unit).map((sample) => ({ ...sample, gap: false })));
    this.#dirty = true;
  }

  /** Something that happened: `{ number, time_s, kind, text }`. */
  mark({ number, time_s, kind, text }) {
    if (number === undefined || time_s === null) return;
    this.#marks.set(number, { time_s, kind, text });
    if (this.#marks.size > MARKS) this.#marks.delete(this.#marks.keys().next().value);
    this.#dirty = true;
  }

  /**
   * A sample `{ time_s, position, setpoint, speed_setpoint_rpm, speed_rpm, current_ma, unit }`; setpoints may be null.
   * `lost` says that samples before it are: the curves are broken there, unless the shaft stood all the while.
   */
  add(sample, lost = false) {
    // A position in another unit is another position, and time that goes back is another clock.
    const before = this.#samples.at(-1);
    // What the server has kept may be newer than a state on its way.
    if (before && sample.time_s < before.time_s && before.time_s - sample.time_s < SILENCE_S) return;
    if (before && before.time_s > sample.time_s) this.clear();
    else if (before && before.unit !== sample.unit) this.#samples = [];
    const last = this.#samples.at(-1);
    if (last && sample.time_s === last.time_s) return;
    const stood = last && [last, sample].every(({ speed_rpm }) => speed_rpm === 0) && last.position === sample.position;
    const gap = lost && !(stood && sample.time_s - last.time_s < SILENCE_S);
    // Nothing is told of a shaft that stands until something changes: it stood until now.
    if (last && !gap && last.speed_rpm === 0 && sample.time_s - last.time_s > RARE_S) {
      this.#samples.push({ ...last, time_s: sample.time_s - RARE_S / 2, gap: false });
    }
    this.#samples.push({ ...sample, gap });
    if (this.#samples.length > KEPT) this.#samples.splice(0, KEPT / 10);
    this.#dirty = true;
  }

  /** Paints if there is something new to see. */
  paint() {
    if (!this.#dirty || this.canvas.clientWidth === 0) return;
    this.#dirty = false;
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = `11px ${this.#colors.font}`;
    this.#paintAll(context, width, height);
    this.#tell();
  }

  #newest() {
    return this.#samples.at(-1)?.time_s ?? 0;
  }

  #right() {
    return this.#end ?? this.#newest();
  }

  #go(end) {
    const oldest = this.#samples[0]?.time_s ?? 0;
    this.#end = end === null || end > this.#newest() ? null : Math.max(end, Math.min(oldest + this.#span, this.#newest()));
    this.follow.setAttribute("aria-pressed", this.#end === null);
    this.#dirty = true;
  }

  /** The time shown, `{ left, right }` in s: the span, or all there is as long as that is less. */
  #shown() {
    const right = this.#right();
    const all = Math.max(right - (this.#samples[0]?.time_s ?? right), LEAST_S);
    return { left: right - Math.min(this.#span, all), right };
  }

  /** The time under the cursor, `null` without one. */
  #time() {
    const { left, right } = this.#shown();
    return this.#cursor === null ? null : left + (right - left) * this.#cursor;
  }

  /** Puts the cursor on a time, as far as that is shown. */
  #put(time) {
    const { left, right } = this.#shown();
    this.#cursor = Math.min(Math.max((time - left) / (right - left), 0), 1);
    this.#dirty = true;
  }

  /** Around the cursor if curves that stand have one: what it points at stays where it is. */
  #zoom(step) {
    const time = this.#time();
    const place = SPANS_S.indexOf(this.#span) + step;
    this.#span = SPANS_S[Math.min(Math.max(place, 0), SPANS_S.length - 1)];
    this.#dirty = true;
    if (time === null || this.#end === null) return;
    const { left, right } = this.#shown();
    this.#go(Math.min(time + (right - left) * (1 - this.#cursor), this.#newest()));
    this.#put(time);
  }

  #listen() {
    const canvas = this.canvas;
    const shareAt = (event) => {
      const box = canvas.getBoundingClientRect();
      const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
      return Math.min(Math.max(share, 0), 1);
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.#drag = { x: event.clientX, end: this.#right(), moved: false };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.#drag && Math.abs(event.clientX - this.#drag.x) > 3) this.#drag.moved = true;
      if (this.#drag?.moved) {
        const width = canvas.clientWidth - LEFT - RIGHT;
        const { left, right } = this.#shown();
        this.#go(this.#drag.end - (event.clientX - this.#drag.x) / width * (right - left));
      }
      this.#cursor = shareAt(event);
      this.#dirty = true;
    });
    canvas.addEventListener("pointerup", () => (this.#drag = null));
    canvas.addEventListener("pointercancel", () => (this.#drag = null));
    canvas.addEventListener("pointerleave", () => {
      this.#cursor = null;
      this.#dirty = true;
    });
    canvas.addEventListener("wheel", (event) => {
      // Without a key the wheel scrolls the page, as everywhere.
      if (!event.ctrlKey && !event.shiftKey) return;
      event.preventDefault();
      this.#zoom(Math.sign(event.deltaY || event.deltaX));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  #key(event) {
    const { left, right } = this.#shown();
    const keys = {
      ArrowLeft: () => this.#point(-0.01),
      ArrowRight: () => this.#point(0.01),
      PageUp: () => this.#go(right - (right - left) / 2),
      PageDown: () => this.#go(right + (right - left) / 2),
      Home: () => {
        this.#cursor = null;
        this.#go(null);
      },
      Escape: () => (this.#cursor = null),
      "+": () => this.#zoom(-1),
      "-": () => this.#zoom(1),
    };
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    act();
    this.#dirty = true;
  }

  /** Moves the cursor by a `share` of the width. What it points at stays where it is: the curves stand. */
  #point(share) {
    if (this.#end === null) this.#go(this.#newest());
    this.#cursor = Math.min(Math.max((this.#cursor ?? 1) + share, 0), 1);
  }

  /** The newest sample at `time`, or before. */
  #at(time) {
    let [low, high] = [0, this.#samples.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#samples[middle].time_s <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  #tell() {
    say(this.scale, `${this.#span} s`);
    const time = this.#time();
    const sample = this.#samples[this.#at(time ?? this.#right())];
    if (!sample) {
      say(this.readout, "no samples yet");
      return;
    }
    const { unit } = sample;
    const target = sample.setpoint;
    const of = (setpoint) => (setpoint === null ? "" : ` (setpoint ${setpoint})`);
    const parts = [
      ...(time === null ? [] : [`${sample.time_s.toFixed(2)} s`]),
      `${inUnit(sample.position, unit)} ${unit.name}${target === null ? "" : ` (target ${inUnit(target, unit)}, ${inUnit(target - sample.position, unit)} to go)`}`,
      `${sample.speed_rpm} rpm${of(sample.speed_setpoint_rpm)}`,
      `${sample.current_ma} mA`,
    ];
    // Lines break between the values only.
    say(this.readout, parts.map((part) => part.replaceAll(" ", "\u00a0")).join("   "));
  }

  #paintAll(context, width, height) {
    const { left, right } = this.#shown();
    const x = (time) => LEFT + (time - left) / (right - left) * (width - LEFT - RIGHT);
    const first = Math.max(this.#at(left), 0);
    const shown = this.#samples.slice(first, this.#at(right) + 2);
    const share = (height - TOP - BOTTOM - GAP * (LANES.length - 1)) / (LANES.length + 1);
    this.#paintTime(context, x, left, right, height);
    this.#paintMarks(context, x, left, right, height);
    let top = TOP;
    LANES.forEach((lane, index) => {
      // Where the shaft is matters most: it gets twice the height.
      const tall = index === 0 ? 2 * share : share;
      this.#paintLane(context, lane, shown, x, { top, bottom: top + tall, width });
      top += tall + GAP;
    });
    if (this.#cursor !== null) {
      const at = Math.round(LEFT + this.#cursor * (width - LEFT - RIGHT)) + 0.5;
      context.strokeStyle = this.#colors.ink;
      context.setLineDash([2, 3]);
      line(context, at, TOP - 4, at, height - BOTTOM);
      context.setLineDash([]);
    }
  }

  #paintTime(context, x, left, right, height) {
    const step = nice((right - left) * TICK / (x(right) - x(left)));
    context.fillStyle = this.#colors.muted;
    context.strokeStyle = this.#colors.line;
    context.textAlign = "center";
    for (let time = Math.ceil(left / step) * step; time <= right; time += step) {
      if (time < 0) continue;
      const at = Math.round(x(time)) + 0.5;
      line(context, at, TOP, at, height - BOTTOM);
      context.fillText(`${Number(time.toFixed(2))} s`, at, height - 7);
    }
  }

  /** A line with a head for each thing that happened; in words below if the cursor is on it, else the newest. */
  #paintMarks(context, x, left, right, height) {
    const shown = [...this.#marks.values()].filter(({ time_s }) => time_s >= left && time_s <= right);
    for (const { time_s, kind } of shown) {
      const at = Math.round(x(time_s)) + 0.5;
      context.strokeStyle = context.fillStyle = this.#colors[kind] ?? this.#colors.muted;
      context.setLineDash([1, 4]);
      line(context, at, TOP, at, height - BOTTOM);
      context.setLineDash([]);
      context.beginPath();
      context.moveTo(at - 4, TOP - 6);
      context.lineTo(at + 4, TOP - 6);
      context.lineTo(at, TOP);
      context.fill();
    }
    const cursor = this.#time();
    const near = shown.filter(({ time_s }) => cursor === null || Math.abs(x(time_s) - x(cursor)) <= NEAR);
    say(this.happened, (cursor === null ? near.slice(-1) : near).map(({ time_s, text }) => `${time_s.toFixed(2)} s: ${text}`).join("; "));
  }

  #paintLane(context, lane, samples, x, { top, bottom, width }) {
    const values = samples.flatMap((sample) => lane.lines.map(({ key }) => sample[key])).filter((value) => value !== null);
    const { low, high } = range(values, lane.least, lane.unit !== null);
    const y = (value) => bottom - (value - low) / (high - low) * (bottom - top);
    context.textAlign = "left";
    context.fillStyle = this.#colors.ink;
    const counted = lane.unit === null ? samples.at(-1)?.unit : { name: lane.unit, each: 1, digits: 0 };
    context.fillText(counted ? `${lane.name}, ${counted.name}` : lane.name, LEFT, top - 9);
    context.textAlign = "right";
    context.strokeStyle = this.#colors.line;
    context.fillStyle = this.#colors.muted;
    const step = nice((high - low) / Math.max((bottom - top) / 32, 1));
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      const at = Math.round(y(value)) + 0.5;
      line(context, LEFT, at, width - RIGHT, at);
      const digits = step >= (counted?.each ?? 1) ? 0 : counted.digits;
      context.fillText((Math.round(value) / (counted?.each ?? 1)).toFixed(digits), LEFT - 7, at + 4);
    }
    context.save();
    context.beginPath();
    context.rect(LEFT, top - 3, width - LEFT - RIGHT, bottom - top + 6);
    context.clip();
    for (const { key, class: name } of lane.lines) this.#paintLine(context, samples, key, name, x, y);
    context.restore();
  }

  #paintLine(context, samples, key, name, x, y) {
    context.strokeStyle = this.#colors[name];
    context.lineWidth = name === "setpoint" ? 1.25 : 1.75;
    context.setLineDash(name === "setpoint" ? [5, 4] : []);
    context.lineJoin = "round";
    context.beginPath();
    let down = false;
    let before = null;
    for (const sample of samples) {
      const value = sample[key];
      if (value === null || value === undefined) {
        down = false;
        continue;
      }
      if (!down || sample.gap) context.moveTo(x(sample.time_s), y(value));
      // A setpoint does not move to its next value, it is another one.
      else if (name === "setpoint") context.lineTo(x(sample.time_s), y(before));
      context.lineTo(x(sample.time_s), y(value));
      before = value;
      down = true;
    }
    context.stroke();
    context.setLineDash([]);
    context.lineWidth = 1;
  }
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
function colors(element) {
  const style = getComputedStyle(element);
  const color = (name) => style.getPropertyValue(`--${name}`).trim();
  return {
    font: style.fontFamily,
    ink: color("ink"),
    muted: color("muted"),
    line: color("line"),
    position: color("accent"),
    setpoint: color("muted"),
    speed: color("curve-speed"),
    current: color("curve-current"),
    fault: color("fault"),
    refusal: color("warn"),
  };
}

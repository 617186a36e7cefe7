// Values that are worth a curve against the time of the bus, with a cursor and zoom.
import { button, html, mark, numberText, say } from "./dom.js";
import { LEFT, RIGHT, colors, height, paint } from "./curve_painting.js";
import { Trigger } from "./trigger.js";

const SPANS_S = [5, 10, 30, 60, 120, 300];
const KEPT = 20_000;
const RARE_S = 0.12;
/** A state comes once a second at least: what is the same at both ends of a gap no longer than this has not moved. */
const SILENCE_S = 1.3;
/** The time axis is not shorter than this, however few samples there are. */
const LEAST_S = 1;
/** What happened, so many at most; how near the cursor must be in pixels to tell of it. */
const MARKS = 500;
const NEAR = 6;

export class Curves {
  #samples = [];
  #lanes = [];
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
  /** The time that was chosen, and the one it is measured to, in s; null: none. */
  #pinned = null;
  #measured = null;
  /** A time around which the curves stand as soon as there is enough behind it; null: none. */
  #around = null;

  /**
   * `save` is a link that saves them; `onPoint(time)` is called when a time is chosen, null: none is any more; `onTrigger({ time_s,
   * text })` when what the trigger waits for has happened.
   */
  constructor(save, onPoint = () => {}, onTrigger = () => {}) {
    this.onPoint = onPoint;
    this.trigger = new Trigger({
      hit: (time_s, text) => {
        this.#around = time_s;
        onTrigger({ time_s, text });
      },
      begin: () => this.#go(null),
    });
    this.canvas = html("canvas", { class: "curves", tabindex: 0, role: "img", "aria-describedby": "curves-keys" });
    this.readout = html("p", { class: "readout" });
    this.follow = button("Follow", () => this.#go(this.#end === null ? this.#newest() : null), { "aria-pressed": true });
    this.scale = html("span", { class: "scale" });
    this.happened = html("p", { class: "happened" });
    const zoom = [["−", 1, "Show more time"], ["+", -1, "Show less time"]].map(([sign, step, label]) => button(sign, () => this.#zoom(step), { "aria-label": label }));
    const tools = html("span", { class: "group" }, zoom[0], this.scale, zoom[1], this.follow, save);
    this.element = html(
      "section",
      { class: "card", id: "curves", "aria-labelledby": "curves-title", hidden: true },
      html("h3", { id: "curves-title" }, "Curves"),
      html("div", { class: "toolbar" }, this.readout, html("span", { class: "spacer" }), tools),
      html("div", { class: "toolbar" }, this.trigger.element),
      this.canvas,
      this.happened,
      html("p", { class: "hint", id: "curves-keys" }, "Point at the curves or use ← → to move the cursor. Click, or Enter: events and telegrams of that time. Shift and click, or m: measure to there. Esc: no more. Drag, or Page Up and Page Down: earlier or later. + −: zoom. Home: follow."),
    );
    this.#listen();
    const look = () => {
      this.#colors = colors(this.canvas);
      this.#dirty = true;
    };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", look);
    new ResizeObserver(look).observe(this.canvas);
  }

  /** They begin anew. */
  clear() {
    this.#samples = [];
    this.#marks.clear();
    this.#cursor = this.#around = null;
    [this.#pinned, this.#measured] = [null, null];
    this.#go(null);
  }

  /** Samples of before, as the API has them; of those that are there already none comes twice. */
  addBefore(samples) {
    const first = this.#samples[0]?.time_s ?? Infinity;
    const older = samples.map(({ time_seconds: time_s, ...values }) => ({ time_s, values, gap: false })).filter(({ time_s }) => time_s < first);
    this.#samples.unshift(...older);
    this.#dirty = true;
  }

  /** Something that happened: `{ number, time_s, kind, text }`. */
  mark(line) {
    const { number, time_s, kind, text } = line;
    if (number === undefined || time_s === null) return;
    // What was before the page came triggers nothing.
    if (!this.#marks.has(number) && time_s >= this.#newest() - SILENCE_S) this.trigger.happened(line);
    this.#marks.set(number, { time_s, kind, text });
    if (this.#marks.size > MARKS) this.#marks.delete(this.#marks.keys().next().value);
    this.#dirty = true;
  }

  /** A state with its values; `gap`: states before it were lost. The curves are broken there, unless nothing moved. */
  show({ values, time_seconds: time_s }, gap) {
    const curves = (values ?? []).filter(({ curve, setpoint_of: setpoint }) => curve || setpoint);
    this.element.hidden = curves.length === 0;
    if (curves.length === 0) return;
    this.#lay(curves);
    this.#add({ time_s, values: Object.fromEntries(curves.map(({ key, value }) => [key, value ?? null])) }, gap);
  }

  /** A lane for each value, with the setpoint of it. A value in another unit is another value. */
  #lay(curves) {
    const lanes = curves
      .filter(({ setpoint_of: setpoint }) => !setpoint)
      .map(({ key, name, unit, digits }) => {
        const setpoints = curves.filter((curve) => curve.setpoint_of === key);
        return { key, name, unit: unit ?? "", digits, setpoints: setpoints.map(({ key }) => key) };
      });
    const same = lanes.map(({ key, unit }) => `${key} ${unit}`).join() === this.#lanes.map(({ key, unit }) => `${key} ${unit}`).join();
    if (!same && this.#lanes.length > 0) this.#samples = [];
    this.#lanes = lanes;
    this.trigger.offer(lanes);
    if (same) return;
    this.canvas.style.height = `${height(lanes.length)}px`;
    this.canvas.setAttribute("aria-label", `${lanes.map(({ name }) => name).join(", ")} against time`);
  }

  #add(sample, lost) {
    const before = this.#samples.at(-1);
    // What the server has kept may be newer than a state on its way. Time that goes back further is another clock.
    if (before && sample.time_s < before.time_s && before.time_s - sample.time_s < SILENCE_S) return;
    if (before && before.time_s > sample.time_s) this.clear();
    const last = this.#samples.at(-1);
    if (last && sample.time_s === last.time_s) return;
    const stood = last && Object.entries(sample.values).every(([key, value]) => last.values[key] === value);
    const gap = lost && !(stood && sample.time_s - last.time_s < SILENCE_S);
    // Nothing is told of what stands until something changes: it stood until now.
    if (last && !gap && sample.time_s - last.time_s > RARE_S) {
      this.#samples.push({ ...last, time_s: sample.time_s - RARE_S / 2, gap: false });
    }
    this.#samples.push({ ...sample, gap });
    this.trigger.see(sample);
    this.#standAround();
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
    const { left, right } = this.#shown();
    const samples = this.#samples.slice(Math.max(this.#at(left), 0), this.#at(right) + 2);
    const marks = [...this.#marks.values()].filter(({ time_s }) => time_s >= left && time_s <= right);
    paint(context, { width, height, left, right, samples, marks, lanes: this.#lanes, cursor: this.#cursor, pins: [this.#pinned, this.#measured], colors: this.#colors });
    this.#tellMarks(marks, (width - LEFT - RIGHT) / (right - left));
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
    if (end === null) this.#around = null;
    this.#end = end === null || end > this.#newest() ? null : Math.max(end, Math.min(oldest + this.#span, this.#newest()));
    mark(this.follow, "aria-pressed", this.#end === null);
    mark(this.follow, "title", this.#end === null ? "A click pauses the curves" : "A click goes on with the newest");
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
    canvas.addEventListener("pointerup", (event) => {
      if (this.#drag && !this.#drag.moved) this.#choose(this.#time(), event.shiftKey);
      this.#drag = null;
    });
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
      Escape: () => {
        this.#cursor = null;
        this.#choose(null);
      },
      Enter: () => this.#choose(this.#time()),
      m: () => this.#choose(this.#time(), true),
      "+": () => this.#zoom(-1),
      "-": () => this.#zoom(1),
    };
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    act();
    this.#dirty = true;
  }

  /** The curves stand with the time of the trigger in their middle, and that time is chosen. */
  #standAround() {
    if (this.#around === null || this.#newest() < this.#around + this.#span / 2) return;
    const time = this.#around;
    this.#around = null;
    this.#go(time + this.#span / 2);
    this.#choose(time);
  }

  /** Shows a time that was chosen elsewhere. */
  point(time) {
    this.#pinned = time;
    const { left, right } = this.#shown();
    if (time < left || time > right) this.#go(Math.min(time + (right - left) / 2, this.#newest()));
    // What stands is looked at.
    else if (this.#end === null) this.#go(this.#newest());
    this.#dirty = true;
  }

  /** A time is chosen, or what it is measured to; null: neither any more. */
  #choose(time, measured = false) {
    if (time === null || !measured || this.#pinned === null) {
      [this.#pinned, this.#measured] = [time, null];
      this.onPoint(time);
    } else {
      this.#measured = time;
    }
    if (time !== null && this.#end === null) {
      this.#go(this.#newest());
      this.#put(time);
    }
    this.#dirty = true;
  }

  /** What is shown: samples, lanes and marks, for a report. */
  get picture() {
    const { left, right } = this.#shown();
    const samples = this.#samples.filter(({ time_s }) => time_s >= left && time_s <= right);
    return { left, right, lanes: this.#lanes, samples, marks: [...this.#marks.values()], all: this.#samples };
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
    const sample = this.#samples[this.#at(time ?? this.#pinned ?? this.#right())];
    if (!sample) {
      say(this.readout, "no samples yet");
      return;
    }
    if (this.#pinned !== null && this.#measured !== null) {
      this.#tellDifference();
      return;
    }
    const { values, time_s } = sample;
    const parts = this.#lanes.map(({ key, unit, digits, setpoints }) => {
      const given = setpoints.map((setpoint) => values[setpoint]).filter((value) => value !== null && value !== undefined);
      const togo = given.length === 0 ? "" : ` (setpoint ${numberText(given[0], digits)})`;
      return `${numberText(values[key] ?? null, digits)} ${unit}${togo}`;
    });
    const all = time === null ? parts : [`${time_s.toFixed(2)} s`, ...parts];
    // Lines break between the values only.
    say(this.readout, all.map((part) => part.replaceAll(" ", "\u00a0")).join("   "));
  }

  /** How much time and how much of each value lies between the two times. */
  #tellDifference() {
    const [from, to] = [this.#pinned, this.#measured].map((time) => this.#samples[this.#at(time)]?.values ?? {});
    const parts = this.#lanes.map(({ key, name, unit, digits }) => {
      const difference = typeof from[key] === "number" && typeof to[key] === "number" ? to[key] - from[key] : null;
      return `${name} ${numberText(difference, digits)} ${unit}`;
    });
    say(this.readout, [`Δ ${(this.#measured - this.#pinned).toFixed(3)} s`, ...parts].map((part) => part.replaceAll(" ", "\u00a0")).join("   "));
  }

  /** What happened in words, if the cursor is on it; without one the newest. */
  #tellMarks(marks, perSecond) {
    const cursor = this.#time();
    const near = cursor === null ? marks.slice(-1) : marks.filter(({ time_s }) => Math.abs(time_s - cursor) * perSecond <= NEAR);
    say(this.happened, near.map(({ time_s, text }) => `${time_s.toFixed(2)} s: ${text}`).join("; "));
  }
}

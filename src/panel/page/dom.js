// Elements of the document. Data only ever becomes text or attributes, never markup.

const SVG = "http://www.w3.org/2000/svg";

/**
 * An HTML element. Attributes that begin with "on" are listeners. `true` and `false` say whether an attribute is there,
 * of ARIA and data attributes they are the value; `undefined` leaves an attribute out.
 */
export function html(tag, attributes = {}, ...children) {
  return build(document.createElement(tag), attributes, children);
}

/** An SVG element, as `html`. */
export function svg(tag, attributes = {}, ...children) {
  return build(document.createElementNS(SVG, tag), attributes, children);
}

function build(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) {
      element.addEventListener(name.slice(2), value);
    } else if (/^(aria|data)-/.test(name) && value !== undefined) {
      element.setAttribute(name, value);
    } else if (value === true) {
      element.setAttribute(name, "");
    } else if (value !== false && value !== undefined) {
      element.setAttribute(name, value);
    }
  }
  element.append(...children);
  return element;
}

/** A number of things in words: `1 line`, `2 lines`. */
export function many(count, thing) {
  return `${count} ${thing}${count === 1 ? "" : "s"}`;
}

/** Sets the text of an element if it is another, so that nothing is announced or painted in vain. */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Sets an attribute if it is another. */
export function mark(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

/** One child for each item, kept by key, so that focus and selection survive an update. */
export class Rows {
  #rows = new Map();

  /** `make(item)` returns `{ element, show(item) }`. */
  constructor(parent, make) {
    this.parent = parent;
    this.make = make;
  }

  /** Items of one key, as two stations at one address, have a row each, in their order. */
  show(items, key) {
    const rows = new Map();
    let before = null;
    for (const item of items) {
      let id = key(item);
      for (let twin = 2; rows.has(id); twin += 1) id = `${key(item)} (${twin})`;
      const row = this.#rows.get(id) ?? this.make(item);
      row.show(item);
      const place = before ? before.nextSibling : this.parent.firstChild;
      if (row.element !== place) this.parent.insertBefore(row.element, place);
      before = row.element;
      rows.set(id, row);
    }
    for (const [id, row] of this.#rows) if (!rows.has(id)) row.element.remove();
    this.#rows = rows;
  }
}

/** A table in a region of its own, which scrolls. */
export class Table {
  #rows;

  /**
   * `label` names it, `columns` are names; those that begin with ">" stand at the right. `texts(item)` are the texts of a
   * row, `first(item)` may make an element for the first cell instead.
   */
  constructor(label, columns, texts, first = null) {
    const body = html("tbody");
    const right = columns.map((name) => (name.startsWith(">") ? "right" : undefined));
    const heads = columns.map((name, place) => html("th", { scope: "col", class: right[place] }, name.replace(">", "")));
    const table = html("table", { class: "table" }, html("thead", {}, html("tr", {}, ...heads)), body);
    this.element = html("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": label }, table);
    this.#rows = new Rows(body, (item) => {
      const made = first?.(item) ?? null;
      const cells = columns.map((_, place) => html("td", { class: right[place] }, ...(made && place === 0 ? [made] : [])));
      const show = (now) => texts(now).forEach((text, place) => made && place === 0 ? null : say(cells[place], text));
      return { element: html("tr", { "data-key": item.key }, ...cells), show };
    });
  }

  /** `items` have a `key` each. */
  show(items) {
    this.#rows.show(items, ({ key }) => key);
  }
}

/** A list of named texts `{ name, text }`. */
export class Figures {
  #rows;

  constructor() {
    this.element = html("dl", { class: "figures" });
    this.#rows = new Rows(this.element, ({ name }) => {
      const value = html("dd");
      return { element: html("div", { "data-figure": name }, html("dt", {}, name), value), show: ({ text }) => say(value, text) };
    });
  }

  show(items) {
    this.#rows.show(items, ({ name }) => name);
  }
}

/** A labelled field. */
export function field(name, input) {
  return html("label", { class: "field" }, `${name} `, input);
}

/** A button that does something. */
export function button(text, act, attributes = {}) {
  return html("button", { type: "button", onclick: act, ...attributes }, text);
}

/** A form that calls `send` in place of leaving the page. */
export function form(attributes, send, ...children) {
  const element = html("form", { class: "form", novalidate: true, ...attributes }, ...children);
  element.addEventListener("submit", (event) => {
    event.preventDefault();
    send();
  });
  return element;
}

/**
 * The number that somebody typed, decimal or hexadecimal with 0x in front; null if nothing was typed. Throws a sentence:
 * what only begins as a number is none.
 */
export function typedNumber(text) {
  const typed = text.trim();
  if (typed === "") return null;
  const hexadecimal = /^(-?)0x([0-9a-f]+)$/i.exec(typed);
  if (hexadecimal) return (hexadecimal[1] === "-" ? -1 : 1) * Number.parseInt(hexadecimal[2], 16);
  if (/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(typed)) return Number(typed);
  throw new RangeError(`'${typed}' is no number: write it as 31, 1.5 or 0x1F. Nothing is changed.`);
}

/** A number for people: at most six digits, no noise of binary fractions; `digits` behind the point if they are given. */
export function numberText(value, digits = undefined) {
  if (value === null || value === undefined) return "–";
  if (typeof value !== "number") return value === true ? "yes" : value === false ? "no" : String(value);
  if (digits !== undefined && digits !== null) return value.toFixed(digits);
  return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(6)));
}

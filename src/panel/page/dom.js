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

  show(items, key) {
    const rows = new Map();
    let before = null;
    for (const item of items) {
      const id = key(item);
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

// Measured values: those worth seeing in a list first and larger, the groups of less interest as a card.
import { Figures, Rows, html, mark, numberText, say } from "./dom.js";
import { valueText } from "./states.js";

/** So many groups are in the strip; the others, and counters, are in a card. */
const IN_STRIP = 2;

function groupsOf(values) {
  return [...new Set((values ?? []).map(({ group }) => group))];
}

export class Values {
  element = html("dl", { id: "values", class: "values" });
  #rows = new Rows(this.element, (item) => new Value(item));

  show({ values, headline }) {
    const shown = groupsOf(values).slice(0, IN_STRIP);
    const main = new Set((headline ?? []).map(({ key }) => key));
    const strip = (values ?? []).filter(({ group }) => shown.includes(group)).map((value) => ({ ...value, main: main.has(value.key) }));
    // Sorting keeps the order of those that are alike.
    strip.sort((a, b) => Number(b.main) - Number(a.main));
    this.element.hidden = strip.length === 0;
    this.#rows.show(strip, ({ key, main }) => `${key} ${main}`);
  }
}

class Value {
  #name = html("dt");
  #value = html("span");
  #unit = html("span", { class: "unit" });

  constructor({ key, main }) {
    this.element = html("div", { class: main ? "main" : "", "data-value": key }, this.#name, html("dd", {}, this.#value, this.#unit));
  }

  show({ name, value, unit, digits }) {
    say(this.#name, name);
    say(this.#value, numberText(value, digits));
    say(this.#unit, value === null ? "" : (unit ?? ""));
    mark(this.element, "title", `${name}: ${valueText({ value, unit, digits })}`);
  }
}

/** The groups behind those of the strip, and the counters. */
export class Groups {
  element = html("section", { class: "card", id: "groups", "aria-labelledby": "groups-title" }, html("h3", { id: "groups-title" }, "Also"));
  #figures = new Map();

  show({ values, counters, eeprom }) {
    const groups = groupsOf(values).slice(IN_STRIP).map((group) => [group, values.filter((value) => value.group === group)]);
    const all = [...groups, ["counters", counters ?? []], ["memory", eeprom ? [{ name: "EEPROM", value: eeprom }] : []]];
    for (const [group, items] of all) {
      if (items.length === 0 && !this.#figures.has(group)) continue;
      this.#of(group).show(items.map((value) => ({ name: value.name, text: valueText(value) })));
    }
    this.element.hidden = all.every(([, items]) => items.length === 0);
  }

  #of(group) {
    if (!this.#figures.has(group)) {
      const figures = new Figures();
      this.#figures.set(group, figures);
      this.element.append(html("h4", {}, group ?? "values"), figures.element);
    }
    return this.#figures.get(group);
  }
}

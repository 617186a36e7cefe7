// What the page does whatever the device is: with devices that it has never heard of, several tabs, states it does not know.
import assert from "node:assert/strict";
import { test } from "node:test";

import { MadeUp, pump } from "./made_up.js";
import { CONNECTED, onStage, text, until } from "./stage.js";

const at = (address) => `/lines/cellar/stations/${address}`;

/** A stage with a server of made-up stations; the page shows the first one. */
async function onMadeUp(stations, play, { view = "#station/cellar/5", ...page } = {}) {
  const server = await MadeUp.start(stations);
  await onStage({ server, master: false, refusals: true, page: { view, ...page } }, (stage) => play({ ...stage, page: stage.page, server, stage }));
}

test("a device that the page has never heard of is shown whole", async () => {
  await onMadeUp([pump(5)], async ({ page, server }) => {
    await text(page, "#station-title", "Station 5");
    await text(page, "#station-state", "pumps");
    await text(page, "#station-about", "Pump 9000 · OPERATIONAL");
    await text(page, "#why-title", "It moves: pumps");
    await text(page, "[data-value=flow] dd", "12.5l/s");
    await text(page, "#device .lcd", "12.5");
    await text(page, "#device .leds", "run green: blinks 2 times");
    await text(page, "#device .dial", "Impeller: 3.25 turns");
    await text(page, "[data-word='6040']", "pump · go".replace(" · ", " "));
    await text(page, "[data-process=rpdo1]", "6040h:00");
    await text(page, "#faults table", "no water");
    await text(page, "#objects tr[data-key='1017:00']", "heartbeat");
    await text(page, "#groups", "starts");
    assert.equal(await page.locator("#parameters").isVisible(), false, "it has none");
    await page.getByRole("button", { name: "Provoke fault dry-run: no water" }).click();
    await until("the request", () => server.asked.at(-1), (asked) => asked?.path === `${at(5)}/provoke`);
    assert.deepEqual(server.asked.at(-1).body, { fault: "dry-run", provoked: true });
    server.stations = [pump(5, { faults: [{ fault: "dry-run", text: "no water", present: true, provoked: true }] })];
    await page.locator("[data-fault=dry-run][aria-pressed=true]").click();
    await until("the request", () => server.asked.at(-1).body, ({ provoked }) => provoked === false);
  });
});

test("with eight tabs every one has its values and every button works", async () => {
  await onMadeUp([pump(5)], async ({ page, server, stage }) => {
    const tabs = [page];
    for (let tab = 0; tab < 7; tab += 1) tabs.push(await stage.another("#station/cellar/5"));
    for (const tab of tabs) await text(tab, "#station-state", "pumps");
    await until("streams", () => server.streams.size, (count) => count <= 3);
    server.stations = [pump(5, { state_text: "spins" })];
    for (const tab of tabs) await text(tab, "#station-state", "spins");
    for (const [number, tab] of tabs.entries()) {
      const before = server.asked.length;
      await tab.getByRole("button", { name: "Power off" }).click();
      await until(`the button of tab ${number}`, () => server.asked.length, (count) => count > before);
    }
    // Whoever uses a tab gets a stream in it.
    await tabs[0].getByRole("button", { name: "Record telegrams" }).click();
    await tabs[0].locator("#connection[data-kind=live]").waitFor();
  });
});

test("a form writes into the station it was made for", async () => {
  await onMadeUp([pump(5), pump(7)], async ({ page, server }) => {
    await page.evaluate(() => (location.hash = "#station/cellar/7"));
    await page.getByRole("button", { name: "Choose 1017h:00, heartbeat" }).click();
    await page.locator("#objects").getByLabel("Value", { exact: true }).fill("250");
    await page.locator("#choose").selectOption("#station/cellar/5");
    await text(page, "#station-title", "Station 5");
    const objects = page.locator("#objects");
    assert.equal(await objects.getByLabel("Number", { exact: true }).inputValue(), "", "nothing of the other station stays");
    assert.equal(await objects.getByLabel("Value", { exact: true }).inputValue(), "");
    await objects.getByRole("button", { name: "Choose 1017h:00, heartbeat" }).click();
    await objects.getByLabel("Value", { exact: true }).fill("0x1F");
    await objects.getByRole("button", { name: "Write" }).click();
    await until("the request", () => server.asked.at(-1), (asked) => asked?.method === "PUT");
    assert.deepEqual(server.asked.at(-1), { method: "PUT", path: `${at(5)}/objects/1017/00`, body: { value: 31 } });
  });
});

test("a held key has a lease that the page renews, and goes up when the view, the window or the tab is left", async () => {
  await onMadeUp([pump(5), pump(7)], async ({ page, server }) => {
    const keys = () => server.asked.filter(({ path }) => path.endsWith("/keys"));
    const pressed = () => keys().at(-1)?.body.pressed;
    const hold = async () => {
      await page.locator("[data-key=prime]").focus();
      await page.keyboard.down("Enter");
      await until("the key", pressed, (down) => down === true);
    };
    await hold();
    await until("renewed", () => keys().length, (count) => count >= 3);
    assert.ok(keys().every(({ body }) => body.lease_milliseconds >= 1000 && body.lease_milliseconds <= 3000), "the device releases it soon without the page");
    await page.evaluate(() => (location.hash = "#station/cellar/7"));
    await until("released", pressed, (down) => down === false);
    assert.equal(keys().at(-1).path, `${at(5)}/keys`, "at the station where it was pressed");
    await page.keyboard.up("Enter");
    await text(page, "#station-title", "Station 7");
    for (const leave of [() => window.dispatchEvent(new Event("blur")), () => (location.hash = "#bus")]) {
      await hold();
      await page.evaluate(leave);
      await until("released", pressed, (down) => down === false);
      await page.keyboard.up("Enter");
    }
    const count = keys().length;
    await page.waitForTimeout(900);
    assert.equal(keys().length, count, "nothing holds it any more");
    await page.goto(new URL("#station/cellar/5", server.panel).href);
    await hold();
    await page.goto(new URL("api/v1/openapi.json", server.panel).href);
    await until("released", pressed, (down) => down === false);
  });
});

test("a state that the page does not understand breaks a part of it for so long, and nothing else", async () => {
  await onMadeUp([pump(5)], async ({ page, server }) => {
    await text(page, "#station-state", "pumps");
    server.stations = [pump(5, { words: [{ key: "6040", value: "?", bits: 3 }], inputs: "none", display: 7, state_text: "odd" })];
    await text(page, "#station-state", "odd");
    await page.locator("#words[data-trouble]").waitFor();
    server.stations = [{ line: "cellar", address: 5 }];
    await until("less to see", () => page.locator("#values").isVisible(), (visible) => !visible);
    server.stations = [pump(5)];
    await text(page, "#station-state", "pumps");
    await page.locator("#words:not([data-trouble])").waitFor();
    await text(page, "[data-value=flow] dd", "12.5");
    for (const view of ["#station/cellar/77", "#drive/5", "#station/nowhere/5", "#bus", "#station/5"]) {
      await page.evaluate((view) => (location.hash = view), view);
      await page.waitForTimeout(200);
    }
    await text(page, "#station-title", "Station 5");
    await text(page, "#station-state", "pumps");
  });
});

test("two stations at one address are two tiles, and a station that goes leaves none", async () => {
  await onMadeUp([pump(5), pump(5), pump(7, { fault: { fault: "dry-run", text: "no water" } })], async ({ page, server }) => {
    const tiles = page.locator(".tile");
    await until("tiles", () => tiles.count(), (count) => count === 3);
    await text(page, "#alarms", "7: dry-run");
    await text(page, "#stations-count", "3 stations, 1 in fault");
    server.stations = [pump(5)];
    await until("tiles", () => tiles.count(), (count) => count === 1);
    await page.locator("#alarms").waitFor({ state: "hidden" });
    await tiles.click();
    await text(page, "#station-state", "pumps");
    server.stations = [];
    await text(page, "#station-state", "not present");
    await text(page, "#why-title", "there is no station at address 5");
    for (const part of ["#values", "#device", "#curves", "#words", "#process"]) assert.ok(!(await page.locator(part).isVisible()), part);
  }, { view: "#stations" });
});

test("ranges and units are those of the API, and what is no number is not taken for one", async () => {
  await onMadeUp([pump(5)], async ({ page, server }) => {
    const number = page.locator("[data-input=level_metres] input[type=text]");
    const give = async (typed) => {
      await number.fill(typed);
      await number.press("Enter");
      await number.blur();
    };
    for (const [typed, said] of [["32", "level of the cellar must be 0 to 31 m, not 32. Nothing is changed."], ["1,5", "'1,5' is no number"], ["1 5", "'1 5' is no number"]]) {
      await give(typed);
      await text(page, "#inputs .refused, .refused:not(:empty)", said);
      assert.equal(server.asked.length, 0, typed);
    }
    await give("0x1F");
    await until("the request", () => server.asked.at(-1), (asked) => asked !== undefined);
    assert.deepEqual(server.asked.at(-1), { method: "PATCH", path: `${at(5)}/inputs`, body: { level_metres: 31 } });
    server.stations = [pump(5, { inputs: [{ input: "level_metres", text: "level", value: 2.5, low: 0, high: 31, may_be_null: false, unit: "m", nominal: 1 }] })];
    await until("the value of the station", () => number.inputValue(), (shown) => shown === "2.5");
    await page.locator("[data-input=level_metres][data-changed=true]").waitFor();
  });
});

test("names of two hundred characters stay in their places", async () => {
  const long = "Verylongname".repeat(17);
  const odd = { product: long, state_text: long, fault: { fault: "x", text: long }, process: [{ key: "a", name: long, from_master: true, octets_hex: "00", details: long, entries: [{ name: long, place: long, value: 1, unit: null }] }] };
  for (const width of [1360, 360]) {
    await onMadeUp([pump(5, odd)], async ({ page }) => {
      await text(page, "#station-about", long);
      for (const view of ["#station/cellar/5", "#stations"]) {
        await page.evaluate((view) => (location.hash = view), view);
        await page.waitForTimeout(300);
        const { wide, room } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: document.documentElement.clientWidth }));
        assert.ok(wide <= room, `${view}: the page is ${wide} wide and has room for ${room}`);
      }
    }, { viewport: { width, height: 800 } });
  }
});

test("a list that stands can be filtered, and telegrams are found by what they say and whose they are", async () => {
  await onMadeUp([pump(5), pump(6)], async ({ page, server }) => {
    await page.getByRole("button", { name: "Record telegrams" }).click();
    const telegram = (address, said) => ({ time_seconds: 1, line: "cellar", from_address: null, to_address: address, octets_hex: "40", text: said, mark: null });
    await page.waitForTimeout(300);
    server.tell("telegram", telegram(5, "605 SDO read 6041h:00"));
    server.tell("telegram", telegram(5, "205 RPDO1"));
    server.tell("telegram", telegram(6, "606 SDO read 1017h:00"));
    const shown = page.locator("#telegram-lines .log li");
    await until("telegrams of the station", () => shown.count(), (count) => count === 2);
    await page.locator("#telegram-lines").getByRole("button", { name: "Pause" }).click();
    server.tell("telegram", telegram(5, "205 RPDO1 again"));
    await text(page, "#telegram-lines .toolbar", "1 more");
    const filter = page.locator("#telegram-lines input[type=search]");
    await filter.fill("0x6041");
    await until("one", () => shown.count(), (count) => count === 1);
    await filter.fill("rpdo");
    await until("one of before the pause", () => shown.allTextContents(), ([only, ...others]) => others.length === 0 && only?.endsWith("205 RPDO1"));
    await page.locator("#telegram-lines").getByRole("button", { name: "Pause" }).click();
    await until("both", () => shown.count(), (count) => count === 2);
  });
});

test("landmarks have names of their own, and what scrolls is reached with the keyboard", async () => {
  await onMadeUp([pump(5)], async ({ page }) => {
    await text(page, "#objects tr[data-key='1017:00']", "heartbeat");
    for (const view of ["#station/cellar/5", "#bus", "#stations"]) {
      await page.evaluate((view) => (location.hash = view), view);
      await page.locator(`${view.split("/")[0]}:visible`).waitFor();
      await page.locator(CONNECTED).waitFor();
      const found = await page.evaluate(() => {
        const seen = [...document.querySelectorAll("section, nav, [role=region]")].filter((element) => element.checkVisibility());
        const names = seen.map((element) => `${element.tagName === "NAV" ? "navigation" : "region"} ${element.getAttribute("aria-label") ?? document.getElementById(element.getAttribute("aria-labelledby"))?.textContent ?? ""}`);
        const twice = names.filter((name, place) => names.indexOf(name) !== place);
        const scrolls = [...document.querySelectorAll("main *")].filter((element) => element.checkVisibility() && /auto|scroll/.test(getComputedStyle(element).overflowY) && element.tagName !== "SELECT");
        const unreached = scrolls.filter((element) => element.tabIndex < 0 && !element.querySelector("button, a, input"));
        return [...twice, ...unreached.map((element) => element.className)];
      });
      assert.deepEqual(found, [], view);
    }
  });
});

// The panel with the keyboard only, on a phone, in light and dark, and with 125 drives.
//
// PROFIDRIVE_SCREENSHOTS=DIR keeps pictures of what the tests see.
import assert from "node:assert/strict";
import { test } from "node:test";
import path from "node:path";

import { onStage, setInput, text, until, value } from "./stage.js";

const PHONE = { width: 360, height: 740 };
const PICTURES = process.env.PROFIDRIVE_SCREENSHOTS;

async function photograph(page, name, options = {}) {
  if (!PICTURES) return;
  // A busy machine is no part of the picture.
  await page.locator("#connection[data-kind=live]").waitFor();
  await page.evaluate(() => scrollTo(0, 0));
  await page.screenshot({ path: path.join(PICTURES, `${name}.png`), ...options });
}

/** Texts whose contrast to what is behind them is below 4.5 (WCAG 2 AA), 3 for large ones. */
function faint(page) {
  return page.evaluate(() => {
    const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    const rgb = (color) => {
      canvas.clearRect(0, 0, 1, 1);
      canvas.fillStyle = color;
      canvas.fillRect(0, 0, 1, 1);
      return [...canvas.getImageData(0, 0, 1, 1).data];
    };
    const luminance = ([red, green, blue]) => {
      const [r, g, b] = [red, green, blue].map((part) => (part / 255 <= 0.04045 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ground = (element) => {
      for (let at = element; at; at = at.parentElement) {
        const color = rgb(getComputedStyle(at).backgroundColor);
        if (color[3] === 255) return color;
      }
      return [255, 255, 255];
    };
    const found = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const element = walker.currentNode.parentElement;
      const text = walker.currentNode.textContent.trim();
      if (text === "" || element.closest("svg, option") || !element.checkVisibility()) continue;
      const style = getComputedStyle(element);
      const [a, b] = [luminance(rgb(style.color)), luminance(ground(element))].sort((x, y) => y - x);
      const ratio = (a + 0.05) / (b + 0.05);
      const large = parseFloat(style.fontSize) >= 18.66;
      if (ratio < (large ? 3 : 4.5)) found.push(`${ratio.toFixed(2)} ${text.slice(0, 40)}`);
    }
    return [...new Set(found)];
  });
}

async function assertFits(page) {
  const { wide, room } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: document.documentElement.clientWidth }));
  assert.ok(wide <= room, `the page is ${wide} wide and has room for ${room}`);
}

/** What sticks out of its card. */
function sticksOut(page) {
  return page.evaluate(() =>
    [...document.querySelectorAll(".card :is(button, select, input, output, p, dd)")]
      .filter((element) => element.checkVisibility() && !element.closest(".scroll, .log"))
      .filter((element) => element.getBoundingClientRect().right > element.closest(".card").getBoundingClientRect().right)
      .map((element) => element.textContent.slice(0, 40) || element.id),
  );
}

/** Rows of values that leave room at their end, and names that leave their place. */
function ragged(page) {
  return page.evaluate(() => {
    const wide = [...document.querySelectorAll("#values :is(dt, dd)")].filter((part) => part.scrollWidth > part.clientWidth);
    const rows = new Map();
    for (const value of document.querySelectorAll("#values > div")) {
      const { top, right } = value.getBoundingClientRect();
      rows.set(Math.round(top), Math.max(rows.get(Math.round(top)) ?? 0, right));
    }
    const end = document.querySelector("#values").getBoundingClientRect().right;
    return [...[...rows.values()].filter((right) => right < end - 4), ...wide.map(({ textContent }) => textContent)];
  });
}

/** A drive that has travelled, refused, and travels again: something to see in every part of the page. */
async function busyDrive(page, master) {
  await master.exchanging(5);
  await master.enable(5);
  await master.travel(5, 1600);
  await master.until(5, "the target", (station) => station.bit(10) && station.hiw === 1600);
  await master.travel(5, 1_200_000);
  await text(page, "#why-refused", "above the upper limit");
  const station = master.station(5);
  station.pkw = [0x13fa, 0, 0, 0];
  await text(page, "#dialogue .log", "23FA 0000 0000 0000");
  station.pkw = [0, 0, 0, 0];
  await setInput(page, "friction_torque_newton_metres", 1.5);
  await master.travel(5, 6400);
  await until("position", () => value(page, "position"), (position) => position > 4000);
  await page.evaluate(() => document.activeElement.blur());
}

for (const colorScheme of ["light", "dark"]) {
  test(`in ${colorScheme}, every text can be read`, async () => {
    await onStage({ page: { colorScheme, viewport: { width: 1360, height: 1270 } } }, async ({ page, master }) => {
      const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
      const bright = Number(/\d+/.exec(ground)[0]) > 128;
      assert.equal(bright, colorScheme === "light", ground);
      await busyDrive(page, master);
      await photograph(page, `panel-${colorScheme}`);
      assert.deepEqual(await faint(page), []);
      await page.getByRole("button", { name: "Provoke fault F:" }).click();
      await text(page, "#station-state", "fault F");
      assert.deepEqual(await faint(page), []);
      for (const view of ["Stations", "Bus"]) {
        await page.getByRole("link", { name: view, exact: true }).click();
        await page.locator(view === "Bus" ? "#counters tbody tr" : ".tile").first().waitFor();
        assert.deepEqual(await faint(page), []);
      }
    });
  });
}

test("on a phone nothing is beside the screen, and what is touched is large enough", async () => {
  await onStage({ page: { viewport: PHONE, hasTouch: true, isMobile: true, deviceScaleFactor: 2 } }, async ({ page, master }) => {
    await busyDrive(page, master);
    await assertFits(page);
    await page.setViewportSize({ ...PHONE, height: 1600 });
    await photograph(page, "panel-phone");
    await page.setViewportSize(PHONE);
    const small = await page.evaluate(() =>
      [...document.querySelectorAll("button, select, input, a, [role=switch], [role=button]")]
        .filter((element) => element.checkVisibility() && !element.closest(".skip"))
        .map((element) => ({ box: element.getBoundingClientRect(), name: element.getAttribute("aria-label") ?? element.textContent }))
        .filter(({ box }) => box.width < 24 || box.height < 24)
        .map(({ box, name }) => `${name}: ${box.width} x ${box.height}`),
    );
    assert.deepEqual(small, [], "WCAG 2.2 asks for 24 x 24");
    await page.getByRole("switch", { name: "the shaft is blocked" }).tap();
    await page.locator("[data-input=blocked] [aria-checked=true]").waitFor();
    for (const view of ["Stations", "Bus"]) {
      await page.getByRole("link", { name: view, exact: true }).tap();
      await page.locator(view === "Bus" ? "#counters tbody tr" : ".tile").first().waitFor();
      await assertFits(page);
    }
    await page.getByLabel("Fault", { exact: true }).fill("no-reply");
    await page.getByLabel("When and where").fill("rate=0.001,station=5");
    await page.locator("#line-faults").getByRole("button", { name: "Add" }).tap();
    await page.getByRole("button", { name: /Remove no-reply/ }).waitFor();
    await assertFits(page);
    assert.deepEqual(await sticksOut(page), []);
  });
});

test("at every width the values fill their rows, and nothing sticks out of its card", async () => {
  for (const drive of ["5", "5,model=ag03"]) {
    await onStage({ drives: ["--drive", drive], master: false }, async ({ page }) => {
      await text(page, "#station-about", "gear 48:1");
      for (const width of [1480, 1280, 1261, 1260, 1000, 700, 360]) {
        await page.setViewportSize({ width, height: 900 });
        await assertFits(page);
        assert.deepEqual(await ragged(page), [], `${drive} at ${width}`);
        assert.deepEqual(await sticksOut(page), [], `${drive} at ${width}`);
      }
    });
  }
});

test("everything can be reached and worked with the keyboard, and the focus is always seen", async () => {
  await onStage({ master: false }, async ({ page }) => {
    await page.locator("#parameters tbody tr").first().waitFor();
    await page.locator("body").focus();
    const reached = new Map();
    for (let step = 0; step < 200; step += 1) {
      await page.keyboard.press("Tab");
      const at = await page.evaluate(() => {
        const element = document.activeElement;
        if (element === document.body) return null;
        const ring = element.querySelector(":scope > .focus");
        const seen = ring ? getComputedStyle(ring).stroke !== "none" : getComputedStyle(element).outlineStyle !== "none";
        const labels = [...(element.labels ?? [])].map((label) => label.textContent).join(" ");
        const by = document.getElementById(element.getAttribute("aria-labelledby") ?? "")?.textContent;
        return { name: (element.getAttribute("aria-label") ?? by ?? (labels || element.textContent)).trim(), seen };
      });
      if (at === null) break;
      assert.ok(at.seen, `the focus is seen on ${at.name}`);
      assert.notEqual(at.name, "", "everything has a name");
      if (reached.has(at.name) && at.name === "Skip to the content") break;
      reached.set(at.name, true);
    }
    for (const name of ["Stations", "Bus", "SW1, address 1", "SW10, bus terminator", "key 1", "key 2", "Power off", "the shaft is blocked", "battery of the encoder, V", "load that pulls the shaft clockwise: 1", "Position, Speed, Current against time", "Provoke fault A: A (supply voltage too low)", "Read", "Write", "Pause"]) {
      assert.ok(reached.has(name), `${name} is reached; got ${[...reached.keys()].join(" | ")}`);
    }

    await page.getByRole("switch", { name: "SW8, factory reset" }).focus();
    await page.keyboard.press("Space");
    await text(page, "#device-text", "1010000 1 00");
    const battery = page.getByRole("slider", { name: "battery of the encoder, V" });
    await battery.focus();
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowRight");
    await page.locator('[data-input="battery_volts"][data-changed=true]').waitFor();
    await page.getByRole("button", { name: "load that pulls the shaft clockwise: 1", exact: true }).focus();
    await page.keyboard.press("Enter");
    await page.locator('[data-input="load_torque_newton_metres"][data-changed=true]').waitFor();
    await page.getByRole("switch", { name: "Give voltage of the intermediate circuit" }).focus();
    await page.keyboard.press("Space");
    const volts = page.getByLabel("voltage of the intermediate circuit", { exact: true });
    await until("the voltage it has", () => volts.inputValue(), (shown) => shown === "24");
    await volts.focus();
    await page.keyboard.press("Control+a");
    await page.keyboard.type("36");
    await page.keyboard.press("Enter");
    await text(page, "#station-state", "fault G");
    await page.getByRole("link", { name: "Bus", exact: true }).focus();
    await page.keyboard.press("Enter");
    await text(page, "#counters", "sent");
  });
});

test("nothing moves by itself for those who do not want it", async () => {
  await onStage({ master: false, page: { reducedMotion: "reduce" } }, async ({ page }) => {
    const moving = () => page.evaluate(() => [...document.querySelectorAll("*")].filter((element) => getComputedStyle(element).transitionDuration !== "0s" || getComputedStyle(element).animationName !== "none").length);
    assert.equal(await moving(), 0);
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#device", "4 blinks: fault D");
    const dark = await page.locator("[data-lamp='status green']").evaluate(async (lamp) => {
      const seen = [];
      new MutationObserver(() => seen.push(lamp.dataset.lit)).observe(lamp, { attributes: true });
      await new Promise((resolve) => setTimeout(resolve, 3000));
      return seen.filter((lit) => lit === "false");
    });
    assert.deepEqual(dark, [], "it stays lit");
    await page.emulateMedia({ reducedMotion: "no-preference" });
    assert.ok((await moving()) > 0);
    await page.locator("[data-lamp='status green'][data-lit=false]").waitFor();
    await page.locator("[data-lamp='status green'][data-lit=true]").waitFor();
  });
});

test("125 drives are seen at a glance, filtered and chosen", async () => {
  const addresses = Array.from({ length: 125 }, (_, index) => index + 1);
  await onStage({ drives: ["--drives", "1-125"], addresses: addresses.slice(0, 100), page: { view: "#stations", viewport: { width: 1360, height: 1030 } } }, async ({ page, master }) => {
    const tiles = page.locator(".tile");
    await until("tiles", () => tiles.count(), (count) => count === 125);
    for (const address of addresses.slice(0, 100)) await master.exchanging(address);
    for (const address of addresses.filter((address) => address % 3 === 0 && address <= 100)) master.station(address).stw = 0x000b;
    await master.until(99, "operation enabled", (station) => station.bit(2));
    const act = (method, path, body) => page.evaluate(([method, path, body]) => fetch(path, { method, headers: { "content-type": "application/json" }, body: JSON.stringify(body) }).then((response) => response.status), [method, path, body]);
    for (const address of [14, 52, 98]) assert.equal(await act("POST", `/api/v1/stations/${address}/provoke`, { fault: "D" }), 200);
    assert.equal(await act("PATCH", "/api/v1/stations/33/inputs", { battery_volts: 2.5 }), 200);
    assert.equal(await act("PUT", "/api/v1/stations/77/power", { on: false }), 200);
    const travelling = [6, 9, 12, 42, 60];
    await Promise.all(travelling.map((address) => master.travel(address, address % 4 === 0 ? -900_000 : 900_000)));
    for (const address of travelling) await master.until(address, "a travel", (station) => !station.bit(13));
    await text(page, "#stations-count", "125 stations, 3 in fault");
    await until("travels", () => page.locator(".tile[data-kind=moving]").count(), (count) => count === travelling.length);
    await photograph(page, "panel-125");

    const kinds = await tiles.evaluateAll((tiles) => tiles.map((tile) => `${tile.dataset.kind} ${tile.querySelector(".word").textContent}`));
    for (const expected of ["fault fault D", "moving travel job active", "ready operation enabled", "idle ready-to-run", "off off", "warning battery low"]) {
      assert.ok(kinds.includes(expected), `${expected} is among ${[...new Set(kinds)]}`);
    }
    // What a tile says fits into it: no word is cut off.
    const cut = () => tiles.evaluateAll((tiles) => tiles.flatMap((tile) => [...tile.children]).filter((part) => part.scrollWidth > part.clientWidth + 1).map((part) => part.textContent));
    for (const width of [1360, 1280, 1000, 700, 360]) {
      await page.setViewportSize({ width, height: 1030 });
      assert.deepEqual(await cut(), [], `at ${width}`);
      await assertFits(page);
    }
    await page.setViewportSize({ width: 1360, height: 1030 });
    assert.deepEqual(await faint(page), []);

    await page.getByRole("searchbox", { name: "Filter stations" }).fill("fault");
    await until("faults", () => tiles.count(), (count) => count === 3);
    await page.getByRole("searchbox", { name: "Filter stations" }).fill("52 98");
    await until("two", () => tiles.count(), (count) => count === 2);
    await page.getByRole("link", { name: "98", exact: false }).last().click();
    await text(page, "#station-title", "Station 98");
    await text(page, "#station-state", "fault D");
    await page.locator("#choose").selectOption("#station/line/77");
    await text(page, "#station-state", "off");

    await page.setViewportSize(PHONE);
    await page.getByRole("link", { name: "Stations", exact: true }).click();
    await assertFits(page);
  });
});

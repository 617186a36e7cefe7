// The panel operated as a person does, with a master at work beside it.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, setInput, text, until, value } from "./stage.js";

const READY = "Ready: an edge of STW.6 starts a travel job";

/** Height in pixels that a curve of this colour takes, and how many columns of pixels it is in. */
function drawn(page, color) {
  return page.locator("canvas.curves").evaluate((canvas, name) => {
    const probe = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(name);
    probe.fillRect(0, 0, 1, 1);
    const wanted = probe.getImageData(0, 0, 1, 1).data;
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const columns = new Set();
    let [top, bottom] = [height, 0];
    for (let place = 0; place < data.length; place += 4) {
      if ([0, 1, 2].some((part) => Math.abs(data[place + part] - wanted[part]) > 12) || data[place + 3] < 250) continue;
      const y = Math.floor(place / 4 / width);
      columns.add((place / 4) % width);
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
    }
    return { height: Math.max(0, bottom - top), columns: columns.size };
  }, color);
}

test("a travel is seen in the numbers, in the words and drawn", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await text(page, "#why-title", READY);
    const before = await drawn(page, "--accent");
    assert.ok(before.height < 10, `a shaft that stands is a level line, got ${before.height} pixels`);
    await master.travel(5, 3200);
    await text(page, "#drive-state", "travel job active");
    await text(page, "#why-title", "Under way");
    // Bit 4 of the system status word, and the number of rpm, of one and the same state.
    const travelling = () => page.evaluate(() => [document.querySelectorAll("#ssw tr")[4].dataset.set, document.querySelector('[data-value="Speed"] dd span').textContent]);
    await until("speed", travelling, ([bit, speed]) => bit === "true" && Number(speed) === 30);
    await until("position", () => value(page, "Position"), (position) => position === 3200);
    await text(page, "#why-title", READY);

    const curve = await until("curve", () => drawn(page, "--accent"), ({ height }) => height > 60);
    assert.ok(curve.columns > 100, `a curve over time, got ${curve.columns} columns`);
    const speed = await drawn(page, "--curve-speed");
    assert.ok(speed.height > 30, `the speed went up and down, got ${speed.height} pixels`);

    // The cursor tells what was: somewhere on the way the shaft was neither here nor there.
    const canvas = page.locator("canvas.curves");
    await canvas.focus();
    const seen = new Set();
    for (let step = 0; step < 90; step += 1) {
      await page.keyboard.press("ArrowLeft");
      const readout = await page.locator(".readout").evaluate((readout) => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve(readout.textContent)))));
      const [, position, rpm] = /s\s+(-?\d+) inc.*?(-?\d+) rpm/.exec(readout) ?? [];
      seen.add(`${Number(position) > 100 && Number(position) < 3100} ${Number(rpm) > 20}`);
    }
    assert.ok(seen.has("true true"), `on its way at speed, got ${[...seen]}`);

    await page.keyboard.press("Home");
    await page.keyboard.press("+");
    await text(page, ".scale", "5 s");
    await page.keyboard.press("-");
    await page.keyboard.press("-");
    await text(page, ".scale", "30 s");
    assert.equal(await page.getByRole("button", { name: "Follow" }).getAttribute("aria-pressed"), "true");
  });
});

test("the reason for a refused start is in plain sight", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await text(page, "#why-title", "It does not start, because");
    await text(page, "#why-reasons", "operation is not enabled");
    await master.enable(5);
    await text(page, "#why-title", READY);
    await master.travel(5, 1_200_000);
    await text(page, "#stw", "activate travel job");
    await text(page, "#zsw", "acknowledgement of target value");
    await text(page, "#why-refused", "travel to 1200000 refused: setpoint is above the upper limit (1000000)");
    await text(page, "#log-lines .log", "travel to 1200000 refused");
    assert.equal(await value(page, "Position"), 0);
  });
});

test("a supply that is flipped takes the torque away, and the page says why", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await text(page, "#why-title", READY);
    await setInput(page, "output_supply_volts", 0);
    await text(page, "#why-reasons", "the supply voltage of the output stage is missing");
    await text(page, "#drive-state", "not ready");
    await page.locator("[data-lamp=status][data-lit=false]").waitFor();
    await master.until(5, "ZSW.0 = 0", (station) => !station.bit(0));
    await page.getByRole("button", { name: "All as it should be" }).click();
    await page.locator("[data-lamp=status][data-lit=true]").waitFor();
    await master.until(5, "operation enabled", (station) => station.bit(2));
    await text(page, "#why-title", READY);

    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#drive-state", "off");
    await master.until(5, "silence", (station) => !station.exchanging);
    await page.getByRole("button", { name: "Power on" }).click();
    await master.exchanging(5);
    await page.locator("[data-lamp=bus][data-lit=true]").waitFor();
  });
});

test("a wrong value is refused with the sentence of the server, and nothing changes", async () => {
  await onStage({ master: false, refusals: true }, async ({ page }) => {
    await page.locator("#pkw-pnu").fill("1004");
    await page.locator("#pkw-value").fill("500");
    await page.getByRole("button", { name: "Write" }).click();
    await text(page, "#pkw .refused", /1004.*100/);
    await page.locator("#pkw-value").fill("60");
    await page.getByRole("button", { name: "Write" }).click();
    await text(page, "#pkw .done", /PNU 1004.*60/);
    await page.getByRole("searchbox", { name: "Filter" }).and(page.locator("#parameters input")).fill("v-Pos");
    await text(page, "#parameters tbody", /1004.*60 rpm/);
    await page.locator("#parameters input").fill("mode");
    await text(page, "#parameters tbody", "2 (positioning mode)");
  });
});

test("master and drive are heard on the parameter channel", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    const station = master.station(5);
    station.pkw = [0x13fa, 0, 0, 0];
    await master.until(5, "the reply", ({ reply }) => reply[0] === 0x23fa);
    await text(page, "#pkw .log", /13FA 0000 0000 0000.*/);
    await text(page, "#pkw .log", /23FA 0000 0000 0000.*/);
  });
});

test("telegrams are told in words and can be filtered", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.locator("#log-lines select").selectOption("telegram");
    await page.locator("#log-lines .log li[data-kind=telegram]").first().waitFor();
    await page.locator("#log-lines input[type=search]").fill("nothing says this");
    await text(page, "#log-lines .toolbar", "0 lines");
    await page.locator("#log-lines select").selectOption("no telegrams");
    await page.locator("#log-lines input[type=search]").fill("switched");
    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#log-lines .log", "switched off");
  });
});

test("the keys turn the shaft as long as they are held, with the mouse and with the keyboard", async () => {
  await onStage({ master: false }, async ({ page }) => {
    await page.locator("[data-lamp=bus][data-lit=false]").waitFor();
    const clockwise = page.getByRole("button", { name: "Key 1, clockwise" });
    const box = await clockwise.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await text(page, "#drive-state", "inching by key");
    const position = await until("position", () => value(page, "Position"), (position) => position < -100);
    await page.mouse.up();
    await until("speed", () => value(page, "Speed"), (speed) => speed === 0);

    await page.getByRole("button", { name: "Key 2, counter-clockwise" }).focus();
    await page.keyboard.down("Enter");
    await until("position", () => value(page, "Position"), (now) => now > position + 100);
    await page.keyboard.up("Enter");
    await until("speed", () => value(page, "Speed"), (speed) => speed === 0);
  });
});

test("a key is released when the page goes while it is held", async () => {
  await onStage({ master: false }, async ({ page, emulator }) => {
    const keys = async () => (await (await fetch(new URL("api/v1/drives/5", emulator.panel))).json()).keys.key_1_pressed;
    await page.getByRole("button", { name: "Key 1, clockwise" }).focus();
    await page.keyboard.down("Enter");
    await until("key", keys, (pressed) => pressed);
    await page.goto(new URL("api/v1/openapi.json", emulator.panel).href);
    await until("key", keys, (pressed) => !pressed);
  });
});

test("DIP switches set the address that the next power-on takes", async () => {
  await onStage({ addresses: [5, 7], refusals: true }, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByRole("switch", { name: "SW2, address 2" }).click();
    await text(page, "#power", "1110000 0 00: address 7 from the next power-on");
    await page.getByRole("button", { name: "Power off" }).click();
    await page.getByRole("button", { name: "Power on" }).click();
    await master.exchanging(7);
    await page.goto(new URL("#drive/7", page.url()).href);
    await text(page, "#drive-title", "Drive 7");
    await text(page, "#power", "1110000 0 00: address 7, terminator off");
  });
});

test("faults on the line are put on and taken off", async () => {
  await onStage({ page: { view: "#bus" } }, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByLabel("Fault", { exact: true }).selectOption("no-reply");
    await page.locator("#line-faults").getByRole("button", { name: "Add" }).click();
    await master.until(5, "silence", (station) => !station.exchanging);
    await page.getByRole("button", { name: "Take no-reply off" }).click();
    await master.exchanging(5);
    const counters = page.locator("#counters tr", { hasText: "sent" }).locator("td").last();
    await until("telegrams", async () => Number(await counters.textContent()), (sent) => sent > 0);
    await page.locator("#stations input").fill("9");
    await page.locator("#stations").getByRole("button", { name: "Add" }).click();
    await text(page, "#counters .scroll tbody", "9");
  });
});

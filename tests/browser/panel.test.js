// The panel operated as a person does, with a master at work beside it.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, setInput, text, until, value } from "./stage.js";

const READY = "Ready: nothing keeps it from moving";

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

/** Where the cursor of the curves is drawn, in pixels of the page from the left: the column with most ink. */
function cursor(page) {
  return page.locator("canvas.curves").evaluate((canvas) => {
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const dark = new Array(width).fill(0);
    for (let place = 0; place < data.length; place += 4) if (data[place + 3] > 250 && data[place] < 40 && data[place + 1] < 40 && data[place + 2] < 50) dark[(place / 4) % width] += 1;
    const most = Math.max(...dark);
    return most > height / 5 ? (dark.indexOf(most) * canvas.clientWidth) / width : -1;
  });
}

test("a travel is seen in the numbers, in the words and drawn", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await text(page, "#why-title", READY);
    const before = await drawn(page, "--accent");
    assert.ok(before.height < 10, `a shaft that stands is a level line, got ${before.height} pixels`);
    await master.travel(5, 3200);
    await text(page, "#station-state", "travel job active");
    await text(page, "#why-title", "It moves");
    // Bit 4 of the system status word, and the number of rpm, of one and the same state.
    const travelling = () => page.evaluate(() => [document.querySelectorAll("[data-word=ssw] li")[4].dataset.set, document.querySelector('[data-value="speed"] dd span').textContent]);
    await until("speed", travelling, ([bit, speed]) => bit === "true" && Number(speed) === 30);
    await until("position", () => value(page, "position"), (position) => position === 3200);
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
      const [, position, rpm] = /s\s+(-?\d+)\sinc.*?(-?\d+)\srpm/.exec(readout) ?? [];
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
    await text(page, "#why-title", "It does not move, because");
    await text(page, "#why-reasons", "operation is not enabled");
    await master.enable(5);
    await text(page, "#why-title", READY);
    await master.travel(5, 1_200_000);
    await text(page, "[data-word=stw]", "activate travel job");
    await text(page, "[data-word=zsw]", "acknowledgement of target value");
    await text(page, "#why-refused", "travel to 1200000 inc refused: setpoint is above the upper limit (1000000 inc)");
    await text(page, "#log-lines .log", "travel to 1200000 inc refused");
    assert.equal(await value(page, "position"), 0);
  });
});

test("a supply that is flipped takes the torque away, and the page says why", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await text(page, "#why-title", READY);
    await setInput(page, "output_supply_volts", 0);
    await text(page, "#why-reasons", "the supply voltage of the output stage is missing");
    await text(page, "#station-state", "not ready");
    await page.locator("[data-lamp='status green'][data-lit=false]").waitFor();
    await master.until(5, "ZSW.0 = 0", (station) => !station.bit(0));
    await page.getByRole("button", { name: "Set all to normal" }).click();
    await page.locator("[data-lamp='status green'][data-lit=true]").waitFor();
    await master.until(5, "operation enabled", (station) => station.bit(2));
    await text(page, "#why-title", READY);

    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#station-state", "off");
    await master.until(5, "silence", (station) => !station.exchanging);
    await page.getByRole("button", { name: "Power on" }).click();
    await master.exchanging(5);
    await page.locator("[data-lamp='bus orange'][data-lit=true]").waitFor();
  });
});

test("a wrong value is refused with the sentence of the server, and nothing changes", async () => {
  await onStage({ master: false, refusals: true }, async ({ page }) => {
    await page.locator("#parameters .key").fill("1004");
    await page.locator("#parameters .form input:not(.key)").fill("500");
    await page.getByRole("button", { name: "Write" }).click();
    await text(page, "#parameters .refused", /1004.*100/);
    await page.locator("#parameters .form input:not(.key)").fill("60");
    await page.getByRole("button", { name: "Write" }).click();
    await text(page, "#parameters .done", /1004 .*60/);
    await page.locator("#parameters input[type=search]").fill("v-Pos");
    await text(page, "#parameters tbody", /1004.*60 rpm/);
    await page.locator("#parameters input[type=search]").fill("mode");
    await text(page, "#parameters tbody", "2 (positioning mode)");
  });
});

test("nothing typed is not written as 0, Enter in the value writes, and a chosen parameter begins anew", async () => {
  await onStage({ master: false, refusals: true }, async ({ page }) => {
    const [pnu, field] = [page.locator("#parameters .key"), page.locator("#parameters .form input:not(.key)")];
    await pnu.fill("1004");
    for (const [wrong, said] of [["", "Nothing is written: there is no value"], ["1.5", /1\.5|whole/], ["1,5", /1,5|number/]]) {
      await field.fill(wrong);
      await page.getByRole("button", { name: "Write" }).click();
      await text(page, "#parameters .refused", said);
      await page.getByRole("button", { name: "Read" }).click();
      await text(page, "#parameters .done", /1004 .*: 30 rpm/);
    }
    await field.fill("0x29");
    await field.press("Enter");
    await text(page, "#parameters .done", /1004 .*: 41 rpm/);
    await pnu.fill("2048");
    await pnu.press("Enter");
    await text(page, "#parameters .refused", "2048");

    await page.getByRole("button", { name: "Choose 945.0," }).click();
    await text(page, "#parameters .done", "945.0 Fault buffer");
    assert.equal(await field.inputValue(), "");
    await page.getByRole("button", { name: "Choose 1000," }).click();
    await text(page, "#parameters .done", "1000 ");
  });
});

test("a value that cannot act on the drive is refused with a sentence, and the one in effect comes back", async () => {
  await onStage({ master: false }, async ({ page }) => {
    await setInput(page, "control_supply_volts", 70);
    await text(page, "#inputs .refused", "supply of the control must be 0 to 60 V, not 70. Nothing is changed.");
    const number = page.locator('[data-input="control_supply_volts"] input[type=text]');
    assert.equal(await number.getAttribute("aria-invalid"), "true");
    await number.blur();
    await until("24 V again", () => number.inputValue(), (shown) => shown === "24");
    await setInput(page, "control_supply_volts", 23);
    await until("23 V", () => value(page, "control_supply"), (volts) => volts === 23);
    await text(page, "#inputs .refused", /^$/);
  });
});

test("with a spindle pitch positions are millimetres, and curves of increments do not become some", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await master.travel(5, 400);
    await until("position", () => value(page, "position"), (position) => position === 400);
    const before = await until("curve", () => drawn(page, "--accent"), ({ height }) => height > 60);
    await page.locator("#parameters .key").fill("1012");
    await page.locator("#parameters .form input:not(.key)").fill("500");
    await page.locator("#parameters .form input:not(.key)").press("Enter");
    await text(page, '[data-value="position"]', /\d\.\d\d ?mm$/);
    await text(page, ".readout", /\d\.\d\d\smm\s+0\srpm/);
    const after = await drawn(page, "--accent");
    assert.ok(after.height < 10, `the curve begins anew, got ${after.height} pixels and had ${before.height}`);
    await page.getByRole("link", { name: "Stations", exact: true }).click();
    await text(page, ".tile .position", /\d\.\d\d mm$/);
  });
});

test("while curves follow, the cursor stays under the pointer and tells what passes; it stays in the picture when they are zoomed", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await master.travel(5, 20_000);
    const canvas = page.locator("canvas.curves");
    const seconds = async () => Number(/^(\d+\.\d+)\ss/.exec(await page.locator(".readout").textContent())?.[1]);
    // Once there are more seconds than the axis shows.
    await page.keyboard.press("Home");
    await page.getByRole("button", { name: "Show less time" }).click();
    await page.waitForTimeout(6000);
    await canvas.scrollIntoViewIfNeeded();
    const box = await canvas.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    const first = await until("a readout", seconds, (time) => time > 0);
    assert.ok(Math.abs((await cursor(page)) - box.width / 2) < 2, `the cursor is at ${await cursor(page)} of ${box.width}`);
    await until("time passes", seconds, (time) => time > first + 2);
    assert.ok(Math.abs((await cursor(page)) - box.width / 2) < 2, `the cursor is at ${await cursor(page)} of ${box.width}`);

    await page.mouse.move(0, 0);
    await canvas.focus();
    for (let step = 0; step < 60; step += 1) await page.keyboard.press("ArrowLeft");
    await page.waitForTimeout(100);
    const pointed = await seconds();
    for (const [key, span] of [["-", "10 s"], ["-", "30 s"], ["+", "10 s"], ["+", "5 s"]]) {
      await page.keyboard.press(key);
      await text(page, ".scale", span);
      await page.waitForTimeout(100);
      assert.ok(Math.abs((await seconds()) - pointed) < 0.2, `at ${span} the cursor is at ${await seconds()}, not ${pointed}`);
      const at = await cursor(page);
      assert.ok(at >= 64 && at <= box.width - 19, `the cursor is in the picture, got ${at}`);
    }
  });
});

test("in velocity mode the setpoint is drawn beside the speed", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.locator("#parameters .key").fill("930");
    await page.locator("#parameters .form input:not(.key)").fill("1");
    await page.locator("#parameters .form input:not(.key)").press("Enter");
    await text(page, "#parameters .done", "velocity mode");
    await master.command(5, 0x000b, 0);
    await master.until(5, "operation enabled", (station) => station.bit(2));
    await master.command(5, 0x004b, 60);
    await text(page, "#why-title", "It moves: travelling with velocity");
    await text(page, ".readout", /rpm\s\(setpoint\s60\)/);
  });
});

test("master and drive are heard on the parameter channel", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    const station = master.station(5);
    station.pkw = [0x13fa, 0, 0, 0];
    await master.until(5, "the reply", ({ reply }) => reply[0] === 0x23fa);
    await text(page, "#dialogue .log", /13FA 0000 0000 0000.*/);
    await text(page, "#dialogue .log", /23FA 0000 0000 0000.*/);
  });
});

test("the keys turn the shaft as long as they are held, with the mouse and with the keyboard", async () => {
  await onStage({ master: false }, async ({ page }) => {
    await page.locator("[data-lamp='bus orange'][data-lit=false]").waitFor();
    const clockwise = page.getByRole("button", { name: "key 1" });
    const box = await clockwise.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await text(page, "#station-state", "inching by key");
    await text(page, "#why-title", "It moves: inching by key");
    assert.equal(await page.locator("#why-reasons li").count(), 0);
    const position = await until("position", () => value(page, "position"), (position) => position < -100);
    await page.mouse.up();
    await until("speed", () => value(page, "speed"), (speed) => speed === 0);

    await page.getByRole("button", { name: "key 2" }).focus();
    await page.keyboard.down("Enter");
    await until("position", () => value(page, "position"), (now) => now > position + 100);
    await page.keyboard.up("Enter");
    await until("speed", () => value(page, "speed"), (speed) => speed === 0);
  });
});

test("a key is released when the page goes while it is held", async () => {
  // Where the page goes to there is no icon, for which a browser asks all the same.
  await onStage({ master: false, refusals: true }, async ({ page, emulator }) => {
    const keys = async () => (await (await fetch(new URL("api/v1/stations/5", emulator.panel))).json()).keys.find(({ key }) => key === "key_1").pressed;
    await page.getByRole("button", { name: "key 1" }).focus();
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
    await text(page, "#device-text", "1110000 0 00: address 7 from the next power-on");
    await page.getByRole("button", { name: "Power off" }).click();
    await page.getByRole("button", { name: "Power on" }).click();
    await master.exchanging(7);
    await page.goto(new URL("#station/7", page.url()).href);
    await text(page, "#station-title", "Station 7");
    await text(page, "#device-text", "1110000 0 00: address 7, terminator off");
  });
});

test("faults on the line are put on and taken off", async () => {
  await onStage({ page: { view: "#bus" } }, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByLabel("Fault", { exact: true }).fill("no-reply");
    await page.locator("#line-faults").getByRole("button", { name: "Add" }).click();
    await master.until(5, "silence", (station) => !station.exchanging);
    await page.getByRole("button", { name: "Remove no-reply" }).click();
    await master.exchanging(5);
    const counters = page.locator("#counters [data-figure='telegrams sent'] dd");
    await until("telegrams", async () => Number(await counters.textContent()), (sent) => sent > 0);
    await page.locator("#devices input").fill("9");
    await page.locator("#devices").getByRole("button", { name: "Add" }).click();
    await text(page, "#counters .scroll tbody", "9");
  });
});

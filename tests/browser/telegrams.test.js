// The two lists of the panel: events, and telegrams with what chooses and ends them.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, text, until } from "./stage.js";

const TELEGRAMS = "#telegram-lines .log li";
const record = (page) => page.getByRole("button", { name: "Record telegrams" });
const recording = async (page) => (await record(page).getAttribute("aria-pressed")) === "true";

test("telegrams are explained in words and can be filtered", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await record(page).click();
    await page.locator(TELEGRAMS).first().waitFor();
    await page.locator("#telegram-lines input[type=search]").fill("nothing says this");
    await text(page, "#telegram-lines .toolbar", "0 lines");
    await page.locator("#log-lines input[type=search]").fill("switched");
    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#log-lines .log", "switched off");
  });
});

test("the log of a drive holds no telegrams of another one", async () => {
  await onStage({ drives: ["--drives", "5-6"] }, async ({ page, master }) => {
    await text(page, "#telegram-lines", "nothing yet");
    await master.exchanging(5);
    await record(page).click();
    await page.locator(TELEGRAMS).first().waitFor();
    await page.locator("#choose").selectOption("#station/line/6");
    await text(page, "#station-title", "Station 6");
    await text(page, "#telegram-lines", "nothing matches");
    assert.equal(await page.locator(TELEGRAMS).count(), 0);
    await page.locator("#choose").selectOption("#station/line/5");
    await page.locator(TELEGRAMS).first().waitFor();
  });
});

test("however many telegrams come, a fault stays in the list of events", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    const fault = page.locator("#log-lines li[data-kind=fault]", { hasText: "fault D" });
    await fault.waitFor();
    // More than either list holds.
    await record(page).click();
    const seen = master.station(5).exchanges;
    await master.until(5, "1100 exchanges", ({ exchanges }) => exchanges >= seen + 1100);
    await until("a full list", () => page.locator(TELEGRAMS).count(), (count) => count === 1000);
    assert.equal(await fault.count(), 1);
    assert.equal(await page.locator("#log-lines li[data-kind=telegram]").count(), 0);
    // And it can be had without what is no trouble.
    await page.locator("#log-lines select").selectOption("trouble");
    assert.equal(await fault.count(), 1);
    assert.equal(await page.locator("#log-lines li[data-kind=dp]").count(), 0);
  });
});

test("changes only leaves out what is as before", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByLabel("changes only").check();
    await record(page).click();
    await page.locator(TELEGRAMS).first().waitFor();
    const seen = master.station(5).exchanges;
    await master.until(5, "200 exchanges", ({ exchanges }) => exchanges >= seen + 200);
    const before = await page.locator(TELEGRAMS).count();
    assert.ok(before < 40, `of 400 telegrams that say the same, ${before} are shown`);
    await master.command(5, 0x0008);
    await page.locator(TELEGRAMS, { hasText: "STW 0008" }).first().waitFor();
    await page.getByLabel("changes only").uncheck();
    await until("all of them", () => page.locator(TELEGRAMS).count(), (count) => count > 200);
  });
});

test("a recording ends soon after its trigger, and soon after a fault if it shall", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByLabel("Stop at").fill("STW 0008");
    await record(page).click();
    await page.locator(TELEGRAMS).first().waitFor();
    assert.equal(await recording(page), true);
    await master.command(5, 0x0008);
    await until("the end", () => recording(page), (on) => !on);
    await text(page, "#telegram-lines .ended", /ended by "stw 0008" at \d+/);
    const count = await page.locator(TELEGRAMS).count();
    const seen = master.station(5).exchanges;
    await master.until(5, "50 exchanges", ({ exchanges }) => exchanges >= seen + 50);
    assert.equal(await page.locator(TELEGRAMS).count(), count, "nothing more is recorded");
    const shown = await page.locator(TELEGRAMS).allTextContents();
    const hit = shown.findIndex((line) => line.includes("STW 0008"));
    assert.equal(shown.length - hit, 51, "the trigger and 50 behind it");

    await page.getByLabel("Stop at").fill("");
    await page.getByLabel("stop on fault").check();
    await record(page).click();
    await until("begun", () => recording(page), (on) => on);
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await until("the end", () => recording(page), (on) => !on);
    await text(page, "#telegram-lines .ended", /ended by a fault at \d+.* fault D/);
  });
});

// Who opens the page late sees what was; curves, events and telegrams are saved as files.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";

import { CONNECTED, onStage, text, until, value } from "./stage.js";

/** What a link of the page saves. */
async function saved(page, name) {
  const download = page.waitForEvent("download");
  await page.getByRole("link", { name }).click();
  const file = await download;
  return { name: file.suggestedFilename(), octets: await readFile(await file.path()) };
}

/** How many columns of the curves have something of the colour of the position. */
function columns(page) {
  return page.locator("canvas.curves").evaluate((canvas) => {
    const probe = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--accent");
    probe.fillRect(0, 0, 1, 1);
    const wanted = probe.getImageData(0, 0, 1, 1).data;
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const rows = new Set();
    for (let place = 0; place < data.length; place += 4) if ([0, 1, 2].every((part) => Math.abs(data[place + part] - wanted[part]) < 12) && data[place + 3] > 250) rows.add(Math.floor(place / 4 / width));
    return rows.size;
  });
}

test("who opens the page after a travel and a fault sees both, marked in the curves, and saves them", async () => {
  await onStage({ drives: ["--drives", "5-6"], page: { view: "#station/6" } }, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    await master.travel(5, 1600);
    await master.until(5, "the target", ({ hiw }) => hiw === 1600);
    await page.evaluate(() => fetch("/api/v1/stations/5/provoke", { method: "POST", headers: { "content-type": "application/json" }, body: '{"fault": "D"}' }));
    await text(page, "#alarms", "5: D");
    // Long enough ago for the samples.
    await new Promise((resolve) => setTimeout(resolve, 600));

    await page.locator("#alarms").getByRole("link", { name: "5: D" }).click();
    await text(page, "#log-lines .log", "fault D (output stage too hot)");
    await text(page, "#log-lines .log", "travel to 1600 inc started");
    for (let step = 0; step < 3; step += 1) await page.getByRole("button", { name: "Show more time" }).click();
    await text(page, ".happened", "operation disabled, motor released: fault");
    const height = await until("curves of before", () => columns(page), (rows) => rows > 60);
    assert.ok(height > 60, "the way from 0 to 1600 is drawn");
    const faults = page.locator("#log-lines li[data-kind=fault]", { hasText: "fault D" });
    assert.equal(await faults.count(), 1);
    // And once, however often the page connects again.
    await page.locator("#choose").selectOption("#station/line/6");
    await text(page, "#station-title", "Station 6");
    await page.locator("#choose").selectOption("#station/line/5");
    await text(page, "#station-title", "Station 5");
    await page.locator(CONNECTED).waitFor();
    await until("the fault", () => faults.count(), (count) => count === 1);

    const curves = await saved(page, "Save as CSV");
    assert.equal(curves.name, "station-5.csv");
    assert.match(curves.octets.toString(), /^time_seconds,position,.*\r\n[\d.]+,0,/);
    assert.match(curves.octets.toString(), /^[\d.]+,1600,/m);
  });
});

test("telegrams that were recorded are saved as a capture", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await page.locator("#telegram-lines .log li").first().waitFor();
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#log-lines .log", "fault D");
    const seen = master.station(5).exchanges;
    await master.until(5, "20 exchanges", ({ exchanges }) => exchanges >= seen + 20);
    const capture = await saved(page, "Save as pcapng");
    assert.equal(capture.name, "profidrive.pcapng");
    assert.equal(capture.octets.readUInt32LE(0), 0x0a0d0d0a, "a section header");
    assert.ok(capture.octets.includes("fault D (output stage too hot)"), "the fault is a comment");
    // Slave_Diag of an owned slave is not asked: what was recorded is Data_Exchange, 23 octets with the frame.
    assert.ok(capture.octets.length > 1000);
  });
});

test("target and distance to go are those of the job, whatever setpoint the bus has meanwhile", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    const shown = (name) => page.locator(`[data-value="${name}"] dd span:first-child`).textContent();
    assert.deepEqual([await shown("target"), await shown("to_go")], ["–", "–"]);
    await master.travel(5, 3200);
    await text(page, "#station-state", "travel job active");
    await master.command(5, master.station(5).stw, -500);
    await until("the target", () => shown("target"), (target) => target === "3200");
    const way = () =>
      page.evaluate(() => ["position", "to_go"].map((name) => Number(document.querySelector(`[data-value="${name}"] dd span`).textContent)));
    const [position, toGo] = await until("a part of the way", way, ([position]) => position > 200 && position < 3000);
    assert.equal(position + toGo, 3200);
    await text(page, ".readout", /\(setpoint\s3200\)/);
    await until("position", () => value(page, "position"), (at) => at === 3200);
    await until("no target", () => shown("target"), (target) => target === "–");
  });
});

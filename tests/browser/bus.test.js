// The bus: telegrams per second, cycle, retries, masters and reply times, as a whole and of each station.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, text, until } from "./stage.js";

const figure = (page, name) => page.locator(`[data-figure="${name}"] dd`).textContent();

test("rates, cycle, masters and reply times are those of the line", async () => {
  await onStage({ drives: ["--drives", "5-6"], addresses: [5], page: { view: "#bus" } }, async ({ page, master }) => {
    await master.exchanging(5);
    await text(page, "[data-figure=Masters] dd", "0 owns 5");
    const perSecond = await until("telegrams per second", async () => parseFloat(await figure(page, "Telegrams")), (rate) => rate > 10);
    // Each cycle is a request and a reply.
    const cycle = await until("a cycle", async () => parseFloat(await figure(page, "Cycle")), (ms) => ms > 0);
    assert.ok(cycle > 1 && cycle < 200, `${cycle} ms, ${perSecond} telegrams/s`);
    await text(page, "[data-figure=Retries] dd", "0.0 %");
    const row = (address) => page.locator(`#rates [data-key="${address}"] td`).allTextContents();
    assert.equal((await row(5))[1], "0");
    assert.deepEqual((await row(6)).slice(1), ["–", "–", "0", "–"]);

    // All replies are in the histogram, of a station and of all.
    const counted = () => page.locator(".histogram li").evaluateAll((rows) => rows.reduce((sum, row) => sum + Number(row.lastChild.textContent), 0));
    await until("replies", counted, (sum) => sum > 20);
    await page.locator("#rates select").selectOption("6");
    await text(page, "#rates", "No reply yet.");
    assert.equal(await counted(), 0);
    await page.locator("#rates select").selectOption("5");
    await until("replies", counted, (sum) => sum > 20);
  });
});

// What axe finds on each view, at three widths: nothing.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { Emulator } from "./emulator.js";
import { CONNECTED, onStage, text } from "./stage.js";

const AXE = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const GSD = fileURLToPath(new URL("../gsd/remote_io.gsd", import.meta.url));
const WIDTHS = [1360, 820, 360];

/** The rules that a view breaks, with where. */
async function violations(page) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target.join(" ")).join(", ")}`);
}

for (const [what, options] of [
  ["a positioning drive", []],
  ["a drive of the profile", ["ppo-drive"]],
  ["a servo drive on CANopen", ["asda-a2"]],
  ["a position indicator", ["ap10"]],
  ["a station from a GSD", [`gsd-station,gsd=${GSD}`]],
]) {
  test(`axe finds nothing on the views of ${what} that somebody tries`, async () => {
    await onStage({ server: await Emulator.try(...options), master: false }, async ({ page }) => {
      await page.locator("#master:not([hidden])").waitFor();
      await page.getByRole("button", { name: "Mark", exact: true }).click({ timeout: 1000 }).catch(() => {});
      for (const width of WIDTHS) {
        await page.setViewportSize({ width, height: 900 });
        assert.deepEqual(await violations(page), [], `station at ${width}`);
      }
      for (const view of ["Stations", "Bus"]) {
        await page.getByRole("link", { name: view, exact: true }).click();
        await page.locator(view === "Bus" ? "#counters" : ".tile").first().waitFor();
        for (const width of WIDTHS) {
          await page.setViewportSize({ width, height: 900 });
          assert.deepEqual(await violations(page), [], `${view} at ${width}`);
        }
      }
    });
  });
}

test("axe finds nothing where a fault, a refusal and telegrams are shown", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#station-state", "fault D");
    await page.locator(CONNECTED).waitFor();
    await text(page, "#telegram-lines .log", "Data_Exchange");
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await page.locator("#log-lines li", { hasText: "fault D" }).first().click();
    for (const width of WIDTHS) {
      await page.setViewportSize({ width, height: 900 });
      assert.deepEqual(await violations(page), [], `at ${width}`);
    }
  });
});

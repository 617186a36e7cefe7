// Faults and refusals: seen wherever one looks, with the way out, and the only things that live regions speak of.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, text, until } from "./stage.js";

/** What a screen reader speaks of without being asked. */
const LIVE = "[role=alert], [role=status], [role=log], [role=marquee], [role=timer], output, [aria-live]:not([aria-live=off])";
const announced = (page, role) => page.locator(`.announced[role=${role}]`).textContent();

/** Counts from now on what changes in live regions; `changes()` gives their texts. */
async function listen(page) {
  await page.evaluate((live) => {
    window.spoken = [];
    new MutationObserver((records) => {
      for (const { target } of records) {
        const region = (target.nodeType === Node.ELEMENT_NODE ? target : target.parentElement)?.closest(live);
        if (region) window.spoken.push(`${region.id || region.className}: ${region.textContent}`);
      }
    }).observe(document.documentElement, { subtree: true, childList: true, characterData: true });
  }, LIVE);
  return () => page.evaluate(() => window.spoken);
}

test("live regions are silent during a travel, and speak once of a refusal and of a fault", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    // A refusal that is minutes old would have its age told again and again.
    await master.enable(5);
    await master.travel(5, 1_200_000);
    await until("the refusal", () => announced(page, "status"), (said) => said.includes("travel to 1200000 inc refused"));
    await master.command(5, master.station(5).stw, 0);
    await text(page, "#why-title", "Ready");
    const changes = await listen(page);
    await master.travel(5, 6400);
    await text(page, "#station-state", "travel job active");
    await master.until(5, "the target", ({ hiw }) => hiw === 6400);
    await text(page, "#why-title", "Ready");
    assert.deepEqual(await changes(), [], "nothing was spoken of a travel");

    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await until("the fault", () => announced(page, "alert"), (said) => said === "Station 5: fault D (output stage too hot)");
    await text(page, "#why-reasons", "remove it, then acknowledge (STW.7 from 0 to 1)");
    await master.travel(5, 0);
    await until("the refusal", () => announced(page, "status"), (said) => said.includes("travel to 0 inc refused: fault D"));
    // As a screen reader has it: roles and texts.
    const tree = await page.locator("body").ariaSnapshot();
    assert.match(tree, /- alert: .*Station 5: fault D \(output stage too hot\)/);
    assert.match(tree, /- status: .*travel to 0 inc refused/);
    const spoken = await changes();
    assert.ok(spoken.filter((said) => said.includes("Station 5: fault D")).length === 1, `once, got ${JSON.stringify(spoken)}`);
    assert.ok(spoken.every((said) => /fault|refused/.test(said)), JSON.stringify(spoken));
  });
});

test("the banner of a fault tells its cause, whether that persists, and the way out", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await master.enable(5);
    const provoke = page.getByRole("button", { name: "Provoke fault D:" });
    await provoke.click();
    await text(page, "#why-title", "Fault D (output stage too hot). Its cause is still present.");
    await text(page, "#why-reasons", "its cause is present: remove it, then acknowledge (STW.7 from 0 to 1)");
    assert.equal(await page.locator("#why").getAttribute("data-kind"), "fault");
    await page.locator("[aria-label^='Provoke fault D:'][aria-pressed=true]").waitFor();
    await provoke.click();
    await text(page, "#why-title", "Fault D (output stage too hot). Its cause is gone.");
    await text(page, "#why-way", /Next: send STW [0-9A-F]{4}, then/);
    // The way that is shown is one: what it says is sent, word by word.
    const words = (await page.locator("#why-way").textContent()).match(/\b[0-9A-F]{4}\b/g);
    for (const word of words) await master.command(5, parseInt(word, 16));
    await text(page, "#why-title", /^(Ready|It moves)/);
    // What is left is the start: a change of STW.6.
    await until("the start", () => page.locator("#why-next").textContent(), (way) => way === "" || /^Next: send STW [0-9A-F]{4}$/.test(way));
  });
});

test("a fault of a drive is seen and announced while something else is shown", async () => {
  await onStage({ drives: ["--drives", "5-6"], master: false }, async ({ page }) => {
    const provoke = (address, fault) =>
      page.evaluate(([address, fault]) => fetch(`/api/v1/stations/${address}/provoke`, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify({ fault }) }).then(({ ok }) => ok), [address, fault]);
    assert.ok(!(await page.locator("#alarms").isVisible()));
    assert.ok(await provoke(6, "D"));
    await text(page, "#alarms", "6: D");
    await until("the fault", () => announced(page, "alert"), (said) => said === "Station 6: fault D (output stage too hot)");
    await page.getByRole("link", { name: "Bus", exact: true }).click();
    assert.ok(await provoke(5, "F"));
    await text(page, "#alarms", "5: F");
    await until("the fault", () => announced(page, "alert"), (said) => said === "Station 5: fault F (internal error)");
    await page.locator("#alarms").getByRole("link", { name: "6: D" }).click();
    await text(page, "#station-state", "fault D");
  });
});

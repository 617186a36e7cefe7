// Many tabs, tabs that are closed or crash, an emulator that comes back with other devices, twins: with the real program.
import assert from "node:assert/strict";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { CONNECTED, onStage, text, until } from "./stage.js";

const GSD = fileURLToPath(new URL("../gsd/remote_io.gsd", import.meta.url));
const TABS = 10;

/** Asks the API as a program does. */
async function api(emulator, method, where, body) {
  const response = await fetch(new URL(`api/v1${where}`, emulator.panel), { method, headers: { "content-type": "application/json" }, body: body && JSON.stringify(body) });
  const answer = await response.text();
  return answer === "" ? null : JSON.parse(answer);
}

const isPressed = async (emulator, address, key) => (await api(emulator, "GET", `/stations/${address}`)).keys.find((one) => one.key === key).pressed;

/** Holds a key of a page down. */
async function hold(page, key) {
  await page.locator(`#device [data-key=${key}]`).hover();
  await page.mouse.down();
}

test("in ten tabs of one browser every button works, and each shows what the others do", async () => {
  await onStage({ master: false }, async ({ page, emulator }) => {
    const tabs = [page];
    const context = page.context();
    for (let tab = 1; tab < TABS; tab += 1) {
      const next = await context.newPage();
      await next.goto(page.url());
      await next.locator(CONNECTED).waitFor();
      tabs.push(next);
    }
    for (const [number, tab] of tabs.entries()) {
      const blocked = number % 2 === 0;
      // A button turns what its tab shows; those without a stream ask once a second.
      await tab.locator(`[data-input=blocked] [aria-checked=${!blocked}]`).waitFor();
      await tab.locator("[data-input=blocked] button").click();
      await until(`the button of tab ${number}`, async () => (await api(emulator, "GET", "/stations/5/inputs")).blocked, (now) => now === blocked);
    }
    for (const tab of tabs) await tab.locator("[data-input=blocked] [aria-checked=false]").waitFor();
  });
});

test("a page finds other devices where it was, and shows them and nothing of the ones before", async () => {
  await onStage({ master: false, refusals: true }, async (stage) => {
    const { page } = stage;
    await text(page, "#station-about", "AG03/1");
    const gone = () => page.locator("#connection[data-kind=lost]").waitFor();
    stage.emulator = await stage.emulator.restart(gone, ["--station", `5,gsd=${GSD}`]);
    await page.locator(CONNECTED).waitFor();
    await text(page, "#station-about", "Remote I/O");
    assert.equal(await page.locator("#words").isVisible(), false, "a station has no control word");
    stage.emulator = await stage.emulator.restart(gone, ["--node", "5,device=asda-a2", "--node", "9,device=ap10"]);
    await page.locator(CONNECTED).waitFor();
    await text(page, "#station-about", "ASDA-A2");
    await text(page, "#objects .table", "6040h");
    stage.emulator = await stage.emulator.restart(gone, ["--drive", "7"]);
    await text(page, "#why-title", /no station at address 5/);
    await page.goto(new URL("#station/7", stage.emulator.panel).href);
    await text(page, "#station-about", "AG03/1");
  });
});

test("twins are two tiles, and one that goes leaves one", async () => {
  const drives = ["--node", "5", "--node", "5,device=ap10,twin"];
  await onStage({ drives, master: false, page: { view: "#stations" } }, async ({ page, emulator }) => {
    const tiles = page.locator("#lines a[href$='/5']");
    await until("tiles", () => tiles.count(), (count) => count === 2);
    await api(emulator, "DELETE", "/stations/5");
    await until("tiles", () => tiles.count(), (count) => count === 1);
    await text(page, "#lines", "AP10");
  });
});

for (const [what, drives, address, key] of [
  ["drive on PROFIBUS", ["--drive", "5"], 5, "key_1"],
  ["node", ["--node", "6,device=ap10"], 6, "star"],
]) {
  test(`a key of a ${what} that a tab holds goes up when the tab is closed, and soon after it has crashed`, async () => {
    await onStage({ drives, master: false, refusals: true, page: { view: `#station/${address}` } }, async ({ page, emulator }) => {
      const context = page.context();
      const open = async () => {
        const tab = await context.newPage();
        await tab.goto(page.url());
        await tab.locator(CONNECTED).waitFor();
        await hold(tab, key);
        await until("the key", () => isPressed(emulator, address, key), (pressed) => pressed);
        return tab;
      };
      const closed = await open();
      await closed.close();
      await until("the key of the closed tab", () => isPressed(emulator, address, key), (pressed) => !pressed);

      const crashed = await open();
      // Longer than a lease: it is renewed as long as the tab lives.
      await new Promise((resolve) => setTimeout(resolve, 2000));
      assert.equal(await isPressed(emulator, address, key), true);
      const devtools = await context.newCDPSession(crashed);
      const gone = crashed.waitForEvent("crash");
      devtools.send("Page.crash").catch(() => {});
      await gone;
      const begun = Date.now();
      await until("the key of the crashed tab", () => isPressed(emulator, address, key), (pressed) => !pressed);
      assert.ok(Date.now() - begun < 3000, `released after ${Date.now() - begun} ms`);
    });
  });
}

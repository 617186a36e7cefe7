// What the page costs, measured: 125 drives that turn, in frames a second and milliseconds from a click to what is seen of it.
//
//   PROFIDRIVE_MEASURE=1 node --test frames.test.js     on a machine that does nothing else, with a release build
//
// Without PROFIDRIVE_MEASURE the same is played, and numbers are told but not judged.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, text, until } from "./stage.js";

const JUDGED = process.env.PROFIDRIVE_MEASURE !== undefined;
const DRIVES = 125;
const SECONDS = JUDGED ? 10 : 3;
/** Headless Chromium paints 60 frames a second at best. */
const LEAST_FRAMES = 50;
const MOST_MS = 60;
const CLICKS = 21;

const api = (page, method, path, body) =>
  page.evaluate(([method, path, body]) => fetch(`/api/v1${path}`, { method, headers: { "content-type": "application/json" }, body: JSON.stringify(body) }).then(({ status }) => status), [method, path, body]);

/** Frames a second in `seconds`, and the longest time between two of them. */
const frames = (page, seconds) =>
  page.evaluate(
    (seconds) =>
      new Promise((resolve) => {
        const begun = performance.now();
        let [count, before, longest] = [0, begun, 0];
        const frame = (now) => {
          count += 1;
          longest = Math.max(longest, now - before);
          before = now;
          if (now - begun < seconds * 1000) requestAnimationFrame(frame);
          else resolve({ perSecond: (count * 1000) / (now - begun), longest });
        };
        requestAnimationFrame(frame);
      }),
    seconds,
  );

/** The median time from a click on `button` to the change of its state that the server tells. */
const latency = (page, button) =>
  page.evaluate(
    async ([selector, clicks]) => {
      const times = [];
      for (let turn = 0; turn < clicks; turn += 1) {
        const button = document.querySelector(selector);
        const said = new Promise((resolve) => new MutationObserver((_, observer) => (observer.disconnect(), resolve())).observe(button, { attributeFilter: ["aria-pressed", "aria-checked"] }));
        const begun = performance.now();
        button.click();
        await said;
        times.push(performance.now() - begun);
        await new Promise((resolve) => setTimeout(resolve, 150));
      }
      return times.sort((a, b) => a - b)[clicks >> 1];
    },
    [button, CLICKS],
  );

test("125 drives turn at 50 frames a second, and a click is seen within 60 ms in the median", async (context) => {
  await onStage({ drives: ["--drives", `1-${DRIVES}`], master: false, page: { view: "#stations" } }, async ({ page }) => {
    const tiles = page.locator(".tile");
    await until("tiles", () => tiles.count(), (count) => count === DRIVES);
    // Without a master a key turns the shaft until it is released.
    for (let address = 1; address <= DRIVES; address += 1) assert.equal(await api(page, "POST", `/stations/${address}/keys`, { key: "key_1", pressed: true }), 200);
    await until("drives that turn", () => page.locator(".tile[data-kind=moving]").count(), (count) => count === DRIVES);
    const plant = await frames(page, SECONDS);
    await page.evaluate(() => (location.hash = "#station/line/60"));
    await text(page, "#station-title", "Station 60");
    await page.locator("#faults [data-fault=B]").waitFor();
    const station = await frames(page, SECONDS);
    const click = await latency(page, "#faults [data-fault=B]");
    const told = (what, { perSecond, longest }) => `${what}: ${perSecond.toFixed(1)} frames/s, longest ${longest.toFixed(0)} ms`;
    context.diagnostic(`${told("all stations", plant)}; ${told("one station", station)}; click ${click.toFixed(0)} ms`);
    assert.ok(plant.perSecond > 0 && station.perSecond > 0 && click > 0);
    if (!JUDGED) return;
    for (const { perSecond } of [plant, station]) assert.ok(perSecond >= LEAST_FRAMES, `${perSecond} frames/s`);
    assert.ok(click <= MOST_MS, `${click} ms`);
  });
});

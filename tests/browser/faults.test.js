// Every fault of the AG03/1 provoked and its cause taken back in the panel, and acknowledged by the master.
import assert from "node:assert/strict";
import { test } from "node:test";

import { onStage, setInput, text, until } from "./stage.js";

/** Code, and whether the shaft must be told to turn for it. */
const FAULTS = [
  ["D", false],
  ["E", false],
  ["F", false],
  ["G", false],
  ["J", false],
  ["A", true],
  ["B", true],
  ["C", true],
];
const BLINKS = { A: 1, B: 2, C: 3, D: 4, E: 5, F: 6, G: 7, J: 10 };

test("each fault A to G and J is provoked, seen, taken back and acknowledged", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    let target = 0;
    const seen = [];
    for (const [code, moving] of FAULTS) {
      await master.enable(5);
      const provoke = page.getByRole("button", { name: `Provoke fault ${code}:` });
      await provoke.click();
      await page.locator(`[aria-label^="Provoke fault ${code}:"][aria-pressed=true]`).waitFor();
      if (moving) {
        // Far enough that fault C, which takes more than 4 s, comes on the way.
        target = target > 0 ? -20_000 : 20_000;
        await master.travel(5, target);
      }
      await text(page, "#station-state", `fault ${code}`);
      await text(page, "#device", `${BLINKS[code]} ${BLINKS[code] === 1 ? "blink" : "blinks"}: fault ${code}`);
      await page.locator("[data-lamp='status green'][data-lit=true]").waitFor();
      await page.locator("[data-lamp='status green'][data-lit=false]").waitFor();
      await text(page, "#why-reasons", "is not acknowledged");
      // Without current there is no cause of A and C any more: the shaft stands.
      await text(page, "#why-reasons", "acknowledge (STW.7 from 0 to 1)");
      seen.unshift(code);
      await text(page, "#groups [data-figure='faults'] dd", String(seen.length));
      await until("the history", () => page.locator("#faults tbody td:first-child").allTextContents(), (codes) => codes.join("") === seen.join(""));
      await page.locator(`#log-lines li[data-kind=fault]`, { hasText: `fault ${code}` }).waitFor();

      await provoke.click();
      await text(page, "#why-title", "Its cause is gone");
      await master.command(5, 0x0001);
      await master.command(5, 0x0081);
      await text(page, "#station-state", "turn-on disabled");
      await master.command(5, 0x0000);
      await text(page, "#station-state", "ready-to-run");
      await text(page, "#why-title", /^(?!Fault)/);
      await page.locator("[data-lamp='status green'][data-lit=true]").waitFor();
    }
  });
});

test("an AG03 is not offered what it does not have", async () => {
  await onStage({ drives: ["--drive", "5,model=ag03"], master: false }, async ({ page }) => {
    await text(page, "#station-about", "AG03, gear 48:1");
    const offered = await page.locator(".provoke button:visible").allTextContents();
    assert.deepEqual(offered, ["A", "B", "C", "D", "F", "G"]);
    await page.getByRole("switch", { name: "the enable input" }).click();
    await text(page, "#why-reasons", "the enable input is not active");
    await text(page, "#device", "status green: off");
    await page.getByRole("switch", { name: "the enable input" }).click();
    await text(page, "#device", "status green: on");
    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#device", "status green: off");
  });
});

test("which faults are provoked is what the drive says, also by hand", async () => {
  await onStage({ drives: ["--drive", "5,gear=24"], master: false }, async ({ page }) => {
    await setInput(page, "battery_volts", 2);
    const pressed = (code) => page.locator(`[data-fault=${code}][aria-pressed=true]`);
    await pressed("J").waitFor();
    await setInput(page, "friction_torque_newton_metres", 2.3);
    assert.equal(await pressed("C").count(), 0);
    await setInput(page, "friction_torque_newton_metres", 2.4);
    await pressed("C").waitFor();
    await page.getByRole("button", { name: "Set all to normal" }).click();
    await page.locator("[data-fault=C][aria-pressed=false]").waitFor();
    await page.locator("[data-fault=J][aria-pressed=false]").waitFor();
  });
});

test("ranges of inputs are those that the drive tells", async () => {
  await onStage({ master: false }, async ({ page }) => {
    const { inputs } = await page.evaluate(async () => (await fetch("/api/v1/stations/5")).json());
    const numbers = inputs.filter(({ low, may_be_null: free }) => low !== null && !free);
    assert.ok(numbers.length > 5, `${numbers.length} inputs are numbers`);
    for (const { input, low, high } of numbers) {
      await setInput(page, input, high + 1);
      await text(page, "#inputs .refused", `must be ${low} to ${high} `);
    }
  });
});

test("an LED blinks as often as the code of the fault says", async () => {
  await onStage({ master: false }, async ({ page }) => {
    const counted = await page.evaluate(async (codes) => {
      const { isLit } = await import("/page/device.js");
      return codes.map((blinks) => {
        const led = { glow: "blinking", blinks, on_milliseconds: 250, off_milliseconds: 250, pause_milliseconds: 1250, phase_milliseconds: 700 };
        const sequence = blinks * 500 + 1250;
        let rises = 0;
        for (let ms = 1; ms <= sequence; ms += 1) rises += Number(isLit(led, ms) && !isLit(led, ms - 1));
        return rises;
      });
    }, Object.values(BLINKS));
    assert.deepEqual(counted, Object.values(BLINKS));
  });
});

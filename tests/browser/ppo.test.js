// A drive of PROFIDRIVE version 2: its words, values, faults, parameter channel and parameters.
import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { PlainStation } from "./master.js";
import { onStage, setInput, text } from "./stage.js";

const TABLE = fileURLToPath(new URL("../../examples/ppo_drive.toml", import.meta.url));
const PICTURES = process.env.PROFIDRIVE_SCREENSHOTS;
const PPO_1 = { ident: 0x5044, cfg: [0xf3, 0xf1], outputLength: 12, inputLength: 12 };

/** The parameter channel, STW, setpoint. */
const outputs = (stw, setpoint, pkw = []) => Buffer.concat([Buffer.from([...pkw, ...Array(8 - pkw.length).fill(0)]), Buffer.from([stw >> 8, stw & 0xff, setpoint >> 8, setpoint & 0xff])]);

test("words, values, faults, the parameter channel and the table are shown, and a fault is raised", async () => {
  const station = new PlainStation(7, PPO_1);
  station.sent = outputs(0x047e, 0);
  await onStage({ drives: ["--ppo-drive", `7,parameters=${TABLE}`], addresses: [station], page: { view: "" } }, async ({ page, master }) => {
    await master.exchanging(7);
    await text(page, "#station-title", "Station 7");
    await text(page, "#station-state", "ready for switching on");
    await text(page, "#why-reasons", "OFF1: set STW bit 0 (ON)");
    station.sent = outputs(0x047f, 0x2000, [0x10, 0x02]);
    await text(page, "#station-state", "operation enabled");
    await text(page, "#station-about", "PPO 1");
    await text(page, "#why-title", "It moves");
    await page.locator("[data-value=setpoint]", { hasText: "50.0%" }).waitFor();
    await page.locator("#dialogue", { hasText: "PNU 2 ramp-up time, value 20" }).waitFor();
    await page.locator("#parameters tr", { hasText: "ramp-up time" }).getByText("20 (2)").waitFor();
    if (PICTURES) {
      await page.locator("#connection[data-kind=live]").waitFor();
      await page.screenshot({ path: path.join(PICTURES, "ppo-drive-light.png") });
    }
    await setInput(page, "fault_number", 77);
    await text(page, "#station-state", "fault");
    await text(page, "#faults tbody", "77not acknowledged (947)");
    await text(page, "#alarms", "7: 77");
    await page.locator("[data-word=zsw] [data-alarm=true]", { hasText: "fault" }).waitFor();
    station.sent = outputs(0x04fe, 0);
    await text(page, "#faults tbody", "77acknowledged");

    await page.setViewportSize({ width: 360, height: 740 });
    const { wide, room } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: document.documentElement.clientWidth }));
    assert.ok(wide <= room, `the page is ${wide} wide and has room for ${room}`);
    await page.getByRole("link", { name: "Stations", exact: true }).click();
    await text(page, ".tile", "PPO 1");
  });
});

// A drive of PROFIDRIVE version 2: its words, values, faults, parameter channel and parameters.
import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { PlainStation } from "./master.js";
import { onStage, text } from "./stage.js";

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
    await text(page, "#ppo-title", "Station 7: PPO 1");
    await text(page, "#ppo-state", "ready for switching on");
    await text(page, "#ppo-why", "OFF1: set STW bit 0 (ON)");
    station.sent = outputs(0x047f, 0x2000, [0x10, 0x02]);
    await text(page, "#ppo-state", "operation enabled");
    await text(page, "#ppo-why-title", "It turns");
    await page.locator("#ppo-values", { hasText: "50.0 %" }).waitFor();
    await page.locator("#ppo-pkw", { hasText: "PNU 2 ramp-up time, value 20" }).waitFor();
    await page.locator("#ppo-parameters tr", { hasText: "ramp-up time" }).getByText("20 (2)").waitFor();
    if (PICTURES) {
      await page.locator("#connection[data-kind=live]").waitFor();
      await page.screenshot({ path: path.join(PICTURES, "ppo-drive-light.png") });
    }
    await page.getByRole("button", { name: "Raise" }).click();
    await text(page, "#ppo-state", "fault");
    await page.locator("#ppo-values div", { hasText: "Faults (947)" }).getByText("77").waitFor();
    await page.locator("#ppo-zsw [data-alarm=true]", { hasText: "fault" }).waitFor();
    station.sent = outputs(0x04fe, 0);
    await page.locator("#ppo-values div", { hasText: "Acknowledged" }).getByText("77").waitFor();

    await page.setViewportSize({ width: 360, height: 740 });
    const { wide, room } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: document.documentElement.clientWidth }));
    assert.ok(wide <= room, `the page is ${wide} wide and has room for ${room}`);
    await page.getByRole("link", { name: "Stations", exact: true }).click();
    await text(page, "#ppo-tiles .tile", "PPO 1");
  });
});

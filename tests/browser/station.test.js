// A station from a GSD: modules as cards, forced inputs, outputs, the diagnosis.
import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { PlainStation } from "./master.js";
import { onStage, text, until } from "./stage.js";

const GSD = fileURLToPath(new URL("../gsd/remote_io.gsd", import.meta.url));
const PICTURES = process.env.PROFIDRIVE_SCREENSHOTS;
const MODULES = { ident: 0x0a08, cfg: [0x10, 0x20, 0x51, 0x61], outputLength: 5, inputLength: 5 };

const stage = (options) => ({ drives: ["--station", `7,gsd=${GSD}`], page: { view: "#station/7" }, ...options });
const card = (page, slot) => page.locator(`.module[data-process^="slot${slot} "]`);
const side = (page, slot, name) => page.locator(`.module[data-process="slot${slot} ${name.toLowerCase()}"]`);

test("outputs are seen, inputs are forced, and a diagnosis is raised in the texts of the GSD", async () => {
  const station = new PlainStation(7, MODULES);
  await onStage(stage({ addresses: [station] }), async ({ page, master }) => {
    await text(page, "#station-title", "Station 7");
    await master.exchanging(7);
    await text(page, "#station-state", "Data_Exchange");
    await text(page, "#station-about", "profidrive Remote I/O · DATA-EXCH · master 0");
    await text(page, "[data-value=ident] dd", "0x0A08");
    await text(page, "[data-value=watchdog] dd", "20000ms");
    assert.deepEqual(await page.locator(".module h4").allTextContents(), ["← Slot 1: 8 DI", "→ Slot 2: 8 DO", "← Slot 3: 2 AI", "→ Slot 4: 2 AO"]);

    station.sent = Buffer.from([0b1010_0101, 0x12, 0x34, 0xff, 0x38]);
    await card(page, 2).getByRole("img", { name: "Output 0.7" }).and(page.locator("[data-lit=true]")).waitFor();
    assert.equal(await card(page, 2).getByRole("img", { name: "Output 0.6" }).getAttribute("data-lit"), "false");
    await side(page, 4, "Outputs").getByLabel("as").selectOption("signed16");
    await side(page, 4, "Outputs").getByLabel("Octet").fill("2");
    await until("output", () => side(page, 4, "Outputs").locator(".value-of .mono").textContent(), (shown) => shown === "= -200 = FF38h = 11111111 00111000b");

    await card(page, 1).getByRole("switch", { name: "Input 0.3" }).click();
    await master.until(7, "the forced bit", ({ inputs }) => inputs[0] === 0b1000);
    await card(page, 1).locator("[data-forced=true]").waitFor();
    await side(page, 3, "Inputs").getByLabel("as").selectOption("signed16");
    await side(page, 3, "Inputs").getByLabel("Value", { exact: true }).fill("-2");
    await side(page, 3, "Inputs").getByRole("button", { name: "Force" }).click();
    await master.until(7, "the forced word", ({ inputs }) => inputs[1] === 0xff && inputs[2] === 0xfe);

    await page.getByLabel("Texts of the GSD").selectOption({ label: "1: no load supply" });
    await page.getByLabel("Number in the diagnosis").selectOption({ label: "from bit 4: hot" });
    await page.locator("#diagnosis").getByLabel(/^Slot/).selectOption("3");
    await page.getByLabel("module status").selectOption("invalid");
    await page.getByLabel("Channel error").selectOption({ label: "16: sensor broken" });
    await page.getByRole("button", { name: "Raise" }).click();
    await page.locator(".raised[data-count='4']").waitFor();
    assert.deepEqual(await page.locator(".raised li").allTextContents(), ["no load supply", "hot", "slot 3 '2 AI': data invalid", "slot 3 '2 AI', channel 0: sensor broken (16)"]);
    await text(page, "#diagnosis", "0A 08 02 22 05 82 00 00 10 82 40 30");
    if (PICTURES) {
      // A busy machine is no part of the picture.
      await page.locator("#connection[data-kind=live]").waitFor();
      await page.evaluate(() => document.activeElement.blur());
      await page.screenshot({ path: path.join(PICTURES, "station-light.png") });
    }
    await page.getByRole("button", { name: "End" }).click();
    await page.locator(".raised[data-count='0']").waitFor({ state: "attached" });

    await page.getByRole("button", { name: "Release all inputs" }).click();
    await master.until(7, "free inputs", ({ inputs }) => inputs.every((octet) => octet === 0));
    await page.setViewportSize({ width: 360, height: 740 });
    const { wide, room } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: document.documentElement.clientWidth }));
    assert.ok(wide <= room, `the page is ${wide} wide and has room for ${room}`);

    await page.getByRole("link", { name: "Stations", exact: true }).click();
    await text(page, ".tile", "Data_Exchange");
  });
});

test("a refused configuration is told with module, octet, expected and got", async () => {
  const station = new PlainStation(7, { ...MODULES, cfg: [0x10, 0x21] });
  await onStage(stage({ addresses: [station] }), async ({ page }) => {
    await text(page, "#why-refused", "Chk_Cfg octet 2: 0x21: slot 2: no module begins with this; expected '8 DI', '8 DO', '2 AI', '2 AO'");
    await text(page, "#station-state", "no master exchanges data");
  });
});

test("what cannot be forced is said, and an address without a station too", async () => {
  await onStage(stage({ master: false, refusals: true }), async ({ page }) => {
    const first = side(page, 1, "Inputs");
    await first.getByLabel("Value", { exact: true }).fill("300");
    await first.getByRole("button", { name: "Force" }).click();
    await text(page, "#station-problem", "300 does not fit, expected 0 to 255");
    await page.goto(page.url().replace("#station/7", "#station/9"));
    await text(page, "#why-title", "at address 9");
  });
});

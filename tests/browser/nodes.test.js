// The page of CANopen nodes: state, words, PDOs, dictionary, errors; display, keys and shaft of the AP10; panel of the ASDA-A2.
import assert from "node:assert/strict";
import { once } from "node:events";
import net from "node:net";
import { test } from "node:test";

import { CONNECTED, onStage, text, until } from "./stage.js";

const NODES = ["--node", "5", "--node", "6,device=ap10", "--node", "7,device=asda-a2"];

/** A master behind an slcan adapter that only sends. */
async function master(emulator) {
  const socket = net.connect(emulator.linkPort, "127.0.0.1");
  await once(socket, "connect");
  socket.resume();
  const send = (line) => socket.write(`${line}\r`);
  send("O");
  return { send, end: () => socket.destroy() };
}

test("nodes are listed with their state and what their display shows", async () => {
  await onStage({ drives: NODES, master: false, page: { view: "#stations" } }, async ({ page }) => {
    await text(page, "#stations-count", "3 stations");
    await text(page, ".tiles li:nth-child(2)", "AP10");
    await text(page, ".tiles li:nth-child(2)", "PRE-OPERATIONAL");
    await text(page, ".tiles li:nth-child(2) .position", "0  ---");
    await page.locator("#stations-filter").fill("asda");
    await page.locator(".tiles li").nth(0).locator("a").click();
    await text(page, "#station-title", "Station 7");
  });
});

test("an AG03/1 shows its words, PDOs and dictionary, why it does not move, and its faults", async () => {
  await onStage({ drives: NODES, master: false, page: { view: "#station/5" } }, async ({ page, emulator }) => {
    const bus = await master(emulator);
    await text(page, "#why-title", "It does not move, because");
    await text(page, "#why-reasons", "PRE-OPERATIONAL");
    bus.send("t00020105");
    await text(page, "#station-about", "· OPERATIONAL");
    bus.send("t60582B40600006000000");
    await text(page, "[data-word='6040'] .raw", "0006");
    await page.locator("[data-word='6041'] li[data-set=true]", { hasText: "ready to switch on" }).waitFor();
    await text(page, "#process", "TPDO1");
    await text(page, "#process", "6041h:00");
    // An entry is found, written and read back.
    await page.locator("#objects input[type=search]").fill("1017");
    const heartbeat = page.locator("#objects tr[data-key='1017:00']");
    await heartbeat.locator("button").click();
    await page.locator("#objects").getByLabel("Value", { exact: true }).fill("250");
    await page.getByRole("button", { name: "Write" }).click();
    await text(page, "#objects [role=status]", /1017h:00 .*: 250/);
    await text(page, "#objects tr[data-key='1017:00']", "250");

    await page.getByRole("button", { name: /^Provoke fault D:/ }).click();
    await text(page, "#station-state", "fault D");
    await text(page, "#faults table", "4310h");
    await page.locator("#faults [data-fault=D][aria-pressed=true]").waitFor();
    await text(page, "#device .leds", "status green: 4 blinks: fault D");
    await page.getByRole("button", { name: "Set all to normal" }).click();
    await page.locator("#faults [data-fault=D][aria-pressed=false]").waitFor();
    await page.locator("#log-lines li[data-kind=fault]", { hasText: "EMCY 4310h" }).waitFor();

    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#station-state", "switched off");
    await page.getByRole("button", { name: "Power on" }).click();
    await text(page, "#station-about", "PRE-OPERATIONAL");
    bus.end();
  });
});

test("the display, the keys and the shaft of an AP10", async () => {
  await onStage({ drives: NODES, master: false, page: { view: "#station/6" } }, async ({ page }) => {
    assert.equal(await page.locator("#why").isVisible(), false, "it cannot move, and has no reason not to");
    await text(page, "#device .lcd p:nth-child(2)", "---");
    const shaft = page.locator("#inputs [data-input=shaft_revolutions]");
    for (const step of [": 1", ": 1", ": -0.1"]) await shaft.getByRole("button", { name: step, exact: false }).last().click();
    await shaft.locator("input[type=text]").fill("2.5");
    await shaft.locator("input[type=text]").press("Enter");
    await text(page, "#device .lcd p:nth-child(1)", "2200");
    await page.locator("#device [data-key=up]").click();
    await text(page, "#device .lcd p:nth-child(1)", "0");
    const star = page.locator("#device [data-key=star]");
    await star.hover();
    await page.mouse.down();
    await page.locator("#device [data-key=star][aria-pressed=true]").waitFor();
    await text(page, "#device .lcd p:nth-child(1)", "ID 6");
    await page.mouse.up();
    await page.getByRole("button", { name: /^Provoke fault battery-empty:/ }).click();
    await text(page, "#device .signs", "battery empty");
    await text(page, "#faults table", "3200h");
    await page.locator(CONNECTED).waitFor();
  });
});

test("the five-digit panel of an ASDA-A2, its alarm and the blocked shaft", async () => {
  await onStage({ drives: NODES, master: false, page: { view: "#station/7" } }, async ({ page }) => {
    await page.getByRole("button", { name: /^Provoke fault 011:/ }).click();
    await text(page, "#device .lcd", "AL011");
    await text(page, "#why-reasons", "alarm AL011: encoder error");
    await text(page, "#faults table", "7305h");
    await page.reload();
    await text(page, "#log-lines", "7305h");
    await page.getByRole("switch", { name: "the shaft cannot turn" }).click();
    await text(page, "#why-reasons", "the shaft is blocked");
    await page.getByRole("button", { name: "Set all to normal" }).click();
    await page.locator("#inputs [data-input=blocked] [aria-checked=false]").waitFor();
  });
});

test("the keys of an ASDA-A2 walk through its parameters, and what SET writes is in the dictionary", async () => {
  await onStage({ drives: NODES, master: false, page: { view: "#station/7" } }, async ({ page }) => {
    const lcd = "#device .lcd p";
    await text(page, lcd, /^ *0$/);
    const press = async (keys, shown) => {
      for (const key of keys.split(" ")) await page.locator(`#device [data-key=${key}]`).click();
      await text(page, lcd, shown);
    };
    await press("mode", /^P0-00$/);
    await press("shift shift shift", /^P3-00$/);
    await press("up", /^P3-01$/);
    await press("down set", /^ 0007$/);
    await press("up shift up", /^ 0018$/);
    await text(page, "#device .signs", "digit 2");
    await press("set", /^SAVEd|P3-00$/);
    await text(page, lcd, /^P3-00$/);
    await text(page, "#objects tr[data-key='2300:00']", "24");
    await press("set shift shift up set", /^Out-r|P3-00$/);
    await page.locator("#device [data-key=mode]").focus();
    await page.keyboard.press("Enter");
    await text(page, lcd, /^ *0$/);
  });
});

test("the bus has its counters, faults on purpose, and nodes that come and go", async () => {
  await onStage({ drives: NODES, master: false, refusals: true, page: { view: "#bus" } }, async ({ page }) => {
    await text(page, "#counters", "500 kbit/s");
    await text(page, "#counters", "error active");
    await page.getByLabel("Fault", { exact: true }).fill("sdo-lost");
    await page.getByLabel("When and where").fill("node=6,count=3");
    await page.locator("#line-faults button[type=submit]").click();
    await text(page, "#line-faults li", "sdo-lost,count=3,node=6");
    await text(page, "#line-faults li", "injected 0 times");
    await page.getByRole("button", { name: "Remove all" }).click();
    await text(page, "#line-faults", "None.");

    await page.locator("#devices input").fill("9");
    await page.locator("#devices select").selectOption("ap10");
    await page.locator("#devices button[type=submit]").click();
    await text(page, "#counters", "9");
    await page.locator("#to-stations").click();
    await text(page, "#stations-count", "4 stations");
    await page.locator("#to-bus").click();
    await page.locator("#devices input").fill("5");
    await page.locator("#devices button[type=submit]").click();
    await text(page, "#bus [role=alert]", "the number 5 is taken");
  });
});

test("frames are told with their service and their node, and a node shows its own", async () => {
  await onStage({ drives: NODES, master: false, page: { view: "#station/6" } }, async ({ page, emulator }) => {
    const bus = await master(emulator);
    await page.getByRole("button", { name: "Record telegrams" }).click();
    const shown = page.locator("#telegram-lines .log li");
    await until("a recording", async () => {
      bus.send("t60684017100000000000");
      return shown.count();
    }, (count) => count >= 2);
    for (let times = 0; times < 5; times += 1) bus.send("t60584017100000000000");
    await page.locator("#telegram-lines input[type=search]").fill("SDO 0x1017");
    await shown.first().waitFor();
    const texts = await shown.allTextContents();
    assert.ok(texts.every((line) => /SDO (to|from) 6: .*1017h:00/.test(line)), texts.join("\n"));
    assert.ok(texts.some((line) => line.includes("SDO from 6")));
    bus.end();
  });
});

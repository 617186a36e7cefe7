// One cursor for curves, events and telegrams; what lies between two times; a report for a colleague; settings in a file;
// scenarios that are recorded, played and exported.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdtemp, readFile, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";
import { promisify } from "node:util";

import { Emulator } from "./emulator.js";
import { onStage, text, until } from "./stage.js";

/** The file that a button of the page saves. */
async function saved(page, name) {
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name, exact: true }).click();
  const file = await download;
  return { name: file.suggestedFilename(), text: (await readFile(await file.path())).toString() };
}

test("an event shows the curves and the telegrams of its time, and a time in the curves its events", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await master.enable(5);
    // A short one: the list holds 1000 telegrams, and a quick master sends them in two seconds.
    await master.travel(5, 60);
    await page.locator("#log-lines li", { hasText: "travel to 60 inc started" }).waitFor();
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await master.until(5, "the target", ({ hiw }) => hiw === 60);
    const started = page.locator("#log-lines li", { hasText: "travel to 60 inc started" });
    const time = Number(await started.getAttribute("data-time"));
    await started.click();
    assert.equal(await started.getAttribute("aria-current"), "true");
    const telegram = page.locator("#telegram-lines li[aria-current=true]");
    await telegram.waitFor();
    const before = Number(await telegram.getAttribute("data-time"));
    assert.ok(before <= time && time - before < 0.5, `${before} is what came before ${time}`);
    await page.locator("#curves [aria-pressed=false]", { hasText: "Follow" }).waitFor();

    // With the keyboard: one event further.
    await page.locator("#log-lines .log").focus();
    await page.keyboard.press("ArrowUp");
    await page.locator("#log-lines li[aria-current=true]").waitFor();
    assert.notEqual(await started.getAttribute("aria-current"), "true");

    const canvas = page.locator("canvas.curves");
    await canvas.scrollIntoViewIfNeeded();
    const box = await canvas.boundingBox();
    await page.mouse.click(box.x + box.width * 0.4, box.y + 60);
    await page.mouse.move(box.x + box.width * 0.8, box.y + 60);
    await page.keyboard.down("Shift");
    await page.mouse.click(box.x + box.width * 0.8, box.y + 60);
    await page.keyboard.up("Shift");
    await text(page, "#curves .readout", /Δ\s\d+\.\d{3}\ss/);
    await text(page, "#curves .readout", /Position\s-?\d+\sinc/);
    await canvas.focus();
    await page.keyboard.press("Escape");
    await until("the readout", () => page.locator("#curves .readout").textContent(), (now) => !now.includes("Δ"));
    assert.equal(await page.locator("#log-lines li[aria-current=true]").count(), 0);

    await page.keyboard.press("Home");
    await page.getByRole("button", { name: "Mark", exact: true }).click();
    await text(page, "#log-lines .log", "mark 1");
    await text(page, ".happened", "mark 1");
  });
});

test("a trigger stops the curves around the time at which a value passes a level, or an event comes", async () => {
  await onStage({ server: await Emulator.try(), master: false }, async ({ page }) => {
    await text(page, "#master-about", "Master 1 has this station");
    const curves = page.locator("#curves");
    const follow = page.getByRole("button", { name: "Follow" });
    await page.locator("#master [data-act=enable]").click();
    await text(page, "#master-doing", /^enable: done/);
    await curves.locator(".trigger label select").selectOption("rises");
    await curves.getByLabel("Value of the trigger").selectOption("position");
    await curves.getByLabel("Level of the trigger").fill("1,5");
    await text(page, "#curves .trigger", "'1,5' is no number");
    await curves.getByLabel("Level of the trigger").fill("40");
    await text(page, "#curves .trigger", "armed");
    await page.locator("#master .act:has([data-act=move]) input").fill("90");
    await page.locator("#master [data-act=move]").click();
    await text(page, "#curves .trigger", /triggered at \d+\.\d{3} s: Position, inc: \d+/);
    await until("the curves", () => follow.getAttribute("aria-pressed"), (pressed) => pressed === "false");
    const shown = Number(/Position, inc: (\d+)/.exec(await curves.locator(".trigger").textContent())[1]);
    assert.ok(shown > 40 && shown <= 90, `${shown} is the first beyond 40`);
    await text(page, "#curves .readout", /[4-9]\d\sinc/);

    await curves.locator(".trigger label select").selectOption("event");
    await text(page, "#curves .trigger", "Which words?");
    await curves.getByLabel("Words of the event").fill("fault D");
    await text(page, "#curves .trigger", "armed");
    assert.equal(await follow.getAttribute("aria-pressed"), "true", "they run until then");
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#curves .trigger", /triggered at .*fault D/);
    await until("the curves", () => follow.getAttribute("aria-pressed"), (pressed) => pressed === "false");
    assert.match(await page.locator("#log-lines li[aria-current=true]").textContent(), /fault/);
    await curves.getByRole("button", { name: "Arm again" }).click();
    await text(page, "#curves .trigger", "armed");
  });
});

test("a trigger ends the recording of telegrams a little later", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.locator("#curves .trigger label select").selectOption("event");
    await page.getByLabel("Words of the event").fill("operation enabled");
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await text(page, "#telegram-lines .log", "Data_Exchange");
    await master.enable(5);
    await text(page, "#telegrams .ended", /ended by the trigger at .*operation enabled/);
    await page.getByRole("button", { name: "Record telegrams", pressed: false }).waitFor();
  });
});

test("a report opens without the emulator, with curves, events, telegrams and both files inside", async () => {
  await onStage({}, async ({ page, master }) => {
    await master.exchanging(5);
    await page.getByRole("button", { name: "Record telegrams" }).click();
    await master.enable(5);
    await master.travel(5, 300);
    await master.until(5, "the target", ({ hiw }) => hiw === 300);
    await text(page, "#log-lines .log", "travel to 300 inc started");
    await text(page, "#telegram-lines .log", "Data_Exchange");
    const report = await saved(page, "Save as report");
    assert.equal(report.name, "station-5.html");
    const folder = await mkdtemp(path.join(tmpdir(), "report-"));
    const file = path.join(folder, report.name);
    await writeFile(file, report.text);
    const offline = await page.context().browser().newContext({ offline: true });
    const reader = await offline.newPage();
    await reader.goto(`file://${file}`);
    assert.match(await reader.locator("h1").textContent(), /Station line\/5/);
    assert.ok((await reader.locator("svg polyline").count()) >= 3);
    await reader.locator("td", { hasText: "travel to 300 inc started" }).first().waitFor();
    assert.ok((await reader.locator("table").nth(1).locator("tbody tr").count()) > 5);
    const files = await reader.locator("a[download]").evaluateAll((links) => links.map(({ download, href }) => [download, href.slice(0, 5), href.length]));
    assert.deepEqual(files.map(([name, begin]) => [name, begin]), [["station-5.csv", "data:"], ["line.pcapng", "data:"]]);
    assert.ok(files.every(([, , length]) => length > 150), JSON.stringify(files));
    await offline.close();
  });
});

test("entries are found by name, number and value, changes are marked, and settings go to a file and back", async () => {
  await onStage({ drives: ["--node", "7,device=asda-a2"], master: false, page: { view: "#station/7" } }, async ({ page }) => {
    const rows = page.locator("#objects tbody tr");
    const filter = page.locator("#objects").getByLabel("Filter");
    await text(page, "#objects .table", "6041h:00");
    for (const [typed, found] of [["0x6041", "6041h:00"], ["6041h", "6041h:00"], ["statusword", "6041h:00"], ["producer heartbeat", "1017h:00"]]) {
      await filter.fill(typed);
      await text(page, "#objects tbody", found);
      assert.ok((await rows.count()) < 12, typed);
    }
    await filter.fill("1017");
    const form = page.locator("#objects form");
    await form.getByLabel("Number").fill("1017h:00");
    await form.getByLabel("Value").fill("0x1F4");
    await form.getByRole("button", { name: "Write" }).click();
    const row = page.locator("#objects tr[data-key='1017:00'][data-other=true]");
    await row.waitFor();
    await text(page, "#objects tr[data-key='1017:00']", "50001F4h");
    // Live: what another program writes is seen at once.
    const begun = Date.now();
    await page.evaluate(() => fetch("/api/v1/stations/7/objects/1017/0", { method: "PUT", headers: { "content-type": "application/json" }, body: '{"value": 700}' }));
    await page.locator("#objects").scrollIntoViewIfNeeded();
    await text(page, "#objects tr[data-key='1017:00']", "70002BCh");
    assert.ok(Date.now() - begun < 1500);
    const file = await saved(page, "Save settings");
    assert.equal(JSON.parse(file.text).settings.find(({ key }) => key === "1017:00").value, 700);

    await form.getByLabel("Value").fill("0");
    await form.getByRole("button", { name: "Write" }).click();
    await text(page, "#objects tr[data-key='1017:00']", "00000h");
    const folder = await mkdtemp(path.join(tmpdir(), "settings-"));
    await writeFile(path.join(folder, "settings.json"), file.text);
    // Compared, nothing is written.
    const chooses = page.waitForEvent("filechooser");
    await page.locator("#objects").getByRole("button", { name: "Compare with file" }).click();
    await (await chooses).setFiles(path.join(folder, "settings.json"));
    await text(page, "#objects [role=status]", "1 value other than in the file. Nothing is written.");
    await text(page, "#objects tr[data-key='1017:00']", "in the file 700");
    assert.equal(await rows.count(), 1);
    const loads = page.waitForEvent("filechooser");
    await page.locator("#objects").getByRole("button", { name: "Load settings" }).click();
    await (await loads).setFiles(path.join(folder, "settings.json"));
    await text(page, "#objects [role=status]", "1 value written, 0 values refused");
    await page.locator("#objects").getByLabel("Show").selectOption("all");
    await text(page, "#objects tr[data-key='1017:00']", "700");
    await writeFile(path.join(folder, "other.json"), "{}");
    await page.locator("#objects input[type=file]").setInputFiles(path.join(folder, "other.json"));
    await text(page, "#objects [role=status]", "has no objects that this page has saved");
  });
});

test("what is clicked is recorded, played again, and saved for pytest and as a line file", async () => {
  await onStage({ server: await Emulator.try(), master: false }, async ({ page, emulator }) => {
    await text(page, "#master-about", "Master 1 has this station");
    const scenario = page.locator("#scenario");
    await scenario.getByRole("button", { name: "Record", exact: true }).click();
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#station-state", "fault D");
    await page.getByRole("button", { name: "Set all to normal" }).click();
    await page.locator("#master [data-act=acknowledge]").click();
    await text(page, "#master-doing", "acknowledge: done");
    await page.evaluate(() => (location.hash = "#bus"));
    await page.getByLabel("Fault", { exact: true }).fill("late=1ms,station=5");
    await page.locator("#line-faults").getByRole("button", { name: "Add" }).click();
    await page.getByRole("button", { name: "Remove late=1ms,station=5" }).click();
    await until("steps", () => page.locator("#scenario li").count(), (count) => count === 5);
    await scenario.getByRole("button", { name: "Stop", exact: true }).click();

    const faults = async () => (await (await fetch(new URL("api/v1/events/recent", emulator.panel))).json()).events.filter(({ text }) => text.includes("fault D")).length;
    const before = await faults();
    await scenario.getByRole("button", { name: "Play" }).click();
    await until("the fault", faults, (count) => count > before);
    await scenario.getByRole("button", { name: "Play", exact: true }).waitFor();
    await text(page, "#scenario [role=status]", "5 steps");

    const line = await saved(page, "Save line file");
    assert.match(line.text, /\[\[line\.fault\]\]\nfault = "late=1ms,station=5"\nfrom = "\d+ms"\nuntil = "\d+ms"/);
    const python = await saved(page, "Save for pytest");
    const folder = await mkdtemp(path.join(tmpdir(), "scenario-"));
    await writeFile(path.join(folder, python.name), python.text);
    const again = await faults();
    const script = "import test_scenario; test_scenario.test_scenario()";
    await promisify(execFile)("python3", ["-c", script], { cwd: folder, env: { ...process.env, PROFIDRIVE_PANEL: emulator.panel.replace(/\/$/, "") } });
    assert.ok((await faults()) > again, "the script has provoked it");
  });
});

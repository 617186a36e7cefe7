// Records and alarms of a station of DP-V1, and what keeps a master from them.
import assert from "node:assert/strict";
import { mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { test } from "node:test";

import { PlainStation } from "./master.js";
import { onStage, text, until } from "./stage.js";

const GSD = `#Profibus_DP
GSD_Revision=3
Vendor_Name="profidrive"
Model_Name="Records"
Ident_Number=0x1234
9.6_supp=1
500_supp=1
DPV1_Slave=1
Max_Diag_Data_Len=60
Max_User_Prm_Data_Len=30
Ext_User_Prm_Data_Const(0)=0x00,0x00,0x00
C1_Read_Write_supp=1
C1_Max_Data_Len=240
C2_Read_Write_supp=1
C2_Max_Count_Channels=2
OrderNumber="ABC-1"
Ident_Maintenance_supp=1
Process_Alarm_supp=1
Diagnostic_Alarm_supp=1
Module="io" 0x31
EndModule
`;
const RECORDS = `[[record]]
slot = 1
index = 10
data = "41 42 00 44"
[[record]]
slot = 1
index = 11
length = 2
access = "r"
`;
const STATION = { ident: 0x1234, cfg: [0x31], outputLength: 2, inputLength: 2 };

/** A station at address 7, and what its master knows of it: with DP-V1 enabled or not. */
async function stage(enabled) {
  const folder = await mkdtemp(path.join(tmpdir(), "records-"));
  const [gsd, records] = [path.join(folder, "v1.gsd"), path.join(folder, "records.toml")];
  await writeFile(gsd, GSD);
  await writeFile(records, RECORDS);
  const station = new PlainStation(7, { ...STATION, prm: [enabled ? 0x80 : 0, 0x60, 0] });
  return { drives: ["--station", `7,gsd=${gsd},records=${records}`], addresses: [station], page: { view: "#station/7" } };
}

test("records are seen and changed, alarms are raised and wait for the master", async () => {
  await onStage({ ...(await stage(true)), refusals: true }, async ({ page, master }) => {
    await master.exchanging(7);
    const records = page.locator("#records");
    await text(page, "#channels", "the owner, master 0, can read and write; none of 2 connections is open");
    const rows = () => records.locator("table").first().locator("tr").allTextContents();
    assert.equal((await rows()).length, 3, JSON.stringify(await rows()));
    assert.match((await rows())[1], /1 \/ 10.*4.*read and write.*41 42 00 44.*AB\.D/);
    await text(page, "#records", "order ABC-1");

    await records.getByRole("button", { name: "Choose record 10 of slot 1" }).click();
    await records.getByLabel("contents").fill("AA BB CC DD");
    await records.getByRole("button", { name: "Change" }).click();
    await text(page, "#records-answer", "contents: AA BB CC DD");
    await until("the change", rows, (all) => all[1].includes("AA BB CC DD"));
    await records.getByLabel("contents").fill("AA");
    await records.getByRole("button", { name: "Change" }).click();
    await text(page, "#records-answer", "1 octets, expected 4");

    const form = records.locator("form").nth(1);
    await form.locator("select").first().selectOption("2");
    await form.locator("input[type=number]").fill("1");
    await form.locator("select").nth(1).selectOption("appears");
    await records.getByRole("button", { name: "Raise alarm" }).click();
    await text(page, "#records-answer", "raised: process alarm of slot 1 appears, number 0");
    await text(page, "#why-title", "Services of DP-V1");
    // This master reads its diagnosis and acknowledges nothing.
    await text(page, "#why-reasons", /process alarm of slot 1 appears, number 0 waits (for its acknowledgement|until the owner reads)/);
    await records.getByRole("button", { name: "Forget all" }).click();
    await text(page, "#records-answer", "no alarm waits any more");
    await page.locator("#records[data-alarms='0']").waitFor();

    await page.setViewportSize({ width: 360, height: 740 });
    const { wide, room } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: document.documentElement.clientWidth }));
    assert.ok(wide <= room, `the page is ${wide} wide and has room for ${room}`);
  });
});

test("why MS1 is closed is said where DP-V1 is not enabled", async () => {
  await onStage(await stage(false), async ({ page, master }) => {
    await master.exchanging(7);
    await text(page, "#why-title", "Services of DP-V1");
    await text(page, "#why-reasons", "DPV1_Enable in octet 8 of Set_Prm is 0");
    await text(page, "#channels", "MS1 is closed; none of 2 connections is open");
  });
});

test("a drive of PROFIdrive has channels and no records that could be changed", async () => {
  await onStage({ drives: ["--profidrive", "7,telegram=1"], master: false, page: { view: "#station/7" } }, async ({ page }) => {
    await text(page, "#channels", "MS1 is closed");
    await text(page, "#why-reasons", "MS1 (SAP 51) is closed, the slave waits for Set_Prm");
    const records = page.locator("#records");
    assert.equal(await records.getByRole("button", { name: "Change" }).count(), 0);
    assert.equal(await records.getByRole("button", { name: "Raise alarm" }).count(), 0);
    await text(page, "#records", "I&M0");
  });
});

// The connection to the server: lost and found again, samples lost on the way, and what the page is allowed to do.
import assert from "node:assert/strict";
import { test } from "node:test";

import { CONNECTED, LIMIT_MS, onStage, text, until } from "./stage.js";

test("a server that goes is missed, and found again when it is back", async () => {
  await onStage({ master: false, refusals: true }, async (stage) => {
    const { page } = stage;
    await text(page, "#station-state", "ready-to-run");
    stage.emulator = await stage.emulator.restart(async () => {
      await page.locator("#connection[data-kind=lost]").waitFor();
      await text(page, "#connection", "the emulator does not answer");
    });
    await page.locator(CONNECTED).waitFor();
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#station-state", "fault D");
  });
});

test("a server that is frozen is missed at once, its values look old, and it is found again when it goes on", async () => {
  await onStage({ master: false, refusals: true }, async ({ page, emulator }) => {
    await text(page, "#station-state", "ready-to-run");
    const dimmed = () => page.locator("#values").evaluate((values) => Number(getComputedStyle(values.closest("main > section")).opacity));
    assert.equal(await dimmed(), 1);
    emulator.freeze();
    await page.locator("#connection[data-kind=lost]").waitFor({ timeout: 15_000 });
    await text(page, "#connection", "not connected: the emulator does not answer. The values are old");
    assert.ok((await dimmed()) < 0.6, "values of before look so");
    // Longer than every limit of the page: nothing that it asks meanwhile makes it live again.
    const live = page.locator(CONNECTED).waitFor({ timeout: 7_000 }).then(() => "live", () => "gone");
    assert.equal(await live, "gone");
    const refused = await page.evaluate(async () => {
      const { request } = await import("/page/api.js");
      return request("GET", "/lines/line").catch(({ message }) => message);
    });
    assert.equal(refused, "the emulator does not answer");
    emulator.thaw();
    await page.locator(CONNECTED).waitFor();
    assert.equal(await dimmed(), 1);
    await page.getByRole("button", { name: "Provoke fault D:" }).click();
    await text(page, "#station-state", "fault D");
  });
});

test("a drive that is taken away is said to be gone, and is there again when it is back", async () => {
  await onStage({ drives: ["--drives", "5-6"], master: false, refusals: true }, async ({ page }) => {
    const act = (method, path, body) => page.evaluate(([method, path, body]) => fetch(path, { method, headers: { "content-type": "application/json" }, body }).then(({ status }) => status), [method, path, body]);
    assert.equal(await act("DELETE", "/api/v1/stations/5"), 204);
    await text(page, "#why-title", "there is no station at address 5");
    for (const part of ["#values", "#device", "#curves", "#inputs", "#words"]) assert.ok(!(await page.locator(part).isVisible()), `nothing in ${part} is of a drive that is gone`);
    assert.equal(await act("POST", "/api/v1/stations", JSON.stringify({ address: 5, device: "ag03-1" })), 201);
    await page.locator(CONNECTED).waitFor();
    await text(page, "#station-state", "ready-to-run");
  });
});

test("at an address without a drive nothing of another drive is shown", async () => {
  await onStage({ drives: ["--drives", "5-6"], master: false, refusals: true, page: { view: "#station/6" } }, async ({ page }) => {
    await text(page, "#station-about", "AG03/1");
    for (const [address, said] of [[77, "there is no station at address 77"], [999, "'999' is no address"]]) {
      await page.evaluate((address) => (location.hash = `#station/${address}`), address);
      await text(page, "#station-title", `Station ${address}`);
      await text(page, "#why-title", said);
      await text(page, "#station-state", "not present");
      await text(page, "#station-about", /^$/);
      assert.ok(!(await page.locator("#values").isVisible()));
      assert.ok(!(await page.locator("#device").isVisible()));
    }
    await page.locator("#choose").selectOption("#station/line/6");
    await text(page, "#station-state", "ready-to-run");
    assert.ok(await page.locator("#values").isVisible());
  });
});

test("a page that finds every place of the stream taken asks once a second, and gets the next place that is free", async () => {
  await onStage({ master: false, refusals: true }, async ({ page, emulator }) => {
    await page.goto("about:blank");
    const events = new URL("api/v1/events", emulator.panel);
    const readers = [];
    await until("no place left", async () => {
      const reader = new AbortController();
      const { ok, body } = await fetch(events, { signal: reader.signal });
      if (ok) {
        readers.push(reader);
        // One that does not read would lose its place after ten seconds.
        body.pipeTo(new WritableStream()).catch(() => {});
      }
      return !ok;
    }, (full) => full);
    await page.goto(new URL("#station/5", emulator.panel).href);
    await text(page, "#connection", "live, once a second");
    await text(page, "#why-title", "It does not move");
    await page.getByRole("button", { name: "Power off" }).click();
    await text(page, "#station-state", "switched off");
    await page.getByRole("button", { name: "Power on" }).click();
    for (const reader of readers) reader.abort();
    await page.locator("#connection[data-kind=live]").waitFor();
    await text(page, "#why-title", "It does not move");
  });
});

test("what a slow reader has lost is counted in plain sight", async () => {
  await onStage({ master: false }, async ({ page }) => {
    const told = 'event: lost\ndata: {"states":3,"news":1,"telegrams":250}\n\n';
    await page.route("**/api/v1/events?*", (route) => route.fulfill({ contentType: "text/event-stream", body: told }), { times: 1 });
    await page.reload();
    await text(page, "#connection", "3 samples, 1 event, 250 telegrams lost");
    // And not for ever: later it would be taken for a trouble that goes on.
    await page.locator("#connection[data-kind=live]").waitFor();
    await text(page, "#connection", /^live$/);
  });
});

test("the page is allowed nothing but itself, and needs nothing more", async () => {
  await onStage({ master: false }, async ({ page, emulator }) => {
    const response = await page.goto(emulator.panel, { timeout: LIMIT_MS });
    const policy = response.headers()["content-security-policy"];
    assert.match(policy, /default-src 'none'/);
    assert.doesNotMatch(policy, /unsafe|\*|http/);
    // What data says is never markup: a name that looks like it stays text.
    const injected = await page.evaluate(async () => {
      const { html } = await import("/page/dom.js");
      const element = html("p", { title: "<b>" }, "<img src=x>");
      return [element.childElementCount, element.textContent];
    });
    assert.deepEqual(injected, [0, "<img src=x>"]);
  });
});

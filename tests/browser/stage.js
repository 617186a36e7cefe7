// What a test of the panel needs: an emulator, a master beside it, and a page in headless Chromium.
import { chromium } from "playwright-core";
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { mkdir } from "node:fs/promises";
import { basename, join } from "node:path";
import { after } from "node:test";

import { Emulator } from "./emulator.js";
import { Master } from "./master.js";

const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];
/** A folder with the files of the page, for those who edit them: they are taken from there and not from the program. */
const PAGE = process.env.PROFIDRIVE_PAGE;
/** Generous: a loaded machine is no failure. */
export const LIMIT_MS = Number(process.env.LIMIT_MS ?? 60_000);
/** On a loaded machine the page may lose samples; it is connected all the same. */
export const CONNECTED = "#connection:is([data-kind=live], [data-kind=lossy])";
const DESKTOP = { width: 1360, height: 900 };

/** One browser for the tests of a file; each has pages of its own. */
let browser = null;
after(() => browser?.close());

/**
 * Runs `play` with a stage: an emulator of `drives`, a master for those at `addresses` (`master: false`: none), a page.
 * The stage is taken down whatever happens. `refusals` says that the server is meant to refuse something, which a
 * browser takes for an error. `server` is another one than the program.
 */
export async function onStage({ drives = ["--drive", "5"], addresses = [5], master = true, refusals = false, server = null, page = {} }, play) {
  const stage = new Stage();
  try {
    stage.emulator = server ?? (await Emulator.start(...drives));
    if (master) stage.master = await Master.connect(stage.emulator.linkPort, addresses);
    browser ??= await chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
    stage.page = await stage.open(page);
    await play(stage);
    const complaints = stage.complaints.filter((complaint) => !refusals || !complaint.startsWith("Failed to load resource"));
    assert.deepEqual(complaints, [], "the browser has nothing to complain of");
    assert.deepEqual(stage.strangers, [], "nothing is fetched from elsewhere");
  } catch (error) {
    await stage.photograph();
    throw error;
  } finally {
    await stage.close();
  }
}

class Stage {
  complaints = [];
  strangers = [];

  /** A page on the panel, at a view such as `#station/5`. */
  async open({ view = "#station/5", viewport = DESKTOP, ...options }) {
    this.context = await browser.newContext({ viewport, ...options });
    return this.another(view);
  }

  /** Another tab of the same browser. */
  async another(view) {
    const page = await this.context.newPage();
    page.setDefaultTimeout(LIMIT_MS);
    page.on("pageerror", (error) => this.complaints.push(`${error.name}: ${error.message}`));
    page.on("console", (message) => message.type() === "error" && this.complaints.push(message.text()));
    page.on("request", (request) => {
      if (!request.url().startsWith(this.emulator.panel.replace(/\/$/, ""))) this.strangers.push(request.url());
    });
    if (PAGE) await page.route("**/*", (route) => fromFolder(route));
    await page.goto(new URL(view, this.emulator.panel).href);
    await page.locator(CONNECTED).waitFor();
    return page;
  }

  /** What went wrong is easier seen than told. */
  async photograph() {
    if (!this.page) return;
    const folder = new URL("./failed/", import.meta.url);
    await mkdir(folder, { recursive: true });
    const name = `${process.pid}-${Date.now()}.png`;
    await this.page.screenshot({ path: new URL(name, folder).pathname, fullPage: true }).catch(() => {});
  }

  async close() {
    await this.context?.close();
    await this.master?.close();
    await this.emulator?.stop();
  }
}

/** A file of the page from the folder; what is no file of the page is asked of the program. */
function fromFolder(route) {
  const { pathname } = new URL(route.request().url());
  const path = join(PAGE, pathname === "/" ? "index.html" : basename(pathname));
  const isFile = pathname === "/" || pathname.startsWith("/page/");
  return isFile && existsSync(path) ? route.fulfill({ path }) : route.fallback();
}

/** Waits until an element has a text. */
export async function text(page, selector, expected) {
  const locator = page.locator(selector);
  const test = expected instanceof RegExp ? expected : new RegExp(expected.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  try {
    await page.waitForFunction(
      ([selector, source]) => new RegExp(source).test(document.querySelector(selector)?.textContent ?? ""),
      [selector, test.source],
    );
  } catch {
    assert.match(await locator.textContent(), test, selector);
  }
}

/** Waits until `read` gives something that `test` likes. */
export async function until(what, read, test) {
  const end = Date.now() + LIMIT_MS;
  for (;;) {
    const value = await read();
    if (test(value)) return value;
    if (Date.now() > end) assert.fail(`${what}: still ${JSON.stringify(value)}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** The number a value of the strip shows. */
export async function value(page, name) {
  const shown = await page.locator(`[data-value="${name}"] dd span:first-child`).textContent();
  return Number(shown);
}

/** Sets a quantity that acts on the drive. */
export async function setInput(page, field, amount) {
  const number = page.locator(`[data-input="${field}"] input[type=text]`);
  await number.fill(String(amount));
  await number.press("Enter");
}

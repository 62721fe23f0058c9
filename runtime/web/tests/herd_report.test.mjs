// Tests of the report of `pelage herd`, opened as a local file, with data that try to break it.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before } from "node:test";
import { inBrowser, ROOT } from "./needs.mjs";
import { found, launch } from "./browser.mjs";

/** A JPEG of one grey pixel, used as a thumbnail. */
const GREY =
  `data:image/jpeg;base64,/9j/4AAQSkZJRgABAQEASABIAAD/2wBDAP${"/".repeat(86)}` +
  "wAALCAABAAEBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAAA//EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8AN//Z";
/** Scripts in the data, which must not run. */
const ODD = `</script><script>window.broken = 1</script><img src=x onerror="window.broken = 1">`;

function row(name, state, more = {}) {
  const picture = (folder) => ({ src: GREY, file: `${folder}/${name}.front.png` });
  const { flip = 0.02, bytes = 1000, failures = [], warnings = [] } = more;
  return {
    name, variant: null, model: `${name}.glb`, recipe: more.recipe ?? null, state, failures, warnings,
    package: state === "failed" ? null : {
      file: `packages/${name}.pelage`, bytes, gpu_bytes: 2 * bytes, triangles: 10, layers: 16, seconds: 1.5,
      peak_bytes: 1e8,
    },
    views: [{
      view: "front",
      picture: state === "failed" ? null : picture("pictures"), truth: state === "failed" ? null : picture("truths"),
      difference: null, flip: state === "failed" ? null : flip, limit: 0.05, milliseconds: null, truth_seconds: 2,
    }],
    levels: [{ what: "every layer", full_px: 17.25, gone_px: 8.6, fins: 1 }],
  };
}

const DATA = {
  title: `Herd ${ODD}`, tool: "pelage", adapter: null, views: ["front"],
  tasks: { done: 20, failed: 1, differ: 1, missing: 2 },
  rows: [
    row("fox", "done", { flip: 0.03, bytes: 3000 }),
    row("hare10", "done", { flip: 0.01, bytes: 1000 }),
    row("hare9", "warned", { flip: 0.04, bytes: 2000, warnings: [ODD] }),
    row("wolf", "differs", { flip: 0.09, bytes: 4000, recipe: "recipes/night.toml" }),
    row(ODD, "failed", { failures: [{ task: "bake", command: "pelage bake 'a b'", exit: 3, message: ODD }] }),
  ],
  charts: [{ name: "shells", model: "fox", file: "charts/fox/shells.svg", table: "charts/fox/shells.csv" }],
  sequences: [{ name: "turn", model: "fox", pictures: 12, first: null, pattern: "sequences/fox.turn/%04d.png" }],
};

let opened, folder;

before(async () => {
  if (!found()) return;
  folder = mkdtempSync(join(tmpdir(), "herd-"));
  const page = readFileSync(join(ROOT, "bake/herd/src/report.html"), "utf8");
  const data = JSON.stringify(DATA).replaceAll("<", "\\u003c");
  const filled = page.replace("__HERD_TITLE__", "Herd").replace("__HERD_DATA__", () => data);
  writeFileSync(join(folder, "report.html"), filled);
  opened = await launch();
});
after(async () => {
  await opened?.close();
  if (folder) rmSync(folder, { recursive: true });
});

/** Opens the report with the given fragment in its address. */
async function report(hash = "") {
  const page = await opened.newPage({ viewport: { width: 1200, height: 900 } });
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("request", (request) => {
    if (!request.url().startsWith("file:") && !request.url().startsWith("data:")) errors.push(request.url());
  });
  await page.goto(`file://${folder}/report.html${hash}`);
  await page.waitForSelector(".row", { state: "attached" });
  const shown = () => page.$$eval(".row", (rows) => rows.filter((row) => !row.hidden).map((row) => row.dataset.name));
  return { page, errors, shown };
}

inBrowser("a_herds_report_puts_failures_first_and_sorts", async () => {
  const first = await report();
  assert.deepEqual(await first.shown(), [ODD, "wolf", "hare9", "fox", "hare10"]);
  // Not `innerText`: rows outside the window are not laid out, and which rows those are depends on the machine's fonts.
  const text = await first.page.textContent("#rows");
  assert.ok(text.includes("onerror") && text.includes("recipes/night.toml"), "what is told is text");
  assert.equal(await first.page.evaluate(() => window.broken), undefined, "no data are a script");
  // A link preserves sorting and filters.
  for (const [hash, expected] of [
    ["#sort=error&order=desc", ["wolf", "hare9", "fox", "hare10", ODD]],
    ["#sort=bytes&order=asc", ["hare10", "hare9", "fox", "wolf", ODD]],
    ["#sort=name&state=done,warned", ["fox", "hare9", "hare10"]],
    ["#text=night", ["wolf"]],
    ["#sort=nonsense&size=-3", [ODD, "wolf", "hare9", "fox", "hare10"]],
  ]) {
    const { page, errors, shown } = await report(hash);
    assert.deepEqual(await shown(), expected, hash);
    assert.deepEqual(errors, [], hash);
    await page.close();
  }
  // Typing into the filter has the same effect.
  await first.page.fill("input[type=search]", "hare");
  await first.page.waitForFunction(() => location.hash.includes("text=hare"));
  assert.deepEqual(await first.shown(), ["hare9", "hare10"]);
  assert.deepEqual(first.errors, []);
});

inBrowser("a_herds_report_fits_a_phone_and_flips_pictures", async () => {
  const { page, errors } = await report("#text=wolf");
  await page.setViewportSize({ width: 400, height: 800 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.ok(wide <= 0, `${wide} pixels too wide`);
  await page.click(".row:not([hidden]) button:has(img), .row:not([hidden]) a:has(img), .row:not([hidden]) img");
  const dialog = page.locator("dialog[open]");
  await dialog.waitFor();
  const before = await dialog.innerText();
  await page.keyboard.press("Space");
  await page.waitForFunction((text) => document.querySelector("dialog[open]").innerText !== text, before);
  await page.keyboard.press("Escape");
  await page.waitForFunction(() => !document.querySelector("dialog[open]"));
  assert.deepEqual(errors, []);
});

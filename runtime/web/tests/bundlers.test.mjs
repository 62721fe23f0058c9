// Tests of the first lines of the npm package's README, in Vite and esbuild.

import assert from "node:assert/strict";
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { after, before } from "node:test";
import { inBrowser, LONG_MS, ROOT } from "./needs.mjs";
import { found, launch } from "./browser.mjs";
import { hare, OUT } from "./stage.mjs";
import { serve } from "../serve.mjs";

const README = readFileSync(`${ROOT}/runtime/web/npm/README.md`, "utf8");
/** Code of the README by language. */
const code = (language) => README.split(`\`\`\`${language}\n`)[1].split("```")[0];
/** Code span of the README's table in the row of `bundler`, by its position. */
const span = (bundler, at) => README.split(`\n| ${bundler} | `)[1].split("\n")[0].split("`")[2 * at + 1];
/** Syntax that Vite 5 and 6 produce by default. It has no `await` outside of functions. */
const OLD = "es2020";
let browser;

before(async () => {
  if (found()) browser = await launch();
});
after(() => browser?.close());

/**
 * Creates a project with the README's page and script, the npm package as it is published, and the hare. The script has
 * the line for `bundler`, and its promise is `window.shown`. Returns the folder.
 */
function project(bundler) {
  const [vite, line] = ["Vite", bundler].map((name) => span(name, 0));
  const script = code("js").replace(vite, () => line).replace(/^show/m, "window.shown = show");
  assert.ok(script.includes(line) && script.includes("window.shown"), script);
  const folder = `${OUT}/${bundler}`;
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(`${folder}/public`, { recursive: true });
  cpSync(`${ROOT}/target/web/npm`, `${folder}/node_modules/pelage`, { recursive: true });
  cpSync(hare(), `${folder}/public/hare.pelage`);
  writeFileSync(`${folder}/index.html`, `<!doctype html><link rel="icon" href="data:," />${code("html")}`);
  writeFileSync(`${folder}/main.js`, script);
  return folder;
}

/** Opens the page, and waits until the hare is loaded and its clip plays. Nothing is drawn, which would take long. */
async function assertLoads(address) {
  const page = await browser.newPage();
  await page.addInitScript(() => (window.requestAnimationFrame = () => 1));
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && faults.push(message.text()));
  await page.goto(address);
  await page.waitForFunction(() => "shown" in window, null, { polling: 50, timeout: LONG_MS / 4 }).catch(() => {});
  assert.deepEqual(faults, []);
  await page.evaluate(() => shown);
  assert.deepEqual(faults, []);
  await page.close();
}

/** Serves the folder and checks its page in the same way. */
async function assertServed(t, folder) {
  const server = await serve(folder);
  t.after(() => server.close());
  await assertLoads(`http://127.0.0.1:${server.address().port}/`);
}

inBrowser("readme_works_in_vite", async (t) => {
  const { build, createServer } = await import("vite");
  const root = project("Vite");
  const options = { root, configFile: false, logLevel: "error", server: { host: "127.0.0.1", port: 0 } };
  const development = await createServer(options);
  t.after(() => development.close());
  await development.listen();
  await assertLoads(development.resolvedUrls.local[0]);
  await build({ ...options, build: { target: OLD } });
  await assertServed(t, `${root}/dist`);
});

inBrowser("readme_works_in_esbuild", async (t) => {
  const { build } = await import("esbuild");
  const root = project("esbuild");
  const given = Object.fromEntries(span("esbuild", 1).split(" ").map((option) => option.slice(2).split("=")));
  const { format, "loader:.wasm": loader, "public-path": publicPath } = given;
  assert.ok("bundle" in given && format && loader && publicPath, span("esbuild", 1));
  await build({
    ...{ absWorkingDir: root, entryPoints: ["main.js"], outdir: "public", logLevel: "error", target: OLD },
    ...{ bundle: true, format, loader: { ".wasm": loader }, publicPath },
  });
  cpSync(`${root}/index.html`, `${root}/public/index.html`);
  await assertServed(t, `${root}/public`);
});

// Helpers for tests: the page and the npm package in one browser, and the `pelage` command for comparison.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { launch } from "./browser.mjs";
import { ROOT } from "./needs.mjs";
import { serve } from "../serve.mjs";

export const SITE = process.env.PELAGE_SITE ?? `${ROOT}/target/web/site`;
const PELAGE = process.env.PELAGE ?? `${ROOT}/target/debug/pelage`;
/** Folder for packages and images of the tests. */
export const OUT = `${ROOT}/target/web/tests`;
/** Largest mean FLIP at which the images of two rasterisers count as the same. */
const SAME = "0.02";

/** Runs the command and returns its output. */
export function pelage(...args) {
  const env = { XDG_RUNTIME_DIR: "/tmp", ...process.env };
  return execFileSync(PELAGE, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"], env });
}

/** Bakes the hare if necessary, and returns the path of its package. */
export function hare() {
  const file = `${OUT}/hare.pelage`;
  mkdirSync(OUT, { recursive: true });
  // Another build may produce a different package.
  const made = existsSync(file) && statSync(file).mtimeMs > statSync(PELAGE).mtimeMs;
  const [model, recipe] = [`${ROOT}/assets/models/hare.glb`, `${ROOT}/assets/recipes/hare.toml`];
  if (!made) pelage("bake", model, "--recipe", recipe, "-o", file);
  return file;
}

/** Fails if two images differ visibly. */
export function assertSame(a, b) {
  pelage("compare", a, b, "--max-flip", SAME);
}

/** Fails if two images do not differ visibly. */
export function assertOther(a, b) {
  const differ = (error) => error.status === 7;
  assert.throws(() => pelage("compare", a, b, "--max-flip", SAME), differ, `${a} and ${b} are the same picture`);
}

/** Launches a server and a browser. */
export async function open() {
  const server = await serve(SITE);
  const address = `http://127.0.0.1:${server.address().port}`;
  const browser = await launch();
  return { browser, address, close: async () => (await browser.close(), server.close()) };
}

/**
 * Opens a page of that browser in a new context. `faults` collects its exceptions, and the errors and warnings on its
 * console. The hare is the server's only animal.
 */
export async function page({ browser, address }, { size = [480, 400], ratio = 1, before, path = "/" } = {}) {
  const viewport = { width: size[0], height: size[1] };
  const context = await browser.newContext({ viewport, deviceScaleFactor: ratio, acceptDownloads: false });
  const page = await context.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => {
    // A file that the server lacks is not a fault of the page.
    const isFault = ["error", "warning"].includes(message.type()) && !/status of 404/.test(message.text());
    if (isFault) faults.push(message.text());
  });
  const animals = [{ name: "Hare", file: "animals/hare.pelage" }];
  await page.route("**/animals/animals.json", (route) => route.fulfill({ json: animals }));
  await page.route("**/animals/hare.pelage", (route) => route.fulfill({ path: hare() }));
  const blank = { contentType: "text/html", body: "<!doctype html><title>blank</title>" };
  await page.route("**/blank", (route) => route.fulfill(blank));
  if (before) await page.addInitScript(before);
  await page.goto(address + path);
  return { page, faults, close: () => context.close() };
}

/** Opens a blank page with the hare on a canvas of that size, as `window.pelage`, without loop and controls. */
export async function bare(opened, { size = [320, 240], ratio, before, options = {} } = {}) {
  const shown = await page(opened, { before, ratio, path: "/blank" });
  await shown.page.evaluate(
    async ({ size, options }) => {
      const { Pelage } = await import("/pelage/index.js");
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = size;
      document.body.append(canvas);
      window.pelage = await Pelage.create(canvas, { autoSize: false, loop: false, controls: false, ...options });
      window.happened = [];
      for (const type of ["error", "devicelost", "devicerestored"]) {
        pelage.addEventListener(type, ({ detail }) => happened.push([type, detail?.message ?? ""]));
      }
      await pelage.load("/animals/hare.pelage");
    },
    { size, options },
  );
  return shown;
}

/** Saves a screenshot of `window.pelage`, and returns the path of the file. */
export async function picture(page, name) {
  const bytes = await page.evaluate(async () => {
    const blob = await pelage.screenshot();
    const bytes = new Uint8Array(await blob.arrayBuffer());
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  });
  const file = `${OUT}/${name}.png`;
  writeFileSync(file, Buffer.from(bytes, "base64"));
  return file;
}

/** Returns the mean red, green and blue of a square of 5 x 5 pixels of a PNG, decoded by that page. */
export function colorAt(page, png, x, y) {
  return page.evaluate(
    async ({ base64, x, y }) => {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]));
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(x - 2, y - 2, 5, 5);
      const mean = (channel) => data.reduce((sum, value, i) => sum + (i % 4 === channel ? value : 0), 0) / 25;
      return [0, 1, 2].map(mean);
    },
    { base64: png.toString("base64"), x, y },
  );
}

/** Returns whether a colour is that of the hare's fur. */
export function isFur([r, g, b]) {
  return r > g && g > b && r < 150 && r < 2 * b + 60;
}

/** Draws the hare with the command, and returns the path of the image. */
export function rendered(name, size, ...args) {
  const file = `${OUT}/${name}.png`;
  pelage("render", hare(), "-o", file, "--size", size.join("x"), ...args);
  return file;
}

export function bytesOf(file) {
  return readFileSync(file);
}

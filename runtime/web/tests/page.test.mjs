// Tests of the page through its controls.

import assert from "node:assert/strict";
import { readFileSync, readdirSync, statSync } from "node:fs";
import { extname, join } from "node:path";
import { after, before } from "node:test";
import { data, inBrowser, LONG_MS } from "./needs.mjs";
import { found } from "./browser.mjs";
import { assertOther, assertSame, bytesOf, hare, open, page, picture } from "./stage.mjs";

let opened;

before(async () => {
  if (found()) opened = await open();
});
after(() => opened?.close());

/** Opens the page and waits until it shows the hare. */
async function loaded(options) {
  const shown = await page(opened, options);
  await shown.page.waitForFunction(() => window.pelage?.stats.frames > 0, null, { timeout: LONG_MS });
  return shown;
}

/** Waits until the canvas shows all changes. */
async function settled(page) {
  await page.evaluate(async () => {
    const turn = () => new Promise(requestAnimationFrame);
    let before;
    do {
      before = pelage.stats.frames;
      await turn();
      await pelage.idle();
      await turn();
    } while (pelage.stats.frames !== before);
  });
}

/** Drops a file onto the page, as a user does. */
async function drop(page, name, bytes) {
  const file = await page.evaluateHandle(
    ({ name, base64 }) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
      return transfer;
    },
    { name, base64: bytes.toString("base64") },
  );
  for (const type of ["dragenter", "dragover", "drop"]) await page.dispatchEvent("main", type, { dataTransfer: file });
}

const message = (page) => page.locator("#message:not([hidden])");

inBrowser("knobs_of_the_page_change_the_picture", async () => {
  const { page, faults, close } = await loaded({ size: [420, 420] });
  const fur = await picture(page, "page_fur");
  await page.click("text=Ink");
  await settled(page);
  assert.equal(await page.evaluate(() => pelage.style), "ink");
  const ink = await picture(page, "page_ink");
  assertOther(fur, ink);
  await page.click("#brush summary");
  await page.selectOption("#ink-style", "wet");
  await settled(page);
  const wet = await picture(page, "page_wet");
  assertOther(ink, wet);
  assert.equal(await page.locator("#brush [name=wetness]").inputValue(), "1");
  await page.locator("#brush [name=wash]").fill("0.2");
  await settled(page);
  assertOther(wet, await picture(page, "page_pale"));
  assert.equal(await page.inputValue("#ink-style"), "own");
  await page.selectOption("#ink-style", "default");
  await settled(page);
  assertSame(ink, await picture(page, "page_default"));
  await page.click("text=Fur");
  assert.ok(!(await page.isVisible("#brush")));

  await page.selectOption("#clip", { label: "Walk" });
  await page.waitForFunction(() => pelage.playback.timeS > 0);
  await page.click("#play");
  const { playing, timeS } = await page.evaluate(() => pelage.playback);
  assert.ok(!playing && timeS > 0, `${playing} ${timeS}`);
  await page.locator("#time").fill("0.3");
  assert.ok(Math.abs((await page.evaluate(() => pelage.playback.timeS)) - 0.3) < 1e-3);
  await settled(page);
  const walking = await picture(page, "page_walk");
  assertOther(fur, walking);

  const pad = await page.locator("#light").boundingBox();
  await page.mouse.click(pad.x + pad.width * 0.95, pad.y + pad.height / 2);
  await settled(page);
  assertOther(walking, await picture(page, "page_light"));
  assert.match(await page.textContent("#numbers"), /^\d+\.\d ms · 420 × \d+ · \d+ MB$/);
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("pointer_input_moves_the_camera", async () => {
  const { page, faults, close } = await loaded();
  const camera = () => page.evaluate(() => ({ ...pelage.orbit, ...pelage.camera }));
  const box = await page.locator("canvas").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const drag = async (button) => {
    await page.mouse.move(x, y);
    await page.mouse.down({ button });
    await page.mouse.move(x + 60, y + 20, { steps: 3 });
    await page.mouse.up({ button });
  };
  const home = await camera();
  await drag("left");
  const turned = await camera();
  // A drag by the height of the picture is half a turn.
  const turnDeg = home.azimuthDeg - turned.azimuthDeg;
  assert.ok(Math.abs(turnDeg - (180 * 60) / box.height) < 1, JSON.stringify([home, turned]));
  assert.ok(turned.elevationDeg > home.elevationDeg, "pulled down, the model shows its back");
  assert.deepEqual(turned.target, home.target);

  await page.mouse.wheel(0, -300);
  const near = await camera();
  assert.ok(near.distanceM < 0.8 * turned.distanceM, `${near.distanceM}`);
  await drag("right");
  const aside = await camera();
  assert.notDeepEqual(aside.target, near.target);
  assert.ok(Math.abs(aside.distanceM - near.distanceM) < 1e-3);

  await page.keyboard.press("r");
  assert.deepEqual(await camera(), home);
  await page.keyboard.press("ArrowLeft");
  assert.ok((await camera()).azimuthDeg < home.azimuthDeg);
  await page.keyboard.press("f");
  assert.deepEqual(await camera(), home);
  await page.keyboard.press("Space");
  assert.ok(await page.evaluate(() => pelage.playback.playing));
  await page.keyboard.press("Space");

  // Two fingers move apart.
  await page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const touch = (type, pointerId, dx) => {
      const [clientX, clientY] = [left + width / 2 + dx, top + height / 2];
      canvas.dispatchEvent(new PointerEvent(type, { pointerId, pointerType: "touch", clientX, clientY }));
    };
    canvas.setPointerCapture = () => {};
    touch("pointerdown", 7, -40);
    touch("pointerdown", 8, 40);
    touch("pointermove", 7, -80);
    touch("pointermove", 8, 80);
    touch("pointerup", 7, -80);
    touch("pointerup", 8, 80);
  });
  const pinched = await camera();
  const errorM = Math.abs(pinched.distanceM * 2 - home.distanceM);
  assert.ok(errorM < 0.05 * home.distanceM, `${pinched.distanceM} of ${home.distanceM}`);
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("broken_dropped_packages_are_named_and_the_page_continues", async () => {
  const { page, faults, close } = await loaded();
  const whole = readFileSync(hare());
  const flipped = Buffer.from(whole);
  flipped[whole.length >> 1] ^= 0x10;
  const before = await picture(page, "before_drop");
  for (const [name, bytes, words] of [
    ["cut.pelage", whole.subarray(0, whole.length >> 1), /^cut\.pelage: .*(offset|byte)/],
    ["flipped.pelage", flipped, /^flipped\.pelage: section \w+.*/],
    ["empty.pelage", Buffer.alloc(0), /^empty\.pelage: /],
    ["notes.txt", Buffer.from("no package at all"), /^notes\.txt: /],
  ]) {
    await drop(page, name, bytes);
    await message(page).waitFor({ timeout: LONG_MS });
    const text = await page.textContent("#message p");
    assert.match(text, words);
    assert.equal(await page.textContent("#message h2"), "This file cannot be drawn");
    await page.click("text=Dismiss");
    // The previous package is still shown.
    assert.deepEqual(bytesOf(await picture(page, "after_drop")), bytesOf(before), name);
  }
  await drop(page, "again.pelage", whole);
  await page.waitForFunction(() => pelage.info?.name === "again.pelage", null, { timeout: LONG_MS });
  assert.equal(await page.textContent("#caption"), `again · ${(whole.length / 1e6).toFixed(1)} MB`);
  assert.deepEqual(faults, []);
  await close();
});

const folder = data("page_survives_files_other_than_packages");
const feedEveryFile = async () => {
  const { page, faults, close } = await loaded();
  const names = readdirSync(folder, { recursive: true });
  const paths = names.map((name) => join(folder, name)).filter((path) => statSync(path).isFile());
  assert.ok(paths.length > 500, `${paths.length} files`);
  await page.route("**/data/*", (route) => {
    const path = paths[Number(new URL(route.request().url()).pathname.split("/").pop())];
    return route.fulfill({ path, contentType: "application/octet-stream" });
  });
  const before = await picture(page, "before_data");
  const taken = await page.evaluate(async (count) => {
    const taken = [];
    for (let i = 0; i < count; i += 1) {
      const refused = (error) => error.kind === "package" || taken.push([i, error.kind, error.message]);
      await pelage.load(`data/${i}`).then(() => taken.push([i, "taken"]), refused);
    }
    return taken;
  }, paths.length);
  assert.deepEqual(taken.map(([i, ...how]) => [paths[i], ...how]), []);
  // Drops one file of each extension, as a user does.
  const kinds = new Map(paths.map((path) => [extname(path), path]));
  for (const [kind, path] of kinds) {
    await drop(page, `file${kind}`, readFileSync(path));
    await message(page).waitFor({ timeout: LONG_MS });
    await page.click("text=Dismiss");
  }
  assert.deepEqual(bytesOf(await picture(page, "after_data")), bytesOf(before));
  assert.deepEqual(faults, []);
  await close();
};
inBrowser("page_survives_files_other_than_packages", feedEveryFile, folder);

inBrowser("missing_webgpu_is_reported", async () => {
  for (const [before, title, words] of [
    [() => Object.defineProperty(navigator, "gpu", { value: undefined }), "This needs WebGPU", /no WebGPU.*Chrome/],
    [() => (GPU.prototype.requestAdapter = async () => null), "No suitable graphics adapter", /adapter/],
  ]) {
    const { page: shown, close } = await page(opened, { before });
    await message(shown).waitFor({ timeout: LONG_MS });
    assert.equal(await shown.textContent("#message h2"), title);
    assert.match(await shown.textContent("#message p"), words);
    assert.equal(await shown.locator("[inert]").count(), 2, "knobs that have nothing to turn");
    await close();
  }
});

inBrowser("the_page_fits_a_phone", async () => {
  const { page, close } = await loaded({ size: [360, 640] });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.equal(wide, 360);
  for (const knob of ["#play", "#clip", "#time", "#light", "#home", "#save", ".open", "#style"]) {
    const box = await page.locator(knob).boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= 360 && box.y + box.height <= 640, `${knob}: ${JSON.stringify(box)}`);
  }
  await close();
});

// Test of the example with three.js: its meshes and the fur occlude each other.

import assert from "node:assert/strict";
import { existsSync, writeFileSync } from "node:fs";
import { inBrowser, LONG_MS, ROOT } from "./needs.mjs";
import { hare, open, OUT, page, SITE } from "./stage.mjs";

const EXAMPLE = `${ROOT}/runtime/web/examples/three`;

inBrowser("fur_and_three_js_meshes_occlude_each_other", async () => {
  assert.ok(existsSync(`${EXAMPLE}/node_modules/three`), "three.js is not there: npm ci in runtime/web/examples/three");
  const opened = await open();
  // Stops the clock of the animation.
  const before = () => {
    const request = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (turn) => request(() => turn(0));
  };
  const { page: shown, faults } = await page(opened, { size: [320, 240], before, path: "/blank" });
  await shown.route("**/three/**", (route) => {
    const path = new URL(route.request().url()).pathname.replace("/three/", "");
    if (path === "hare.pelage") route.fulfill({ path: hare() });
    else if (path.startsWith("pelage/")) route.fulfill({ path: `${SITE}/${path}` });
    else route.fulfill({ path: `${EXAMPLE}/${path || "index.html"}` });
  });
  const submitted = () => {
    window.submissions = 0;
    const submit = GPUQueue.prototype.submit;
    GPUQueue.prototype.submit = function (...args) {
      submissions += 1;
      return submit.apply(this, args);
    };
  };
  await shown.addInitScript(submitted);
  await shown.goto(`${opened.address}/three/`);
  await shown.waitForFunction(() => submissions > 12, null, { timeout: LONG_MS });
  const picture = await shown.screenshot();
  writeFileSync(`${OUT}/three.png`, picture);

  /** Returns the mean red, green and blue of a square of 5 x 5 pixels. */
  const color = (x, y) =>
    shown.evaluate(
      async ({ base64, x, y }) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const bitmap = await createImageBitmap(new Blob([bytes]));
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
        context.drawImage(bitmap, 0, 0);
        const { data } = context.getImageData(x - 2, y - 2, 5, 5);
        const mean = (channel) => data.reduce((sum, value, i) => sum + (i % 4 === channel ? value : 0), 0) / 25;
        return [0, 1, 2].map(mean);
      },
      { base64: picture.toString("base64"), x, y },
    );
  const gold = ([r, g, b]) => r > 120 && r > 1.08 * g && g > 1.5 * b;
  const fur = ([r, g, b]) => r > g && g > b && r < 150 && r < 2 * b + 60;
  const colors = {
    ear: await color(161, 44),
    ringBefore: await color(147, 144),
    ringBehind: await color(155, 100),
    ringBeside: await color(210, 102),
    body: await color(180, 165),
    mesh: await color(20, 220),
  };
  const words = JSON.stringify(colors);
  assert.ok(gold(colors.ringBefore) && gold(colors.ringBeside), words);
  assert.ok(fur(colors.body) && fur(colors.ear) && fur(colors.ringBehind), words);
  assert.ok(colors.mesh[1] > colors.mesh[0], words);
  assert.deepEqual(faults, []);
  await opened.close();
});

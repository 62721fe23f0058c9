// Test of the example with three.js: its meshes and the fur occlude each other.

import assert from "node:assert/strict";
import { existsSync, writeFileSync } from "node:fs";
import { inBrowser, LONG_MS, ROOT } from "./needs.mjs";
import { colorAt, hare, isFur, open, OUT, page, SITE } from "./stage.mjs";

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

  const color = (x, y) => colorAt(shown, picture, x, y);
  const gold = ([r, g, b]) => r > 120 && r > 1.08 * g && g > 1.5 * b;
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
  assert.ok(isFur(colors.body) && isFur(colors.ear) && isFur(colors.ringBehind), words);
  assert.ok(colors.mesh[1] > colors.mesh[0], words);
  assert.deepEqual(faults, []);
  await opened.close();
});

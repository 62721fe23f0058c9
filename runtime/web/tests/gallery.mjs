// Makes the gallery's image of the page from a running server: `node gallery.mjs ADDRESS PNG`. It shows the page at the
// width of a desktop and of a phone, side by side.

import { writeFileSync } from "node:fs";
import { launch } from "./browser.mjs";

const [address, file] = process.argv.slice(2);
if (!file) {
  console.error("usage: node gallery.mjs ADDRESS PNG");
  process.exit(2);
}

/** Returns a screenshot of the page, once it shows the animal and `prepare` has run. */
async function shot(browser, { size, animal, prepare }) {
  const page = await browser.newPage({ viewport: { width: size[0], height: size[1] } });
  await page.goto(`${address}?animal=${animal}`);
  await page.waitForFunction(() => window.pelage?.stats.frames > 0, null, { timeout: 120_000 });
  await prepare(page);
  await page.evaluate(async () => {
    pelage.frame();
    await pelage.idle();
  });
  // The page updates its figures after the frame is complete.
  await page.waitForTimeout(500);
  const picture = (await page.screenshot()).toString("base64");
  await page.close();
  return picture;
}

const browser = await launch();
const pictures = [
  await shot(browser, {
    size: [960, 600],
    animal: "Hare",
    prepare: async (page) => {
      await page.evaluate(() => (pelage.orbit = { azimuthDeg: -32, elevationDeg: 9 }));
      await page.evaluate(() => pelage.zoomBy(1.12, 0, 0.03));
      const pad = await page.locator("#light").boundingBox();
      await page.mouse.click(pad.x + pad.width * 0.66, pad.y + pad.height * 0.3);
      await page.mouse.move(0, 0);
    },
  }),
  await shot(browser, {
    size: [340, 600],
    animal: "Pony",
    prepare: (page) => page.click("text=Ink"),
  }),
];
const page = await browser.newPage();
await page.setContent(
  "<style>body{margin:0;display:flex;align-items:start;gap:16px;width:max-content;background:#0d0e10;padding:16px}" +
    `</style>${pictures.map((p) => `<img src="data:image/png;base64,${p}">`).join("")}`,
);
writeFileSync(file, await page.locator("body").screenshot());
await browser.close();

// Debian's Chromium without a display, and WebGPU on its software rasteriser.

import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

/** Where a Chromium may be; `CHROMIUM` names another. */
const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/**
 * With the first there is an adapter at all; with any of the next three missing the device is lost at the first use of a canvas, or there is none. The rest
 * keeps the browser quiet.
 */
const FLAGS = [
  "--enable-unsafe-webgpu",
  "--enable-features=Vulkan",
  "--use-vulkan=swiftshader",
  "--use-angle=swiftshader",
  "--use-webgpu-adapter=swiftshader",
  "--enable-unsafe-swiftshader",
  "--ignore-gpu-blocklist",
  // Nothing but the tests' own pages is opened, and root has no sandbox.
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  // `gc()` for the tests of memory.
  "--js-flags=--expose-gc",
  "--enable-precise-memory-info",
];

/** The path of a Chromium, or null. */
export function found() {
  return process.env.CHROMIUM ?? PLACES.find((place) => existsSync(place)) ?? null;
}

/** A browser with those flags; `more` are added. */
export function launch(more = []) {
  return chromium.launch({ executablePath: found(), args: [...FLAGS, ...more], headless: true });
}

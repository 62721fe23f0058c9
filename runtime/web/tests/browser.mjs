// Runs Debian's Chromium without a display, with WebGPU on its software rasteriser.

import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

/** Paths where Chromium may be; `CHROMIUM` names another one. */
const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/**
 * Flags of the browser. Without the first, there is no adapter. Without any of the next three, the device is lost at
 * the first use of a canvas, or there is no device. The remaining flags suppress activity of the browser.
 */
const FLAGS = [
  "--enable-unsafe-webgpu",
  "--enable-features=Vulkan",
  "--use-vulkan=swiftshader",
  "--use-angle=swiftshader",
  "--use-webgpu-adapter=swiftshader",
  "--enable-unsafe-swiftshader",
  "--ignore-gpu-blocklist",
  // Only the tests' own pages are opened, and the sandbox is not available to root.
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  // Provides `gc()` to the tests of memory.
  "--js-flags=--expose-gc",
  "--enable-precise-memory-info",
];

/** Returns the path of Chromium, or null. */
export function found() {
  return process.env.CHROMIUM ?? PLACES.find((place) => existsSync(place)) ?? null;
}

/** Launches a browser with `FLAGS` and the additional flags `more`. */
export function launch(more = []) {
  return chromium.launch({ executablePath: found(), args: [...FLAGS, ...more], headless: true });
}

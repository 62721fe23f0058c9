// Requirements of tests that a machine may lack, like tests/needs for the tests in Rust. Each test logs its name, and
// the log is compared with the register.

import { appendFileSync, existsSync } from "node:fs";
import { resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { found } from "./browser.mjs";

/** Root folder of the repository. */
export const ROOT = fileURLToPath(new URL("../../..", import.meta.url)).replace(/\/$/, "");

const isCi = !["", "0", "false"].includes(process.env.CI ?? "");

function note(how, need, test, words) {
  const log = process.env.PELAGE_TEST_LOG;
  if (log) appendFileSync(log, `${how}\t${need}\t${test}\t${words.replace(/[\n\t]/g, " ")}\n`);
}

/** Logs and returns whether the requirement of a test is met. If `CI` is set, a missing requirement is an error. */
function has(need, test, what, missing) {
  note(what ? "had" : "lacked", need, test, what ?? missing);
  if (what) return true;
  console.error(`SKIPPED: ${test} (${missing})`);
  if (isCi) throw new Error(`${test}: ${missing}; CI is set, and nothing is skipped there`);
  return false;
}

/** Returns whether there is a Chromium for the named test. */
function browser(test) {
  return has("browser", test, found(), "no Chromium at /usr/bin, and CHROMIUM names none");
}

/** Returns the folder of shared test data for the named test, or null. */
export function data(test) {
  const folder = process.env.PELAGE_DATA ?? resolve(ROOT, "../shared/data");
  const there = existsSync(`${folder}/meshes`) && existsSync(`${folder}/ktx2`);
  return has("data", test, there ? folder : null, `no test data at ${folder}`) ? folder : null;
}

/** Timeout of a test in the browser, milliseconds. */
export const LONG_MS = 120_000;

/** Declares a test in the browser. It is skipped if there is no browser, or if `more` is false. */
export function inBrowser(name, body, more = true) {
  const hasBrowser = browser(name);
  test(name, { timeout: LONG_MS }, async (t) => {
    if (hasBrowser && more) await body(t);
    else t.skip();
  });
}

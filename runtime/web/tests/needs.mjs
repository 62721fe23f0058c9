// What tests need that a machine may lack, as tests/needs has it for the tests in Rust: each says its name, and the log is held against the register.

import { appendFileSync, existsSync } from "node:fs";
import { resolve } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { found } from "./browser.mjs";

/** The repository. */
export const ROOT = fileURLToPath(new URL("../../..", import.meta.url)).replace(/\/$/, "");

const isCi = !["", "0", "false"].includes(process.env.CI ?? "");

function note(how, need, test, words) {
  const log = process.env.PELAGE_TEST_LOG;
  if (log) appendFileSync(log, `${how}\t${need}\t${test}\t${words.replace(/[\n\t]/g, " ")}\n`);
}

/** Whether there is what the test of that name needs; under `CI` what is missing is a failure. */
function has(need, test, what, missing) {
  note(what ? "had" : "lacked", need, test, what ?? missing);
  if (what) return true;
  console.error(`SKIPPED: ${test} (${missing})`);
  if (isCi) throw new Error(`${test}: ${missing}; CI is set, and nothing is skipped there`);
  return false;
}

/** A Chromium for the test of that name. */
export function browser(test) {
  return has("browser", test, found(), "no Chromium at /usr/bin, and CHROMIUM names none");
}

/** The folder of shared test data for the test of that name, or null. */
export function data(test) {
  const folder = process.env.PELAGE_DATA ?? resolve(ROOT, "../shared/data");
  const there = existsSync(`${folder}/meshes`) && existsSync(`${folder}/ktx2`);
  return has("data", test, there ? folder : null, `no test data at ${folder}`) ? folder : null;
}

/** So long a test in the browser may take. */
export const LONG_MS = 120_000;

/** A test in the browser, where there is what it needs. */
export function inBrowser(name, needed, body) {
  test(name, { timeout: LONG_MS }, async (t) => {
    if (needed) await body(t);
    else t.skip();
  });
}

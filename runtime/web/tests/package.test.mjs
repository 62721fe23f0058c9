// Tests of the npm package, without a browser.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { ROOT } from "./needs.mjs";

const NPM = `${ROOT}/target/web/npm`;
/** Maximum compressed size of WebAssembly and JavaScript of a page, bytes. */
const MOST_BYTES = 500_000;

// The profile `page` is built quickly, for tests; `./run test --all` builds the published one.
const quick = process.env.PELAGE_PAGE === "page" && "only ./run test --all builds the page as people load it";

test("page downloads are small", { skip: quick }, () => {
  const files = readdirSync(NPM).filter((file) => /\.(js|wasm)$/.test(file));
  assert.ok(files.includes("index.js") && files.includes("pelage_web_bg.wasm"), files.join());
  const sizes = files.map((file) => gzipSync(readFileSync(`${NPM}/${file}`), { level: 9 }).length);
  const sum = sizes.reduce((a, b) => a + b);
  console.log(`compressed: ${sum} bytes: ${files.map((file, i) => `${file} ${sizes[i]}`).join(", ")}`);
  assert.ok(sum <= MOST_BYTES, `${sum} bytes, expected ${MOST_BYTES} at most`);
});

test("npm package is complete", () => {
  const options = { cwd: NPM, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] };
  const [packed] = JSON.parse(execFileSync("npm", ["pack", "--dry-run", "--json", "--offline"], options));
  const { files } = JSON.parse(readFileSync(`${NPM}/package.json`, "utf8"));
  assert.deepEqual(packed.files.map(({ path }) => path).sort(), [...files, "package.json"].sort());
});

test("type declarations match the class", () => {
  const members = (text, line) => new Set([...text.matchAll(line)].map(([, name]) => name));
  const between = (file, from) => readFileSync(`${NPM}/${file}`, "utf8").split(from)[1].split("\n}")[0];
  for (const [file, name, least] of [["index.js", "Pelage", 25], ["pass.js", "PelagePass", 7]]) {
    const [code, types] = [file, "index.d.ts"].map((text) => between(text, `export class ${name} `));
    const has = members(code, /^ {2}(?:static async |async |get |set )?(\w+)\(.*\{$/gm);
    const says = members(types, /^ {2}(?:private |static |readonly |get |set )*(\w+)[(:<]/gm);
    // The types declare members of EventTarget again, with the types of the events.
    for (const inherited of ["addEventListener", "removeEventListener"]) says.delete(inherited);
    assert.ok(has.size > least, `${has.size} members of ${name}`);
    assert.deepEqual([...says].sort(), [...has].sort());
  }
});

test("npm version equals the crate version", () => {
  const { version } = JSON.parse(readFileSync(`${ROOT}/runtime/web/npm/package.json`, "utf8"));
  assert.ok(readFileSync(`${ROOT}/Cargo.toml`, "utf8").includes(`\nversion = "${version}"\n`), version);
});

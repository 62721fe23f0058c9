// Tests of the static server: `serve.mjs`.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { request } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { ROOT } from "./needs.mjs";
import { serve } from "../serve.mjs";

/** Starts the server on a new folder with the given files. Returns the folder and a function that requests a path. */
async function served(t, files) {
  const folder = mkdtempSync(join(tmpdir(), "pelage-serve-"));
  for (const [name, bytes] of Object.entries(files)) writeFileSync(join(folder, name), bytes);
  const server = await serve(folder);
  t.after(() => {
    server.close();
    rmSync(folder, { recursive: true });
  });
  const { address, port } = server.address();
  assert.equal(address, "127.0.0.1");
  /** Resolves to status and type of a response. If `abort`, hangs up when the response begins. */
  const ask = (path, { abort, ...options } = {}) =>
    new Promise((resolve, reject) => {
      const asked = request({ port, host: "127.0.0.1", path, agent: false, ...options }, (response) => {
        const answer = [response.statusCode, response.headers["content-type"]];
        response.on("error", () => {}).on("close", () => resolve(answer));
        if (abort) asked.destroy();
        else response.resume();
      });
      asked.on("error", reject).end();
    });
  return { folder, ask };
}

test("server serves only files of its folder with their types", async (t) => {
  const { folder, ask } = await served(t, { "index.html": "", "page.js": "", "a.wasm": "" });
  assert.deepEqual(await ask("/"), [200, "text/html; charset=utf-8"]);
  assert.deepEqual(await ask("/page.js"), [200, "text/javascript; charset=utf-8"]);
  assert.deepEqual(await ask("/a.wasm", { method: "HEAD" }), [200, "application/wasm"]);
  const outside = ["/../serve.mjs", "/..%2fserve.mjs", "/%2e%2e/serve.mjs", "//etc/passwd"];
  for (const path of [...outside, "/none", "/%", "/%00", "/page.js/"]) {
    assert.equal((await ask(path))[0], 404, path);
  }
  assert.equal((await ask("/", { method: "POST" }))[0], 405);
  // Links are followed within the folder.
  symlinkSync("a.wasm", join(folder, "in.js"));
  symlinkSync(`${ROOT}/run`, join(folder, "out"));
  symlinkSync(`${ROOT}/runtime`, join(folder, "folder"));
  symlinkSync("nowhere", join(folder, "broken"));
  assert.deepEqual(await ask("/in.js"), [200, "text/javascript; charset=utf-8"]);
  for (const path of ["/out", "/folder/README.md", "/broken"]) assert.equal((await ask(path))[0], 404, path);
});

test("server answers only requests to this machine", async (t) => {
  const { ask } = await served(t, { "index.html": "" });
  for (const host of ["localhost", "localhost:8080", "127.0.0.1:1", "[::1]:80"]) {
    assert.equal((await ask("/", { headers: { host } }))[0], 200, host);
  }
  for (const host of ["example.org", "example.org:8080", "localhost.example.org", "127.0.0.1.nip.io"]) {
    assert.equal((await ask("/", { headers: { host } }))[0], 403, host);
  }
});

test("server survives files that vanish", async (t) => {
  const { folder, ask } = await served(t, { "index.html": "", flickering: "" });
  const file = join(folder, "flickering");
  const seen = new Set();
  for (let i = 0; i < 200; i += 1) {
    writeFileSync(file, "here");
    const asked = ask("/flickering");
    for (let turns = 0; turns < i % 40; turns += 1) await new Promise(setImmediate);
    rmSync(file);
    seen.add((await asked)[0]);
  }
  assert.deepEqual([...seen].sort(), [200, 404]);
  assert.equal((await ask("/"))[0], 200);
});

const descriptors = () => readdirSync("/proc/self/fd").length;
const linux = { skip: process.platform !== "linux" && "descriptors are counted in /proc" };

test("server closes the files of aborted downloads", linux, async (t) => {
  const { ask } = await served(t, { large: Buffer.alloc(1 << 24) });
  await ask("/large", { abort: true });
  const before = descriptors();
  for (let i = 0; i < 20; i += 1) await ask("/large", { abort: true });
  for (let i = 0; i < 100 && descriptors() > before; i += 1) await new Promise((done) => setTimeout(done, 10));
  assert.ok(descriptors() <= before, `${descriptors()} descriptors, ${before} before`);
});

test("server takes its port from the argument or from PORT", async () => {
  const started = (port, ...args) => {
    const env = { ...process.env, PORT: port };
    const server = spawn("node", [`${ROOT}/runtime/web/serve.mjs`, `${ROOT}/runtime/web/page`, ...args], { env });
    return new Promise((resolve) => {
      server.on("close", resolve);
      server.stdout.once("data", (text) => {
        server.kill();
        resolve(Number(new URL(String(text)).port));
      });
    });
  };
  const free = await started("0");
  assert.ok(free > 0);
  assert.equal(await started(String(free)), free);
  assert.equal(await started("1", String(free)), free);
  for (const wrong of ["65536", "http", "-1"]) assert.equal(await started(wrong), 2, wrong);
});

// Serves a folder on loopback: `node serve.mjs FOLDER [PORT]`. Default port: the variable PORT, or 8080; 0 is any free
// port. If the port is in use, takes another. Prints the address, and runs until it is stopped.
//
// Uses only the modules of node itself, so that `./run web` installs nothing. Serves nothing outside the folder, and
// nothing to other machines.

import { open, realpath, stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, sep } from "node:path";
import { pipeline } from "node:stream/promises";
import { pathToFileURL } from "node:url";

const TYPES = {
  ".css": "text/css; charset=utf-8",
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".json": "application/json",
  ".pelage": "application/octet-stream",
  ".png": "image/png",
  ".svg": "image/svg+xml",
  // Browsers compile a module during the download only if it has this type.
  ".wasm": "application/wasm",
};

/** Names of this machine. Requests for other names come from pages whose name was made to point here. */
const LOCAL = /^(localhost|127\.0\.0\.1|\[::1\])(:\d+)?$/i;

/**
 * Opens the file below `folder` for the path of a request. Returns its type and handle, or null. Links are followed
 * within the folder only.
 */
async function find(folder, url) {
  try {
    const path = decodeURIComponent(new URL(url, "http://localhost").pathname);
    const name = path.endsWith("/") ? `${path}index.html` : path;
    const file = await realpath(join(folder, name));
    // Opening a pipe would wait for its writer.
    if (!file.startsWith(folder + sep) || !(await stat(file)).isFile()) return null;
    return { type: TYPES[extname(name)] ?? "application/octet-stream", handle: await open(file) };
  } catch {
    return null;
  }
}

/** Answers one request with a file of `folder`. */
async function answer(folder, request, response) {
  const refuse = (status, text) => response.writeHead(status, { "content-type": "text/plain" }).end(`${text}\n`);
  if (!LOCAL.test(request.headers.host ?? "")) return refuse(403, "unknown host; expected localhost or 127.0.0.1");
  if (!["GET", "HEAD"].includes(request.method)) return refuse(405, "expected GET or HEAD");
  const found = await find(folder, request.url);
  if (!found) return refuse(404, "not found");
  const { type, handle } = found;
  // No content-length: the file may change while it is sent.
  response.writeHead(200, {
    "content-type": type,
    // Rebuilt files are visible at once.
    "cache-control": "no-store",
    "x-content-type-options": "nosniff",
  });
  try {
    if (request.method === "HEAD") response.end();
    else await pipeline(handle.createReadStream({ autoClose: false }), response);
  } finally {
    await handle.close();
  }
}

/** Starts serving `folder`. Resolves to the listening server; its `address()` has the port. */
export async function serve(folder, port = 0) {
  const root = await realpath(folder);
  const server = createServer((request, response) => {
    // Downloads end early when a page is closed, or when a file cannot be read to its end.
    answer(root, request, response).catch(() => response.destroy());
  });
  return new Promise((listening, failed) => {
    server.once("error", failed);
    server.listen(port, "127.0.0.1", () => listening(server));
  });
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const [folder, port = process.env.PORT || "8080"] = process.argv.slice(2);
  if (!folder || !/^\d{1,5}$/.test(port) || Number(port) > 65535) {
    console.error(`usage: node serve.mjs FOLDER [PORT]; PORT is 0 to 65535, found ${port}`);
    process.exit(2);
  }
  const server = await serve(folder, Number(port)).catch((error) => {
    if (error.code === "EADDRINUSE") {
      console.error(`port ${port} is in use, taking another`);
      return serve(folder, 0);
    }
    console.error(error.message);
    process.exit(1);
  });
  console.log(`http://127.0.0.1:${server.address().port}/`);
}

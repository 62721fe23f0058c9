// Serves a folder on loopback: `node serve.mjs FOLDER [PORT]`; port 0 is any free port. Prints the address, and runs
// until it is stopped.
//
// Uses only the modules of node itself. Serves nothing outside the folder, and nothing to other machines.

import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, resolve, sep } from "node:path";
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

/** Returns the file below `folder` for the path of a request, or null. */
async function find(folder, url) {
  let path;
  try {
    path = decodeURIComponent(new URL(url, "http://localhost").pathname);
  } catch {
    return null;
  }
  const file = resolve(join(folder, path.endsWith("/") ? `${path}index.html` : path));
  if (!file.startsWith(folder + sep)) return null;
  const found = await stat(file).catch(() => null);
  return found?.isFile() ? { file, size: found.size } : null;
}

/** Starts serving `folder`. Resolves to the listening server; its `address()` has the port. */
export function serve(folder, port = 0) {
  const root = resolve(folder);
  const server = createServer(async (request, response) => {
    const found = request.method === "GET" || request.method === "HEAD" ? await find(root, request.url) : null;
    if (!found) {
      response.writeHead(404, { "content-type": "text/plain; charset=utf-8" }).end("not here\n");
      return;
    }
    response.writeHead(200, {
      "content-type": TYPES[extname(found.file)] ?? "application/octet-stream",
      "content-length": found.size,
      // Rebuilt files are visible at once.
      "cache-control": "no-store",
      "x-content-type-options": "nosniff",
      // Only the page's own scripts run in it.
      "content-security-policy":
        "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; " +
        "img-src 'self' blob: data:; connect-src 'self' blob:",
    });
    if (request.method === "HEAD") response.end();
    else createReadStream(found.file).pipe(response);
  });
  return new Promise((listening, failed) => {
    server.once("error", failed);
    server.listen(port, "127.0.0.1", () => listening(server));
  });
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const [folder, port = "8080"] = process.argv.slice(2);
  if (!folder || !/^\d+$/.test(port)) {
    console.error("usage: node serve.mjs FOLDER [PORT]");
    process.exit(2);
  }
  const server = await serve(folder, Number(port)).catch(async (error) => {
    if (error.code !== "EADDRINUSE") throw error;
    console.error(`port ${port} is in use, taking another`);
    return serve(folder, 0);
  });
  console.log(`http://127.0.0.1:${server.address().port}/`);
}

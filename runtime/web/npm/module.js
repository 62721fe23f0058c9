// Loading of the WebAssembly module, and conversion of its arguments and errors.

import init, { BUILD } from "./pelage_web.js";
import { PelageError } from "./error.js";

/** Promise of the module's only instance, shared by all canvases of a page. */
let module = null;

/** Loads the module, once. Fails if there is no WebGPU. */
export async function start(wasm) {
  if (!globalThis.navigator?.gpu) {
    const insecure = globalThis.isSecureContext === false;
    const why = insecure ? "the page is not served over https or from localhost" : "this browser has no WebGPU";
    const needed = "pelage needs WebGPU (Chrome and Edge 113, Safari 26, Firefox 141, or later)";
    throw new PelageError("no-webgpu", `${why}: ${needed}`);
  }
  module ??= instantiate(wasm ?? new URL("pelage_web_bg.wasm", import.meta.url)).catch((cause) => {
    module = null;
    throw new PelageError("module", `the WebAssembly module cannot be loaded: ${cause.message}`, { cause });
  });
  await module;
}

/** Instantiates the module from any value of the option `wasm`. */
async function instantiate(wasm) {
  if (typeof wasm === "string" || wasm instanceof URL || wasm instanceof Request) {
    wasm = await arrived(String(wasm.url ?? wasm), fetch(wasm));
  }
  if (wasm instanceof Response) {
    const { ok, status, headers, url } = wasm;
    const type = headers.get("content-type") ?? "no type";
    // Development servers answer unknown paths with their HTML page.
    if (!ok || /^text\//.test(type)) {
      const found = ok ? type : `status ${status}`;
      const advice = "pass the URL of pelage_web_bg.wasm as { wasm }; the README has the lines for bundlers";
      throw new Error(`${url}: found ${found}, expected application/wasm; ${advice}`);
    }
  }
  const compiled = await compile(wasm);
  // Files of different builds fail much later, and with errors that do not show the cause.
  const [section] = WebAssembly.Module.customSections(compiled, "pelage_build");
  const build = section ? new TextDecoder().decode(section) : "unknown";
  if (build !== BUILD) {
    const advice = "take both from the same package, and clear the caches of bundler and browser";
    throw new Error(`pelage_web_bg.wasm: found build ${build}, expected ${BUILD}, that of the scripts; ${advice}`);
  }
  await init({ module_or_path: compiled });
}

/** Compiles a response, bytes, or a module that is already compiled. */
async function compile(wasm) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  if (!(wasm instanceof Response)) return WebAssembly.compile(wasm);
  const streams = wasm.headers.get("content-type") === "application/wasm";
  return streams ? WebAssembly.compileStreaming(wasm) : WebAssembly.compile(await wasm.arrayBuffer());
}

/** Calls `f`, and converts the errors of the module. */
export function guarded(f) {
  try {
    return f();
  } catch (error) {
    throw PelageError.of(error);
  }
}

/** Awaits a promise of the browser. A failure becomes a `fetch` error about `name`, or the reason of `signal`. */
async function arrived(name, promise, signal) {
  try {
    return await promise;
  } catch (cause) {
    if (signal?.aborted) throw signal.reason;
    throw new PelageError("fetch", `${name}: ${cause.message}`, { cause });
  }
}

/** Returns the name and the bytes of any source that `load` accepts. */
export async function read(source, { name, signal }) {
  if (source instanceof ArrayBuffer) return [name ?? "package", new Uint8Array(source)];
  if (ArrayBuffer.isView(source)) {
    return [name ?? "package", new Uint8Array(source.buffer, source.byteOffset, source.byteLength)];
  }
  if (source instanceof Blob) {
    name ??= source.name ?? "package";
    return [name, new Uint8Array(await arrived(name, source.arrayBuffer(), signal))];
  }
  if (typeof source !== "string" && !(source instanceof URL)) {
    throw new PelageError("asked", `load: found ${typeof source}, expected a URL, an ArrayBuffer or a File`);
  }
  name ??= String(source);
  const response = await arrived(name, fetch(source, { signal }), signal);
  if (!response.ok) throw new PelageError("fetch", `${name}: ${response.status} ${response.statusText}`);
  const type = response.headers.get("content-type") ?? "";
  // Development servers answer unknown paths with their HTML page.
  if (type.startsWith("text/html")) throw new PelageError("fetch", `${name}: found ${type}, expected a package`);
  return [name, new Uint8Array(await arrived(name, response.arrayBuffer(), signal))];
}

/** Formats a value of the look for `key=value`. */
export function formatted(value) {
  return Array.isArray(value) ? JSON.stringify(value) : String(value);
}

// The WebAssembly module, and what goes in and out of it.

import init from "./pelage_web.js";
import { PelageError } from "./error.js";

/** The one instance of the module, which all canvases of a page share; a promise. */
let module = null;

/** Loads the module, once; fails where there is no WebGPU for it. */
export async function start(wasm) {
  if (!globalThis.navigator?.gpu) {
    const why = globalThis.isSecureContext === false ? "the page is not served over https or from localhost" : "this browser has no WebGPU";
    throw new PelageError("no-webgpu", `${why}: pelage needs WebGPU (Chrome and Edge 113, Safari 26, Firefox 141, or later)`);
  }
  module ??= init({ module_or_path: wasm ?? new URL("pelage_web_bg.wasm", import.meta.url) }).catch((cause) => {
    module = null;
    throw new PelageError("module", `the WebAssembly module cannot be loaded: ${cause.message}`, { cause });
  });
  await module;
}

/** Runs `f`, whose errors come from the module. */
export function guarded(f) {
  try {
    return f();
  } catch (error) {
    throw PelageError.of(error);
  }
}

/** What a promise of the browser comes to; where it fails, `name` did not arrive. */
async function arrived(name, promise, signal) {
  try {
    return await promise;
  } catch (cause) {
    if (signal?.aborted) throw signal.reason;
    throw new PelageError("fetch", `${name}: ${cause.message}`, { cause });
  }
}

/** Name and bytes of whatever `load` takes. */
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
  return [name, new Uint8Array(await arrived(name, response.arrayBuffer(), signal))];
}

/** A value of the look as `key=value` has it. */
export function written(value) {
  return Array.isArray(value) ? JSON.stringify(value) : String(value);
}

// Draws a package into the frame of another renderer on the same device; index.d.ts documents the API.

import { open_shared as openShared, Pass } from "./pelage_web.js";
import { PelageError } from "./error.js";
import { formatted, guarded, read, start } from "./module.js";

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export class PelagePass {
  #opened;
  #pass;
  #info = null;
  /** The three matrices of a frame. */
  #matrices = new Float32Array(48);

  static async open(options) {
    await start(options.wasm);
    const opened = await openShared().catch((error) => {
      throw PelageError.of(error);
    });
    return new PelagePass(opened, options);
  }

  /** @private */
  constructor(opened, { color, depth, reversedDepth = false }) {
    this.#opened = opened;
    this.#pass = guarded(() => new Pass(opened, color, depth, reversedDepth));
  }

  get device() {
    return this.#opened.device;
  }

  async load(source, options = {}) {
    const [name, bytes] = await read(source, options);
    this.#info = guarded(() => this.#pass.load(name, bytes));
    return this.#info;
  }

  get info() {
    return this.#info;
  }

  setLight({ towards, position, color }) {
    if (color) guarded(() => this.#pass.set_light_color(...color));
    if (towards) this.setLook("light.direction", [...towards]);
    if (position) this.setLook("light.position_m", [...position]);
  }

  setLook(key, value) {
    guarded(() => this.#pass.set_look(`${key}=${formatted(value)}`));
  }

  setEnvironment(toml) {
    guarded(() => (toml === null ? this.#pass.set_look("environment.sky=none") : this.#pass.set_environment(toml)));
  }

  draw({ color, depth, viewFromWorld, clipFromView, worldFromModel = IDENTITY, clip, timeS = 0, clockS }) {
    const index = clip === undefined ? -1 : (this.#info?.clips.findIndex(({ name }) => name === clip) ?? -1);
    if (clip !== undefined && index < 0) {
      const names = this.#info?.clips.map(({ name }) => name).join(", ");
      const expected = names ? `expected one of: ${names}` : "the package has none";
      throw new PelageError("asked", `clip ${clip}: no such clip; ${expected}`);
    }
    [viewFromWorld, clipFromView, worldFromModel].forEach((matrix, i) => this.#matrices.set(matrix, 16 * i));
    const { durationS } = this.#info?.clips[index] ?? {};
    const within = durationS > 0 ? timeS - durationS * Math.floor(timeS / durationS) : timeS;
    guarded(() => this.#pass.draw(color, depth, this.#matrices, index, within, clockS));
  }

  dispose() {
    this.#pass.free();
    this.#opened.free();
  }
}

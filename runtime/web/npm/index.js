// A .pelage package on a <canvas>; index.d.ts documents the API. This file owns the event loop, and the WebAssembly
// module does everything else.

import { open as openDevice, Viewer } from "./pelage_web.js";
import { control } from "./controls.js";
import { PelageError } from "./error.js";
import { formatted, guarded, read, start } from "./module.js";

export { PelageError };
export { PelagePass } from "./pass.js";

/** Maximum number of frames on the device: one being drawn and one waiting. */
const IN_FLIGHT = 2;
/** Maximum number of attempts to replace a lost device. */
const REOPENINGS = 4;
/** Delay before the second attempt, milliseconds; each further delay is twice as long. */
const REOPEN_MS = 250;
/** Longest time step, seconds. It keeps a tab that was in the background from catching up. */
const LONGEST_STEP_S = 0.25;

/** Canvases in use. A second device on a canvas would blank it. */
const taken = new WeakSet();

function wait(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}

/** Frees a device that is not needed. */
function discard(opened) {
  opened.device.destroy();
  opened.free();
}

export class Pelage extends EventTarget {
  #canvas;
  #options;
  #viewer;
  #device;
  /** Width and height of the picture, pixels. */
  #drawn;
  #adapter = "";
  #info = null;
  #loadCount = 0;
  #loop;
  #frameRequest = 0;
  #dirty = true;
  #inFlight = 0;
  #lastTickMs = null;
  #lastDoneMs = 0;
  #stats = { frames: 0, frameMs: 0, cpuMs: 0, passes: [], gpuBytes: 0, created: 0, uploadedBytes: 0 };
  #lost = false;
  #disposed = false;
  #observer = null;
  #stopControls = null;

  static async create(canvas, options = {}) {
    if (canvas?.localName !== "canvas") {
      throw new PelageError("asked", `create: found ${canvas?.localName ?? canvas}, expected a <canvas> element`);
    }
    if (taken.has(canvas)) {
      throw new PelageError("asked", "create: the canvas is in use, expected one without Pelage; call dispose() first");
    }
    const { signal } = options;
    signal?.throwIfAborted();
    taken.add(canvas);
    let pelage = null;
    // An aborted attempt leaves the canvas at once to the next one.
    const stop = () => (pelage ? pelage.dispose() : taken.delete(canvas));
    signal?.addEventListener("abort", stop, { once: true });
    try {
      await start(options.wasm);
      signal?.throwIfAborted();
      const opened = await openDevice(canvas);
      if (signal?.aborted) discard(opened);
      signal?.throwIfAborted();
      pelage = new Pelage(canvas, options, opened);
      return pelage;
    } catch (error) {
      if (signal?.aborted) throw signal.reason;
      signal?.removeEventListener("abort", stop);
      taken.delete(canvas);
      throw PelageError.of(error);
    }
  }

  /** @private */
  constructor(canvas, options, opened) {
    super();
    this.#canvas = canvas;
    this.#options = options;
    this.#loop = options.loop ?? true;
    this.#watch(opened);
    this.#drawn = this.#size();
    const { clientWidth, clientHeight } = canvas;
    this.#viewer = guarded(() => new Viewer(opened, ...this.#drawn));
    this.#pin(clientWidth, clientHeight);
    if (options.look) guarded(() => this.#viewer.read_look(options.look));
    if (options.autoSize ?? true) {
      this.#observer = new ResizeObserver(() => this.resize());
      this.#observer.observe(canvas);
    }
    if (options.controls ?? true) this.controls = true;
  }

  // Package.

  async load(source, options = {}) {
    this.#liveViewer();
    const count = ++this.#loadCount;
    const [name, bytes] = await read(source, options);
    // The last call wins, in whatever order the responses arrive.
    if (count !== this.#loadCount || this.#disposed) {
      throw new PelageError("superseded", `${name}: load() or dispose() was called in the meantime`);
    }
    this.#info = guarded(() => this.#viewer.load(name, bytes));
    this.#changed();
    this.#emit("load", this.#info);
    return this.#info;
  }

  get info() {
    return this.#info;
  }

  // Camera.

  get camera() {
    const [ex, ey, ez, tx, ty, tz, fovDeg] = this.#liveViewer().view();
    return { eye: [ex, ey, ez], target: [tx, ty, tz], fovDeg };
  }

  set camera(view) {
    const now = this.camera;
    const { eye, target, fovDeg } = { ...now, ...view };
    this.#change((viewer) => viewer.set_view(Float32Array.of(...eye, ...target, fovDeg)));
  }

  get orbit() {
    const [azimuthDeg, elevationDeg, distanceM] = this.#liveViewer().around();
    return { azimuthDeg, elevationDeg, distanceM };
  }

  set orbit(around) {
    const { azimuthDeg, elevationDeg, distanceM } = { ...this.orbit, ...around };
    this.#change((viewer) => viewer.go_around(azimuthDeg, elevationDeg, distanceM));
  }

  orbitBy(right, up) {
    this.#change((viewer) => viewer.orbit(right, up));
  }

  panBy(right, up) {
    this.#change((viewer) => viewer.pan(right, up));
  }

  zoomBy(factor, right = 0, up = 0) {
    this.#change((viewer) => viewer.zoom(factor, right, up));
  }

  frameAll() {
    this.#change((viewer) => viewer.frame_all());
  }

  resetCamera() {
    this.#change((viewer) => viewer.reset_view());
  }

  get controls() {
    return this.#stopControls !== null;
  }

  set controls(on) {
    this.#stopControls?.();
    this.#stopControls = null;
    if (!on) return;
    this.#stopControls = control(this.#canvas, {
      orbit: (right, up) => this.orbitBy(right, up),
      pan: (right, up) => this.panBy(right, up),
      zoom: (factor, right, up) => this.zoomBy(factor, right, up),
      reset: () => this.resetCamera(),
      frameAll: () => this.frameAll(),
      toggle: () => (this.playback.playing ? this.pause() : this.play()),
    });
  }

  // Light and look.

  setLight({ towards, position, color }) {
    this.#change((viewer) => {
      if (color) viewer.set_light_color(...color);
      if (towards) viewer.set_look(`light.direction=${formatted([...towards])}`);
      if (position) viewer.set_look(`light.position_m=${formatted([...position])}`);
    });
  }

  setLook(key, value) {
    this.#change((viewer) => viewer.set_look(`${key}=${formatted(value)}`));
  }

  setEnvironment(toml) {
    this.#change((viewer) => (toml === null ? viewer.set_look("environment.sky=none") : viewer.set_environment(toml)));
  }

  setSeal(image, place = []) {
    this.#change((viewer) => {
      if (image === null) viewer.set_look("ink.seal=none");
      else viewer.set_seal(image.width, image.height, new Uint8Array(image.data), [...place]);
    });
  }

  get look() {
    return this.#liveViewer().look();
  }

  set look(toml) {
    this.#change((viewer) => viewer.read_look(toml));
  }

  get style() {
    return /^style = "(\w+)"/m.exec(this.look)?.[1] ?? "fur";
  }

  set style(style) {
    this.setLook("picture.style", style);
  }

  get inkStyles() {
    return this.#liveViewer().constructor.ink_styles();
  }

  get inkStyle() {
    return this.#liveViewer().ink_style() ?? null;
  }

  set inkStyle(name) {
    this.#change((viewer) => viewer.set_ink_style(name));
  }

  // Clips.

  get clips() {
    return this.#info?.clips ?? [];
  }

  get playback() {
    return this.#liveViewer().playing();
  }

  play(name) {
    this.#change((viewer) => {
      const now = viewer.playing();
      if (name === undefined && now.clip === null && this.clips.length === 0) return;
      const clip = name ?? now.clip ?? this.clips[0].name;
      if (clip !== now.clip) viewer.set_clip(clip);
      // The end of a name may find the current clip, which continues.
      if (now.clip !== null && viewer.playing().clip === now.clip) viewer.seek(now.timeS);
      viewer.set_playing(true);
    });
  }

  pause() {
    this.#change((viewer) => viewer.set_playing(false));
  }

  rest() {
    this.#change((viewer) => viewer.set_clip(undefined));
  }

  seek(timeS) {
    this.#change((viewer) => viewer.seek(timeS));
  }

  setMorph(name, weight) {
    this.#change((viewer) => viewer.set_morph(name, weight ?? undefined));
  }

  get speed() {
    return this.playback.speed;
  }

  set speed(speed) {
    this.#change((viewer) => viewer.set_speed(speed));
  }

  // Frames.

  /** Draws a frame now, independently of the loop. */
  frame() {
    this.#liveViewer();
    this.#draw();
  }

  get stats() {
    const [width, height] = this.#drawn;
    return { ...this.#stats, adapter: this.#adapter, width, height };
  }

  /** Resolves when the canvas shows all changes so far. */
  async idle() {
    this.#liveViewer();
    if (this.#loop && this.#dirty) this.#draw();
    await this.#device.queue.onSubmittedWorkDone();
  }

  resize() {
    const size = this.#size();
    if (this.#disposed || size.every((length, i) => length === this.#drawn[i])) return;
    const { clientWidth, clientHeight } = this.#canvas;
    this.#change((viewer) => viewer.resize(...size));
    this.#pin(clientWidth, clientHeight);
    this.#drawn = size;
    // A resized canvas is empty, so it is drawn before the page shows it.
    if (this.#loop) this.#draw();
  }

  screenshot(type = "image/png") {
    this.#liveViewer();
    this.#draw();
    return new Promise((resolve, reject) => {
      const unreadable = () => new PelageError("device", "screenshot: the canvas cannot be read");
      const done = (blob) => (blob ? resolve(blob) : reject(unreadable()));
      // Must run in the same task as the frame, because the browser releases the canvas's texture afterwards.
      this.#canvas.toBlob(done, type);
    });
  }

  dispose() {
    if (this.#disposed) return;
    this.#disposed = true;
    cancelAnimationFrame(this.#frameRequest);
    this.#observer?.disconnect();
    this.controls = false;
    this.#viewer.free();
    this.#device.destroy();
    taken.delete(this.#canvas);
    this.#info = null;
  }

  // Private members.

  #liveViewer() {
    if (this.#disposed) throw new PelageError("asked", "this Pelage has been disposed; only dispose() may be called");
    return this.#viewer;
  }

  #emit(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  #change(change) {
    const viewer = this.#liveViewer();
    guarded(() => change(viewer));
    this.#changed();
  }

  #size() {
    const { autoSize = true, pixelRatio } = this.#options;
    const canvas = this.#canvas;
    if (!autoSize) return [canvas.width, canvas.height];
    const ratio = pixelRatio ?? Math.min(globalThis.devicePixelRatio ?? 1, 2);
    const most = this.#device.limits.maxTextureDimension2D;
    const pixels = (length) => Math.min(Math.max(Math.round(length * ratio), 1), most);
    return [pixels(canvas.clientWidth), pixels(canvas.clientHeight)];
  }

  /** Keeps the canvas's size on the page if its resolution determines it, because no CSS does. */
  #pin(width, height) {
    const canvas = this.#canvas;
    if (!(this.#options.autoSize ?? true)) return;
    if (canvas.clientWidth !== width) canvas.style.width = `${width}px`;
    if (canvas.clientHeight !== height) canvas.style.height = `${height}px`;
  }

  #changed() {
    this.#dirty = true;
    this.#requestFrame();
  }

  #requestFrame() {
    if (!this.#loop || this.#frameRequest || this.#disposed) return;
    this.#frameRequest = requestAnimationFrame((now) => {
      this.#frameRequest = 0;
      this.#tick(now);
    });
  }

  #tick(now) {
    if (this.#disposed || this.#lost) return;
    // Time stops while nothing moves.
    const moves = this.#isMoving;
    const elapsedS = moves && this.#lastTickMs !== null ? Math.min((now - this.#lastTickMs) / 1e3, LONGEST_STEP_S) : 0;
    this.#lastTickMs = moves ? now : null;
    if (this.#viewer.advance(elapsedS)) this.#dirty = true;
    // If the device lags behind, the next frame is requested when a frame is complete.
    if (this.#inFlight >= IN_FLIGHT) return;
    if (this.#dirty) this.#draw();
    if (this.#isMoving) this.#requestFrame();
  }

  /** Whether a clip plays, or hair is still in motion. */
  get #isMoving() {
    return this.playback.playing || this.#viewer.hair_moves();
  }

  #draw() {
    if (this.#lost) return;
    const start = performance.now();
    let drawn;
    try {
      drawn = guarded(() => this.#viewer.draw());
    } catch (error) {
      this.#dirty = false;
      this.#emit("error", error);
      return;
    }
    this.#dirty = false;
    if (!drawn) return;
    const cpuMs = performance.now() - start;
    this.#inFlight += 1;
    const done = () => {
      const now = performance.now();
      this.#inFlight -= 1;
      if (this.#disposed) return;
      // Excludes the time spent waiting for the previous frame.
      const frameMs = now - Math.max(start, this.#lastDoneMs);
      this.#lastDoneMs = now;
      this.#stats = { frames: this.#stats.frames + 1, frameMs, cpuMs, ...drawn };
      this.#emit("frame", this.stats);
      if (this.#dirty || this.#isMoving) this.#requestFrame();
    };
    this.#device.queue.onSubmittedWorkDone().then(done, done);
  }

  /** Uses this device from now on, and listens for its errors and its loss. */
  #watch(opened) {
    const device = opened.device;
    this.#device = device;
    this.#adapter = opened.adapter;
    device.addEventListener("uncapturederror", (event) => {
      if (device === this.#device) this.#emit("error", new PelageError("device", event.error.message));
    });
    device.lost.then((why) => {
      if (device === this.#device && !this.#disposed) this.#reopen(why);
    });
  }

  /** Replaces a lost device. */
  async #reopen(why) {
    this.#lost = true;
    this.#emit("devicelost", { reason: why.reason, message: why.message });
    let last;
    for (let attempt = 0; attempt < REOPENINGS && !this.#disposed; attempt += 1) {
      if (attempt > 0) await wait(REOPEN_MS * 2 ** (attempt - 1));
      try {
        const opened = await openDevice(this.#canvas);
        if (this.#disposed) return discard(opened);
        this.#watch(opened);
        guarded(() => this.#viewer.reopen(opened));
        this.#lost = false;
        this.#inFlight = 0;
        this.#changed();
        this.#emit("devicerestored", { adapter: this.#adapter });
        return;
      } catch (error) {
        last = error;
      }
    }
    if (this.#disposed) return;
    const message = `the device was lost and could not be replaced in ${REOPENINGS} attempts: ${last?.message}`;
    this.#emit("error", new PelageError("device", message));
  }
}

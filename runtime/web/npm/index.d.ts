/** Three numbers: a place in metres, a direction of any length, or linear red, green and blue. glTF's axes: +y is up, animals look along +z. */
export type Vec3 = readonly [number, number, number];

/**
 * Who is at fault:
 * - `no-webgpu`: the browser, or the page is not served over https or from localhost
 * - `no-adapter`: there is no graphics adapter, or it cannot hold the package
 * - `package`: the file; the message says section, offset, what was found and what was expected
 * - `asked`: an argument; the message says what was found and what was expected
 * - `fetch`: the network
 * - `superseded`: nobody; another `load` was called since
 * - `module`: the WebAssembly module could not be loaded
 * - `device`: driver or browser
 * - `internal`: this package
 */
export type PelageErrorKind =
  | "no-webgpu"
  | "no-adapter"
  | "package"
  | "asked"
  | "fetch"
  | "superseded"
  | "module"
  | "device"
  | "internal";

/** What every promise and method here fails with. */
export class PelageError extends Error {
  readonly kind: PelageErrorKind;
}

export interface PelageOptions {
  /** Whether mouse, touch, wheel and keys move the camera. Default true. */
  controls?: boolean;
  /** Whether frames are drawn by themselves when something changed. Without, call `frame()`. Default true. */
  loop?: boolean;
  /** Whether the canvas has as many pixels as the page shows of it. Without, its `width` and `height` count when `resize()` is called. Default true. */
  autoSize?: boolean;
  /** Pixels of the canvas in a CSS pixel. Default that of the screen, 2 at most. */
  pixelRatio?: number;
  /** A look as TOML. */
  look?: string;
  /** The WebAssembly module, for bundlers that move it. Default the file beside index.js. Counts for the first `create` of a page. */
  wasm?: string | URL | Request | Response | BufferSource | WebAssembly.Module;
}

export interface ClipInfo {
  readonly name: string;
  /** Seconds. */
  readonly durationS: number;
}

export interface PackageInfo {
  /** What messages call it: its URL or file name. */
  readonly name: string;
  /** File name of the model that was baked. */
  readonly model: string;
  /** Bytes of the package. */
  readonly bytes: number;
  /** Bytes of its textures and buffers on the graphics card. */
  readonly gpuBytes: number;
  /** Least and greatest corner of the bare model, metres. */
  readonly min: Vec3;
  readonly max: Vec3;
  /** Greatest height of the fur, metres. */
  readonly furHeightM: number;
  /** Whether `style` may be "ink". */
  readonly hasInk: boolean;
  /** Names of its morph targets. */
  readonly morphs: readonly string[];
  readonly clips: readonly ClipInfo[];
}

export interface Camera {
  /** Metres. */
  eye: Vec3;
  /** Metres; apart from `eye`. */
  target: Vec3;
  /** Height of the view, degrees, 1 to 170. */
  fovDeg: number;
}

export interface Orbit {
  /** Degrees about the vertical axis: 0 in front (+z), 90 at the model's left (+x). */
  azimuthDeg: number;
  /** Degrees above the horizon, -89 to 89. */
  elevationDeg: number;
  /** Metres from the target. */
  distanceM: number;
}

export interface Light {
  /** Towards a distant light, of any length. Takes the place of `position`. */
  towards?: Vec3;
  /** Place of a light nearby, metres. Takes the place of `towards`. */
  position?: Vec3;
  /** Linear, 1 is full light; 0 or more. */
  color?: Vec3;
}

export interface Playback {
  /** `null` at rest. */
  readonly clip: string | null;
  readonly durationS: number;
  readonly timeS: number;
  readonly speed: number;
  readonly playing: boolean;
}

export interface Stats {
  /** Frames drawn so far. */
  readonly frames: number;
  /** Milliseconds from the call to the last pixel of the last frame, without those that it waited for the frame before. */
  readonly frameMs: number;
  /** Of them those of the page's own thread. */
  readonly cpuMs: number;
  /** Names of the passes that ran. */
  readonly passes: readonly string[];
  /** Bytes on the graphics card of package, poses, shadow maps and textures between passes. */
  readonly gpuBytes: number;
  /** Buffers, textures, bind groups and pipelines made for the last frame: 0 where nothing is new. */
  readonly created: number;
  /** Bytes of numbers that the last frame sent to the graphics card. */
  readonly uploadedBytes: number;
  /** What the browser says of the adapter; may be empty. */
  readonly adapter: string;
  /** Pixels. */
  readonly width: number;
  readonly height: number;
}

export interface PelageEventMap {
  /** A package is shown. */
  load: CustomEvent<PackageInfo>;
  /** A frame is done. */
  frame: CustomEvent<Stats>;
  /** What went wrong outside of a call: in the loop, or on the device. */
  error: CustomEvent<PelageError>;
  /** The device is gone; another is asked for. */
  devicelost: CustomEvent<{ reason: string; message: string }>;
  /** There is another device, and all is as before. */
  devicerestored: CustomEvent<{ adapter: string }>;
}

/** A `.pelage` package on a `<canvas>`. Where a method fails, everything is as it was before the call. */
export class Pelage extends EventTarget {
  private constructor();

  /**
   * Opens a device for a canvas without another context.
   * Fails with `no-webgpu`, `no-adapter`, `module`, `device`, or `asked` for a wrong look.
   */
  static create(canvas: HTMLCanvasElement, options?: PelageOptions): Promise<Pelage>;

  /**
   * Shows a package, framed and at rest. Of several calls the last counts; the others fail with `superseded`.
   * Fails with `package`, `fetch`, `asked`, `no-adapter`, or the reason of `signal`.
   */
  load(
    source: string | URL | ArrayBuffer | ArrayBufferView | Blob,
    options?: { /** What messages call it. */ name?: string; signal?: AbortSignal },
  ): Promise<PackageInfo>;
  /** What is shown; `null` before the first package. */
  readonly info: PackageInfo | null;

  /** From where the model is seen. What an assignment leaves out stays. */
  get camera(): Camera;
  set camera(view: Partial<Camera>);
  /** The same about the target. */
  get orbit(): Orbit;
  set orbit(around: Partial<Orbit>);
  /** Turns the model with a hand that moved so many heights of the picture, right and up: half a turn for one. */
  orbitBy(right: number, up: number): void;
  /** Moves the model with the hand. */
  panBy(right: number, up: number): void;
  /** Goes `factor` times as near, keeping what is so many heights of the picture right of and above its middle. */
  zoomBy(factor: number, right?: number, up?: number): void;
  /** Frames the model as it is when it is loaded. */
  frameAll(): void;
  /** Goes back to where the model was framed. */
  resetCamera(): void;
  /** Whether mouse, touch, wheel and keys move the camera. */
  controls: boolean;

  /** The key light, which throws shadows. What is left out stays. */
  setLight(light: Light): void;
  /** Sets one key of the look, as `pelage render --look key=value`: bake/docs/look.md lists them. */
  setLook(key: string, value: string | number | boolean | readonly number[]): void;
  /** Light from all around as TOML: lights that `pelage sky` fitted to a panorama. It takes the place of ambient light; null ends it. A colour, or two, are
   *  `setLook("environment.sky", "1,1,1/0.2,0.2,0.2")`. */
  setEnvironment(toml: string | null): void;
  /** The look as TOML. What an assignment leaves out has its default; `picture.size` is that of the canvas. */
  look: string;
  /** `ink` needs a package with `info.hasInk`. */
  style: "fur" | "ink" | "bare";

  /** Of the package. */
  readonly clips: readonly ClipInfo[];
  readonly playback: Playback;
  /** Plays the clip of that name, or goes on with the one there is, or with the first. */
  play(name?: string): void;
  pause(): void;
  /** Shows the model without a clip. */
  rest(): void;
  /** Shows that moment of the clip, seconds; clips loop. */
  seek(timeS: number): void;
  /** Seconds of the clip in a second; below 0 it runs backwards. */
  speed: number;
  /** Holds the morph target of that name at a weight whatever the clip does; `null` leaves it to the clip again. */
  setMorph(name: string, weight: number | null): void;

  /** Draws now. */
  frame(): void;
  readonly stats: Stats;
  /** Settles when everything that was drawn so far is done. */
  idle(): Promise<void>;
  /** Takes the canvas's present size; the loop does it by itself with `autoSize`. */
  resize(): void;
  /** A picture of the canvas, drawn now. `type`: as `HTMLCanvasElement.toBlob` takes it, default "image/png". */
  screenshot(type?: string): Promise<Blob>;
  /** Frees the device and everything on it. Nothing but `dispose()` may be called afterwards. */
  dispose(): void;

  addEventListener<K extends keyof PelageEventMap>(
    type: K,
    listener: (this: Pelage, event: PelageEventMap[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject | null,
    options?: boolean | AddEventListenerOptions,
  ): void;
  removeEventListener<K extends keyof PelageEventMap>(
    type: K,
    listener: (this: Pelage, event: PelageEventMap[K]) => unknown,
    options?: boolean | EventListenerOptions,
  ): void;
  removeEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject | null,
    options?: boolean | EventListenerOptions,
  ): void;
}

/** A frame of another renderer that a package is drawn into. */
export interface PassFrame {
  /** What it drew so far: textures of `device` of one size, of one sample per pixel, that may be drawn to. */
  color: GPUTexture;
  depth: GPUTexture;
  /** World to view space, view to clip space with WebGPU's depth of 0 to 1, and model to world space: 16 numbers each, by columns. */
  viewFromWorld: ArrayLike<number>;
  clipFromView: ArrayLike<number>;
  worldFromModel?: ArrayLike<number>;
  /** Name of a clip; at rest without. */
  clip?: string;
  /** Moment of the clip, seconds. */
  timeS?: number;
  /** The moment by a clock that goes on, seconds: hair on guides swings from one draw to the next. Without, it stays as it was groomed. */
  clockS?: number;
}

/**
 * A package in the frame of another renderer that draws on the same device, such as three.js's `WebGPURenderer`: fur and its meshes hide each other, and
 * nothing is copied. examples/three in the repository is a page of it.
 */
export class PelagePass {
  private constructor();

  /**
   * Opens a device; hand it to the other renderer.
   * `color` and `depth`: formats of its targets, such as "rgba16float" and "depth32float". `reversedDepth`: near is 1. Default false.
   * Fails as `Pelage.create` does.
   */
  static open(options: {
    color: GPUTextureFormat;
    depth: "depth32float" | "depth24plus";
    reversedDepth?: boolean;
    wasm?: PelageOptions["wasm"];
  }): Promise<PelagePass>;
  /** The device that both draw on. */
  readonly device: GPUDevice;
  /** Draws this package from now on. Fails as `Pelage.load` does. */
  load(
    source: string | URL | ArrayBuffer | ArrayBufferView | Blob,
    options?: { name?: string; signal?: AbortSignal },
  ): Promise<PackageInfo>;
  /** What is drawn; `null` before the first package. */
  readonly info: PackageInfo | null;
  /** The key light. What is left out stays. */
  setLight(light: Light): void;
  /** Sets one key of the look, of its tables light, shadow and fur. */
  setLook(key: string, value: string | number | boolean | readonly number[]): void;
  /** Light from all around as TOML: lights that `pelage sky` fitted to a panorama. It takes the place of ambient light; null ends it. A colour, or two, are
   *  `setLook("environment.sky", "1,1,1/0.2,0.2,0.2")`. */
  setEnvironment(toml: string | null): void;
  /** Draws over what is there; what the other renderer draws behind it must be submitted before, what it draws before it after. */
  draw(frame: PassFrame): void;
  /** Frees what it holds on the device; the device stays. */
  dispose(): void;
}

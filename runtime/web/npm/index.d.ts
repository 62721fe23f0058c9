/**
 * Three numbers: a position in metres, a direction of any length, or linear red, green and blue.
 * The axes are those of glTF: +y is up, and animals look along +z.
 */
export type Vec3 = readonly [number, number, number];

/**
 * Cause of an error:
 * - `no-webgpu`: the browser has no WebGPU, or the page is not served over https or from localhost
 * - `no-adapter`: the browser offers no graphics adapter, or it cannot hold the package
 * - `package`: the file is invalid; the message gives section, offset, and the values found and expected
 * - `asked`: an argument is invalid; the message gives the values found and expected
 * - `fetch`: the network failed
 * - `superseded`: not a fault; `load` or `dispose` was called in the meantime
 * - `module`: the WebAssembly module could not be loaded, or is of another build than the scripts
 * - `device`: the driver or the browser failed
 * - `internal`: a bug in this package
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

/** Error of every promise and method of this package. */
export class PelageError extends Error {
  readonly kind: PelageErrorKind;
}

export interface PelageOptions {
  /** Whether mouse, touch, wheel and keys move the camera. Default: true. */
  controls?: boolean;
  /** Whether frames are drawn automatically after changes. If false, call `frame()`. Default: true. */
  loop?: boolean;
  /**
   * Whether the canvas's resolution follows its size on the page. If false, `resize()` reads its `width` and `height`.
   * Default: true.
   */
  autoSize?: boolean;
  /** Canvas pixels per CSS pixel. Default: that of the screen, at most 2. */
  pixelRatio?: number;
  /** Look, as TOML. */
  look?: string;
  /**
   * The WebAssembly module or its URL; required with most bundlers, and the README has the lines for them.
   * Default: pelage_web_bg.wasm beside index.js. Only the first `create` or `open` of a page uses it.
   */
  wasm?: string | URL | Request | Response | BufferSource | WebAssembly.Module;
  /**
   * Ends this Pelage when it is aborted. While `create` is pending, it fails with the signal's reason, and the canvas
   * is free at once; later, the signal calls `dispose()`.
   */
  signal?: AbortSignal;
}

export interface ClipInfo {
  readonly name: string;
  /** Duration, seconds. */
  readonly durationS: number;
}

export interface PackageInfo {
  /** Name used in messages: the URL or file name. */
  readonly name: string;
  /** File name of the baked model. */
  readonly model: string;
  /** Size of the package, bytes. */
  readonly bytes: number;
  /** GPU memory of its textures and buffers, bytes. */
  readonly gpuBytes: number;
  /** Minimum corner of the bare model, metres. */
  readonly min: Vec3;
  /** Maximum corner of the bare model, metres. */
  readonly max: Vec3;
  /** Maximum height of the fur, metres. */
  readonly furHeightM: number;
  /** Whether `style` may be "ink". */
  readonly hasInk: boolean;
  /** Names of the morph targets. */
  readonly morphs: readonly string[];
  readonly clips: readonly ClipInfo[];
}

export interface Camera {
  /** Position of the camera, metres. */
  eye: Vec3;
  /** Point in the centre of the view, metres; must differ from `eye`. */
  target: Vec3;
  /** Vertical field of view, degrees, 1 to 170. */
  fovDeg: number;
}

export interface Orbit {
  /** Angle about the vertical axis, degrees: 0 in front (+z), 90 at the model's left (+x). */
  azimuthDeg: number;
  /** Angle above the horizon, degrees, -89 to 89. */
  elevationDeg: number;
  /** Distance from the target, metres. */
  distanceM: number;
}

export interface Light {
  /** Direction towards a distant light, of any length. Replaces `position`. */
  towards?: Vec3;
  /** Position of a nearby light, metres. Replaces `towards`. */
  position?: Vec3;
  /** Linear red, green and blue, 0 or more; 1 is full light. */
  color?: Vec3;
}

export interface Playback {
  /** Name of the clip; `null` at rest. */
  readonly clip: string | null;
  readonly durationS: number;
  readonly timeS: number;
  readonly speed: number;
  readonly playing: boolean;
}

export interface Stats {
  /** Number of frames drawn so far. */
  readonly frames: number;
  /**
   * Time from the call to the last pixel of the last frame, milliseconds. Excludes the time spent waiting for the
   * previous frame.
   */
  readonly frameMs: number;
  /** Time that the last frame took on the page's thread, milliseconds. */
  readonly cpuMs: number;
  /** Names of the passes that ran. */
  readonly passes: readonly string[];
  /** GPU memory of package, poses, shadow maps and textures between passes, bytes. */
  readonly gpuBytes: number;
  /** Number of buffers, textures, bind groups and pipelines created for the last frame; 0 if all were reused. */
  readonly created: number;
  /** Data uploaded to the GPU for the last frame, bytes. */
  readonly uploadedBytes: number;
  /** Description of the adapter by the browser; may be empty. */
  readonly adapter: string;
  /** Width of the picture, pixels. */
  readonly width: number;
  /** Height of the picture, pixels. */
  readonly height: number;
}

export interface PelageEventMap {
  /** A package has been loaded and is shown. */
  load: CustomEvent<PackageInfo>;
  /** A frame is complete. */
  frame: CustomEvent<Stats>;
  /** An error outside a call: in the loop, or on the device. */
  error: CustomEvent<PelageError>;
  /** The device is lost; a new one has been requested. */
  devicelost: CustomEvent<{ reason: string; message: string }>;
  /** A new device is in use, and the state is restored. */
  devicerestored: CustomEvent<{ adapter: string }>;
}

/** A `.pelage` package on a `<canvas>`. A method that fails changes nothing. */
export class Pelage extends EventTarget {
  private constructor();

  /**
   * Opens a device for a canvas that has no other context and no other Pelage; `dispose()` makes a canvas available
   * again. Resolves before anything is visible.
   * Fails with `no-webgpu`, `no-adapter`, `module`, `device`, with `asked` for an invalid look or a canvas in use, or
   * with the reason of `signal`.
   */
  static create(canvas: HTMLCanvasElement, options?: PelageOptions): Promise<Pelage>;

  /**
   * Shows a package at rest, framed by the camera. Resolves when the package is loaded; it is visible when a following
   * `idle()` resolves. The last of several calls wins; the others fail with `superseded`.
   * Fails with `package`, `fetch`, `asked`, `no-adapter`, or with the reason of `signal`.
   */
  load(
    source: string | URL | ArrayBuffer | ArrayBufferView | Blob,
    options?: { /** Name used in messages. */ name?: string; signal?: AbortSignal },
  ): Promise<PackageInfo>;
  /** The package shown; `null` before the first one. */
  readonly info: PackageInfo | null;

  /** The camera. An assignment leaves omitted values unchanged. */
  get camera(): Camera;
  set camera(view: Partial<Camera>);
  /** The camera's position relative to the target. An assignment leaves omitted values unchanged. */
  get orbit(): Orbit;
  set orbit(around: Partial<Orbit>);
  /** Turns the model like a drag by `right` and `up`, in heights of the picture; 1 is half a turn. */
  orbitBy(right: number, up: number): void;
  /** Moves the model like a drag by `right` and `up`, in heights of the picture. */
  panBy(right: number, up: number): void;
  /**
   * Divides the distance by `factor`. The point at `right` and `up` keeps its place in the picture; both are in heights
   * of the picture, from its centre.
   */
  zoomBy(factor: number, right?: number, up?: number): void;
  /** Frames the model as when it is loaded. */
  frameAll(): void;
  /** Moves the camera back to where the model was framed last. */
  resetCamera(): void;
  /** Whether mouse, touch, wheel and keys move the camera. */
  controls: boolean;

  /** Sets the key light, which casts shadows. Omitted values stay unchanged. */
  setLight(light: Light): void;
  /** Sets one key of the look, like `pelage render --look key=value`; bake/docs/look.md lists the keys. */
  setLook(key: string, value: string | number | boolean | readonly number[]): void;
  /**
   * Sets the environment light, as TOML: lights that `pelage sky` fitted to an environment map. It replaces ambient
   * light; `null` removes it. To use one or two colours, call `setLook("environment.sky", "1,1,1/0.2,0.2,0.2")`
   * instead.
   */
  setEnvironment(toml: string | null): void;
  /**
   * Sets the seal on ink paintings; `null` removes it. White and transparent parts of the image leave the painting as
   * it was. `place`: its centre, across and down from the upper left corner, and its height, as shares of the picture's
   * width, height and height; default 0.9, 0.88, 0.1.
   */
  setSeal(image: ImageData | null, place?: readonly [number, number, number]): void;
  /** The look, as TOML. An assignment sets omitted keys to their defaults; `picture.size` is the size of the canvas. */
  look: string;
  /** Drawing style; `ink` requires a package with `info.hasInk`. */
  style: "fur" | "ink" | "bare";
  /** Names of the styles of ink painting, `default` first; bake/docs/painting.md shows them. */
  readonly inkStyles: readonly string[];
  /**
   * Style of ink painting; `null` if the look's knobs of ink are no style's. An assignment also sets `style` to `ink`,
   * and the knobs in the tables `ink` and `brush` of the look to those of the style.
   */
  get inkStyle(): string | null;
  set inkStyle(name: string);

  /** Clips of the package. */
  readonly clips: readonly ClipInfo[];
  readonly playback: Playback;
  /**
   * Plays a clip; the current clip continues. Without a name, resumes the current clip. At rest, plays the first of
   * `clips`, in the order of the model's file, whatever it shows; does nothing if there is none.
   * `name`: a name in `clips`, or the part after its last `|` or `:`, in any case, if only one clip ends in it. "walk"
   * finds "Armature|Walk".
   * Fails with `asked` and the names of all clips if none matches.
   */
  play(name?: string): void;
  pause(): void;
  /** Shows the model without a clip. */
  rest(): void;
  /** Moves to a time in the clip, seconds; clips loop. */
  seek(timeS: number): void;
  /** Playback speed, in clip seconds per second; negative values play backwards. */
  speed: number;
  /** Fixes the weight of a morph target, regardless of the clip; `null` returns it to the clip. */
  setMorph(name: string, weight: number | null): void;

  /** Draws a frame now. */
  frame(): void;
  readonly stats: Stats;
  /**
   * Resolves when the canvas shows all changes so far; `await pelage.load(url); await pelage.idle();` waits until an
   * animal is visible. With `loop: false`, call `frame()` first.
   */
  idle(): Promise<void>;
  /** Adopts the current size of the canvas; automatic with `autoSize`. */
  resize(): void;
  /** Draws a frame and returns it as an image file. `type`: as in `HTMLCanvasElement.toBlob`; default: "image/png". */
  screenshot(type?: string): Promise<Blob>;
  /** Frees the device and all its resources. Afterwards, only `dispose()` may be called. */
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

/** A frame of another renderer, into which a package is drawn. */
export interface PassFrame {
  /**
   * Colour drawn so far. `color` and `depth` are textures of `device` of the same size, with one sample per pixel and
   * usage as render attachments.
   */
  color: GPUTexture;
  /** Depth drawn so far. */
  depth: GPUTexture;
  /** Matrix from world to view space. All matrices are 16 numbers in column-major order. */
  viewFromWorld: ArrayLike<number>;
  /** Matrix from view to clip space, with WebGPU's depth of 0 to 1. */
  clipFromView: ArrayLike<number>;
  /** Matrix from model to world space. Default: the identity. */
  worldFromModel?: ArrayLike<number>;
  /** Name of the clip, as in `info.clips`; if omitted, the model is at rest. */
  clip?: string;
  /** Time in the clip, seconds. */
  timeS?: number;
  /**
   * Time of a continuous clock, seconds, which moves guided hair from one draw to the next. If omitted, guided hair
   * stays as groomed.
   */
  clockS?: number;
}

/**
 * Draws a package into the frame of another renderer on the same device, such as three.js's `WebGPURenderer`. Fur and
 * the meshes of that renderer occlude each other, and nothing is copied. examples/three in the repository is an
 * example.
 */
export class PelagePass {
  private constructor();

  /**
   * Opens a device, to be passed to the other renderer.
   * `color` and `depth`: formats of that renderer's targets, such as "rgba16float" and "depth32float".
   * `reversedDepth`: whether a depth of 1 is near; default: false.
   * Fails like `Pelage.create`.
   */
  static open(options: {
    color: GPUTextureFormat;
    depth: "depth32float" | "depth24plus";
    reversedDepth?: boolean;
    wasm?: PelageOptions["wasm"];
  }): Promise<PelagePass>;
  /** The device shared by both renderers. */
  readonly device: GPUDevice;
  /** Loads the package to draw from now on. Fails like `Pelage.load`. */
  load(
    source: string | URL | ArrayBuffer | ArrayBufferView | Blob,
    options?: { name?: string; signal?: AbortSignal },
  ): Promise<PackageInfo>;
  /** The package drawn; `null` before the first one. */
  readonly info: PackageInfo | null;
  /** Sets the key light. Omitted values stay unchanged. */
  setLight(light: Light): void;
  /** Sets one key of the look, in one of its tables light, shadow and fur. */
  setLook(key: string, value: string | number | boolean | readonly number[]): void;
  /**
   * Sets the environment light, as TOML: lights that `pelage sky` fitted to an environment map. It replaces ambient
   * light; `null` removes it. To use one or two colours, call `setLook("environment.sky", "1,1,1/0.2,0.2,0.2")`
   * instead.
   */
  setEnvironment(toml: string | null): void;
  /**
   * Draws over the current contents of the frame. The other renderer must submit what is behind the package before this
   * call, and what it draws over the package after it.
   */
  draw(frame: PassFrame): void;
  /** Frees the resources of this object; the device stays open. */
  dispose(): void;
}

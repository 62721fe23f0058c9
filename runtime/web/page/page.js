// Controls of the page around the canvas. Everything else is in the npm package.

import { Pelage, PelageError } from "./pelage/index.js";

const element = (id) => document.getElementById(id);
const canvas = element("stage");
const [play, clip, time, clock] = ["play", "clip", "time", "clock"].map(element);
const [light, color, numbers, caption] = ["light", "color", "numbers", "caption"].map(element);
const brush = element("brush");

/** Angle between the camera and a light at the rim of the light's pad, radians; 0 at the centre of the pad. */
const PAD_REACH = 2.6;
/** Initial position of the key light on the pad: right and up. */
const PAD_START = [-0.28, 0.24];

let pelage = null;
let animals = [];
let loading = 0;

// Messages.

function showMessage(title, text, { fatal = false } = {}) {
  const message = element("message");
  message.querySelector("h2").textContent = title;
  message.querySelector("p").textContent = text;
  message.classList.toggle("fatal", fatal);
  message.hidden = false;
}

function dismiss() {
  element("message").hidden = true;
}

element("message").querySelector("button").addEventListener("click", dismiss);

/** Titles of error messages, by kind. */
const TITLES = {
  "no-webgpu": "This needs WebGPU",
  "no-adapter": "No suitable graphics adapter",
  package: "This file cannot be drawn",
  asked: "That cannot be drawn",
  fetch: "The package could not be downloaded",
  module: "The program could not be loaded",
  device: "The graphics device failed",
  internal: "Internal error; please report it",
};

function fail(error, options) {
  const kind = error instanceof PelageError ? error.kind : "internal";
  if (kind === "superseded") return;
  showMessage(TITLES[kind] ?? TITLES.internal, error.message, options);
}

/** Applies the change of a control, and shows an error if that fails. Returns whether it succeeded. */
function attempt(change) {
  try {
    change();
    return true;
  } catch (error) {
    fail(error);
    return false;
  }
}

// Packages.

async function show(source, title, options = {}) {
  const turn = ++loading;
  const busy = element("busy");
  busy.textContent = `Loading ${title}`;
  busy.hidden = false;
  try {
    // A package without ink can still be shown as fur.
    const style = pelage.style;
    const info = await pelage.load(source, options).catch((error) => {
      if (style !== "ink" || error.kind !== "asked") throw error;
      setStyle("fur");
      return pelage.load(source, options);
    });
    dismiss();
    describe(info, title);
    return true;
  } catch (error) {
    fail(error);
    return false;
  } finally {
    if (turn === loading) busy.hidden = true;
  }
}

function describe(info, title) {
  caption.textContent = `${title} · ${(info.bytes / 1e6).toFixed(1)} MB`;
  document.title = `${title} · pelage`;
  element("style").querySelector("[value=ink]").disabled = !info.hasInk;
  for (const button of element("animals").children) {
    button.setAttribute("aria-current", String(button.textContent === title));
  }
  const clips = info.clips.map(({ name }) => new Option(name.split("|").pop(), name));
  clip.replaceChildren(new Option("At rest", ""), ...clips);
  for (const knob of [play, clip, time]) knob.disabled = info.clips.length === 0;
  updateClipControls();
}

async function openAnimal(animal) {
  await show(new URL(animal.file, document.baseURI), animal.name);
}

function openFile(file) {
  return show(file, file.name.replace(/\.pelage$/i, ""));
}

element("file").addEventListener("change", (event) => {
  const [file] = event.target.files;
  event.target.value = "";
  if (file && pelage) openFile(file);
});

// Files may be dropped anywhere. Counts nested drag events, because leaving a child is not leaving the page.
let over = 0;
addEventListener("dragenter", (event) => {
  event.preventDefault();
  over += 1;
  element("drop").hidden = !event.dataTransfer?.types.includes("Files");
});
addEventListener("dragleave", () => {
  over = Math.max(over - 1, 0);
  element("drop").hidden = over === 0;
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  over = 0;
  element("drop").hidden = true;
  const [file] = event.dataTransfer?.files ?? [];
  if (file && pelage) openFile(file);
});

// Style.

function setStyle(style) {
  if (!attempt(() => (pelage.style = style))) style = pelage.style;
  element("style").querySelector(`[value=${style}]`).checked = true;
  document.body.classList.toggle("on-paper", style === "ink");
  brush.hidden = style !== "ink";
  if (!brush.hidden) updateBrush();
}

element("style").addEventListener("change", (event) => setStyle(event.target.value));

// Brush of the style ink.

const inkStyle = element("ink-style");

/** Updates the controls of the brush to the look. */
function updateBrush() {
  const { inkStyle: now, inkStyles } = pelage;
  // Knobs that are no style's are shown as "own".
  const names = now === null ? ["own", ...inkStyles] : inkStyles;
  inkStyle.replaceChildren(...names.map((name) => new Option(name, name)));
  inkStyle.value = now ?? "own";
  const table = /^\[brush\]\n([^[]*)/m.exec(pelage.look)[1];
  for (const knob of brush.querySelectorAll("input")) {
    knob.value = new RegExp(`^${knob.name} = (.+)$`, "m").exec(table)[1];
  }
}

inkStyle.addEventListener("change", () => {
  if (inkStyle.value !== "own") attempt(() => (pelage.inkStyle = inkStyle.value));
  updateBrush();
});
brush.addEventListener("input", ({ target }) => {
  if (target === inkStyle) return;
  attempt(() => pelage.setLook(`brush.${target.name}`, Number(target.value)));
  updateBrush();
});

// Clips.

/** Updates the controls to the state of the clip. */
function updateClipControls() {
  const { clip: name, durationS, timeS, playing } = pelage.playback;
  if (clip.value !== (name ?? "")) clip.value = name ?? "";
  play.setAttribute("aria-pressed", String(playing));
  play.setAttribute("aria-label", playing ? "Pause" : "Play");
  time.max = String(durationS || 1);
  time.value = String(timeS);
  clock.textContent = `${timeS.toFixed(2)} s`;
}

play.addEventListener("click", () => {
  attempt(() => (pelage.playback.playing ? pelage.pause() : pelage.play()));
  updateClipControls();
});
clip.addEventListener("change", () => {
  attempt(() => (clip.value ? pelage.play(clip.value) : pelage.rest()));
  updateClipControls();
});
time.addEventListener("input", () => {
  attempt(() => {
    if (!pelage.playback.clip) pelage.play();
    pelage.pause();
    pelage.seek(Number(time.value));
  });
  updateClipControls();
});

// Light: a pad. At its centre the light is at the camera, at its rim behind the animal.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (v) => v.map((x) => x / Math.max(Math.hypot(...v), 1e-9));
let pad = PAD_START;

/** Returns the direction in the world for a position on the pad and the current camera. */
function towards([right, up]) {
  const { eye, target } = pelage.camera;
  const back = unit(eye.map((x, i) => x - target[i]));
  const side = unit(cross([0, 1, 0], back));
  const top = cross(back, side);
  const radius = Math.min(Math.hypot(right, up), 1);
  const [along, across] = [Math.cos(radius * PAD_REACH), Math.sin(radius * PAD_REACH) / Math.max(radius, 1e-6)];
  return back.map((_, i) => back[i] * along + (side[i] * right + top[i] * up) * across);
}

function placeDot() {
  light.style.setProperty("--x", `${50 + 42 * pad[0]}%`);
  light.style.setProperty("--y", `${50 - 42 * pad[1]}%`);
  light.setAttribute("aria-valuetext", `${Math.round(pad[0] * 100)} right, ${Math.round(pad[1] * 100)} up`);
}

function turnLight(right, up) {
  const length = Math.max(Math.hypot(right, up), 1);
  pad = [right / length, up / length];
  placeDot();
  attempt(() => pelage.setLight({ towards: towards(pad) }));
}

function lightAt(event) {
  const box = light.getBoundingClientRect();
  turnLight((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
}

light.addEventListener("pointerdown", (event) => {
  light.setPointerCapture(event.pointerId);
  lightAt(event);
});
light.addEventListener("pointermove", (event) => {
  if (event.buttons & 1) lightAt(event);
});
light.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
  if (!step) return;
  event.preventDefault();
  turnLight(pad[0] + step[0], pad[1] + step[1]);
});
color.addEventListener("input", () => {
  // The picker's colour is sRGB; light is linear.
  const linear = (byte) => (byte <= 10 ? byte / 255 / 12.92 : ((byte / 255 + 0.055) / 1.055) ** 2.4);
  const bytes = [1, 3, 5].map((at) => parseInt(color.value.slice(at, at + 2), 16));
  attempt(() => pelage.setLight({ color: bytes.map(linear) }));
});

// Camera and picture.

element("home").addEventListener("click", () => attempt(() => pelage.frameAll()));
element("save").addEventListener("click", async () => {
  try {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await pelage.screenshot());
    link.download = `${caption.textContent.split(" · ")[0] || "pelage"}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
  } catch (error) {
    fail(error);
  }
});

// Startup.

/** Returns the animals of this server. It is valid to have none. */
async function list() {
  const response = await fetch("animals/animals.json").catch(() => null);
  return response?.ok ? response.json() : [];
}

async function begin() {
  try {
    pelage = await Pelage.create(canvas);
  } catch (error) {
    fail(error, { fatal: true });
    return;
  }
  // For the console and the tests.
  window.pelage = pelage;
  // The controls work from now on.
  for (const knobs of document.querySelectorAll("[inert]")) knobs.inert = false;
  placeDot();
  pelage.addEventListener("frame", ({ detail }) => {
    const { frameMs, width, height, gpuBytes } = detail;
    numbers.textContent = `${frameMs.toFixed(1)} ms · ${width} × ${height} · ${(gpuBytes / 1e6).toFixed(0)} MB`;
    if (pelage.playback.playing) updateClipControls();
  });
  pelage.addEventListener("error", ({ detail }) => fail(detail));
  pelage.addEventListener("devicelost", () => showMessage("The graphics device was lost", "Requesting a new one…"));
  pelage.addEventListener("devicerestored", dismiss);
  animals = await list();
  element("animals").replaceChildren(
    ...animals.map((animal) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = animal.name;
      button.title = animal.credit ?? "";
      button.addEventListener("click", () => openAnimal(animal));
      return button;
    }),
  );
  const asked = new URLSearchParams(location.search).get("animal");
  const first = animals.find((animal) => animal.name === asked) ?? animals[0];
  if (first) await openAnimal(first);
  else showMessage("No animal here yet", "Drop a .pelage package onto this page, or open one with the button above.");
}

begin();

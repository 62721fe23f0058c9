// Tests of the npm package's API on a canvas: images, memory, devices.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before } from "node:test";
import { inBrowser, LONG_MS } from "./needs.mjs";
import { found } from "./browser.mjs";
import { assertOther, assertSame, bare, bytesOf, colorAt, isFur, open, OUT } from "./stage.mjs";
import { page, picture, rendered, SITE } from "./stage.mjs";

const SIZE = [320, 240];
/** Image of a seal. */
const SEAL = join(import.meta.dirname, "../../../assets/seals/fur.png");
/** A cheap look whose shadow maps are redrawn for every pose. */
const SMALL = "[picture]\nsamples = 1\n[shadow]\nmap_texels = 64\n";
let opened;

before(async () => {
  if (found()) opened = await open();
});
after(() => opened?.close());

inBrowser("canvas_matches_render", async () => {
  const { page, faults, close } = await bare(opened, { size: SIZE });
  const fur = await picture(page, "canvas_fur");
  assertSame(fur, rendered("render_fur", SIZE));
  await page.evaluate(() => (pelage.style = "ink"));
  const ink = await picture(page, "canvas_ink");
  assertSame(ink, rendered("render_ink", SIZE, "--style", "ink"));
  assertOther(fur, ink);

  const view = { eye: [-0.6, 0.5, 0.8], target: [0, 0.25, 0], fovDeg: 24 };
  await page.evaluate((view) => {
    pelage.style = "fur";
    pelage.camera = view;
    pelage.setLight({ towards: [1, 0.6, 0.2] });
    pelage.setLook("picture.background", "204,209,217");
    pelage.play("Walk");
    pelage.pause();
    pelage.seek(0.3);
  }, view);
  const camera = `--camera=${view.eye}/${view.target}/${view.fovDeg}`;
  const args = [camera, "--light", "1,0.6,0.2", "--background", "204,209,217", "--clip", "Walk", "--time", "0.3"];
  assertSame(await picture(page, "canvas_walk"), rendered("render_walk", SIZE, ...args));
  await page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    [canvas.width, canvas.height] = [150, 200];
    pelage.resize();
    pelage.camera = { fovDeg: 48 };
  });
  const wider = args.map((arg) => (arg === camera ? `--camera=${view.eye}/${view.target}/48` : arg));
  assertSame(await picture(page, "canvas_tall"), rendered("render_tall", [150, 200], ...wider));
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("page_accepts_the_environment_files_of_render", async () => {
  const { page, faults, close } = await bare(opened, { size: SIZE });
  const keyed = await picture(page, "sky_none");
  const sky = `even = [0.1, 0.12, 0.15]
[sun]
towards = [0.6, 0.5, 0.6]
color = [0.5, 0.45, 0.3]
[[lobe]]
towards = [-1.0, 0.4, 0.3]
width_deg = 25.0
radiance = [0.4, 0.8, 1.6]
`;
  writeFileSync(`${OUT}/sky.toml`, sky);
  await page.evaluate((sky) => pelage.setEnvironment(sky), sky);
  const lit = await picture(page, "sky_page");
  assertSame(lit, rendered("sky_render", SIZE, "--environment", `${OUT}/sky.toml`));
  assertOther(lit, keyed);
  // An invalid environment is reported, and the light stays.
  const said = await page.evaluate(() => {
    try {
      pelage.setEnvironment("even = [1.0, 1.0, 1.0]\n[[lobe]]\nwide = 3.0\n");
    } catch (error) {
      return error.message;
    }
  });
  assert.match(said, /wide/);
  assertSame(lit, await picture(page, "sky_still"));
  await page.evaluate(() => pelage.setEnvironment(null));
  assertSame(keyed, await picture(page, "sky_ended"));
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("page_stamps_the_seal_of_render", async () => {
  const { page, faults, close } = await bare(opened, { size: SIZE });
  await page.evaluate(() => (pelage.style = "ink"));
  const plain = await picture(page, "seal_none");
  await page.evaluate(async (base64) => {
    const response = await fetch(`data:image/png;base64,${base64}`);
    const bitmap = await createImageBitmap(await response.blob());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    pelage.setSeal(context.getImageData(0, 0, bitmap.width, bitmap.height), [0.2, 0.3, 0.25]);
  }, readFileSync(SEAL).toString("base64"));
  const stamped = await picture(page, "seal_page");
  assertSame(stamped, rendered("seal_render", SIZE, "--style", "ink", "--ink-seal", `${SEAL}:0.2,0.3,0.25`));
  assertOther(stamped, plain);
  // A page cannot read files, and says what to do.
  const said = await page.evaluate(() => {
    try {
      pelage.setLook("ink.seal", "other.png");
    } catch (error) {
      return error.message;
    }
  });
  assert.match(said, /setSeal/);
  await page.evaluate(() => pelage.setSeal(null));
  assertSame(plain, await picture(page, "seal_ended"));
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("module_of_another_kind_or_build_is_reported", async () => {
  const { page: shown, faults, close } = await page(opened, { path: "/blank" });
  const create = (wasm) =>
    shown.evaluate(async (wasm) => {
      const { Pelage } = await import("/pelage/index.js");
      const canvas = document.querySelector("canvas") ?? document.body.appendChild(document.createElement("canvas"));
      return Pelage.create(canvas, { wasm }).then(() => "created", ({ kind, message }) => `${kind}: ${message}`);
    }, wasm);
  const html = /^module: .*\/blank: found text\/html, expected application\/wasm; .*\{ wasm \}/;
  assert.match(await create("/blank"), html);
  assert.match(await create("/none.wasm"), /^module: .*\/none\.wasm: found status 404, .*\{ wasm \}/);
  assert.match(await create("http://127.0.0.1:1/"), /^module: .*http:\/\/127\.0\.0\.1:1\//);
  const module = readFileSync(`${SITE}/pelage/pelage_web_bg.wasm`);
  const [, build] = /pelage_build(.*)$/.exec(module.subarray(-60).toString("latin1"));
  const other = Buffer.from(module);
  other.write("f".repeat(8), module.length - 8);
  await shown.route("**/other.wasm", (route) => route.fulfill({ body: other, contentType: "application/wasm" }));
  const builds = new RegExp(`^module: .*found build ${build.slice(0, -8)}ffffffff, expected ${build}, .*caches`);
  assert.match(await create("/other.wasm"), builds);
  assert.equal(await create("/pelage/pelage_web_bg.wasm"), "created", "a failure leaves canvas and package usable");
  assert.deepEqual(faults.filter((fault) => !/ERR_/.test(fault)), []);
  await close();
});

inBrowser("canvas_without_css_keeps_its_size_on_the_page", async () => {
  const { page, faults, close } = await bare(opened, { size: [64, 48], ratio: 2, options: { autoSize: true } });
  const lengths = () => {
    const { clientWidth, clientHeight, width, height } = document.querySelector("canvas");
    return [clientWidth, clientHeight, width, height];
  };
  // Observers of the size run before the next frame.
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  assert.deepEqual(await page.evaluate(lengths), [64, 48, 128, 96]);
  // CSS of the page continues to apply, and the canvas keeps its aspect ratio.
  await page.evaluate(() => (document.querySelector("canvas").style.width = "80px"));
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  assert.deepEqual(await page.evaluate(lengths), [80, 60, 160, 120]);
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("a_canvas_has_one_visible_pelage", async () => {
  // Without the loop's frames, only `idle()` draws.
  const before = () => (window.requestAnimationFrame = () => 1);
  const { page, faults, close } = await bare(opened, { size: [64, 48], before, options: { loop: true } });
  await page.evaluate(() => pelage.idle());
  const visible = await page.locator("canvas").screenshot();
  const color = await colorAt(page, visible, 32, 24);
  assert.ok(isFur(color), `${color} is not fur`);

  // The end of a clip's name finds it, and the current clip continues.
  const clip = await page.evaluate(() => {
    pelage.play("Walk");
    pelage.seek(0.25);
    pelage.play("wALK");
    const { playback } = pelage;
    pelage.rest();
    return playback;
  });
  assert.deepEqual([clip.clip, clip.timeS, clip.playing], ["Walk", 0.25, true]);

  const said = await page.evaluate(async () => {
    const { Pelage } = await import("/pelage/index.js");
    const said = async (...args) => Pelage.create(...args).then(() => "created", ({ message }) => message);
    return [await said(document.querySelector("canvas")), await said(null), await said(document.body)];
  });
  assert.match(said[0], /in use.*dispose\(\)/);
  assert.match(said[1], /found null, expected a <canvas>/);
  assert.match(said[2], /found body, expected a <canvas>/);
  assert.deepEqual(await page.locator("canvas").screenshot(), visible);

  // A disposed Pelage and a failed attempt release the canvas.
  const again = await page.evaluate(async () => {
    const { Pelage } = await import("/pelage/index.js");
    const create = (look) => Pelage.create(document.querySelector("canvas"), { autoSize: false, look });
    pelage.dispose();
    const failed = await create("[nothing]").catch(({ kind }) => kind);
    const created = await create();
    const { info } = created;
    created.dispose();
    // React's StrictMode mounts a component twice: the first attempt is aborted while it is pending.
    const first = new AbortController();
    const second = new AbortController();
    const attempt = ({ signal }) => Pelage.create(document.querySelector("canvas"), { autoSize: false, signal });
    const aborted = attempt(first).catch(({ name }) => name);
    first.abort();
    const mounted = await attempt(second);
    const inUse = await create().catch(({ kind }) => kind);
    second.abort();
    const disposed = (() => {
      try {
        return mounted.frame();
      } catch (error) {
        return error.message;
      }
    })();
    return [failed, info, await aborted, inUse, disposed, (await create()).info];
  });
  const [failed, info, aborted, inUse, disposed, last] = again;
  assert.deepEqual([failed, info, aborted, inUse, last], ["asked", null, "AbortError", "asked", null]);
  assert.match(disposed, /disposed/);
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("invalid_settings_are_reported_and_change_nothing", async () => {
  const { page, faults, close } = await bare(opened, { size: [64, 48] });
  const before = await picture(page, "before_faults");
  const said = await page.evaluate(async () => {
    const said = [];
    const wrong = [
      () => pelage.setLook("shadow.penumbra", 99),
      () => pelage.setLook("shadow.penumbr", 0.1),
      () => (pelage.look = "[picture]\nstyle = \"oil\"\n"),
      () => (pelage.camera = { eye: [0, 0, 0], target: [0, 0, 0] }),
      () => (pelage.camera = { fovDeg: NaN }),
      () => pelage.play("Fly"),
      () => pelage.setLight({ color: [1, -1, 0] }),
      () => pelage.load("/nowhere.pelage"),
      () => pelage.load(42),
      async () => {
        const { Pelage } = await import("/pelage/index.js");
        const taken = document.createElement("canvas");
        taken.getContext("2d");
        await Pelage.create(taken);
      },
    ];
    for (const call of wrong) {
      try {
        await call();
        said.push(["nothing"]);
      } catch (error) {
        said.push([error.name, error.kind, error.message]);
      }
    }
    return said;
  });
  const words = [
    ...[/0.*2|range/, /penumbra/, /style.*fur/s, /same point/, /field of view/, /Walk/, /at least 0/, /404/],
    ...[/number.*URL/, /canvas/],
  ];
  said.forEach(([name, kind, message], i) => {
    assert.equal(name, "PelageError", `call ${i}: ${message}`);
    assert.equal(kind, { 7: "fetch", 9: "device" }[i] ?? "asked", message);
    assert.match(message, words[i]);
  });
  assert.deepEqual(bytesOf(await picture(page, "after_faults")), bytesOf(before));
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("memory_does_not_grow_over_300_frames", async () => {
  // Counts all objects that a device creates.
  const count = () => {
    window.made = {};
    const kinds = ["Buffer", "Texture", "BindGroup", "RenderPipeline", "ComputePipeline", "Sampler", "ShaderModule"];
    for (const name of kinds.map((kind) => `create${kind}`)) {
      const make = GPUDevice.prototype[name];
      GPUDevice.prototype[name] = function (...args) {
        made[name] = (made[name] ?? 0) + 1;
        return make.apply(this, args);
      };
    }
  };
  const { page, faults, close } = await bare(opened, { size: [48, 36], before: count, options: { look: SMALL } });
  const walk = (from, to) =>
    page.evaluate(
      async ([from, to]) => {
        const { default: init } = await import("/pelage/pelage_web.js");
        const { memory } = await init();
        for (let i = from; i < to; i += 1) {
          pelage.seek(i / 60);
          pelage.orbitBy(0.01, 0);
          pelage.frame();
          if (i % 10 === 9) await pelage.idle();
        }
        gc();
        return { made: { ...made }, wasm: memory.buffer.byteLength, script: performance.memory.usedJSHeapSize };
      },
      [from, to],
    );
  await page.evaluate(() => pelage.play("Walk"));
  const early = await walk(0, 10);
  const late = await walk(10, 310);
  assert.ok(early.made.createBuffer > 10 && early.made.createRenderPipeline > 0, JSON.stringify(early.made));
  assert.deepEqual(late.made, early.made);
  assert.equal(late.wasm, early.wasm);
  assert.ok(late.script < early.script + 500_000, `${early.script} bytes of script became ${late.script}`);
  assert.deepEqual(faults, []);
  await close();
});

inBrowser("replaced_packages_are_freed", async () => {
  const { page, faults, close } = await bare(opened, { size: [48, 36] });
  const load = (times) =>
    page.evaluate(async (times) => {
      const { default: init } = await import("/pelage/pelage_web.js");
      const { memory } = await init();
      for (let i = 0; i < times; i += 1) {
        await pelage.load("/animals/hare.pelage");
        pelage.frame();
      }
      return memory.buffer.byteLength;
    }, times);
  const early = await load(3);
  assert.equal(await load(6), early, "bytes of the module's memory");
  const after = await page.evaluate(async () => {
    pelage.dispose();
    pelage.dispose();
    try {
      pelage.frame();
    } catch (error) {
      return error.message;
    }
    return "drawn";
  });
  assert.match(after, /disposed/);
  assert.deepEqual(faults, []);
  await close();
});

/**
 * Hides the adapter's BC textures unless `blocks`, as on phones. Also hides that the adapter is a software rasteriser,
 * for which blocks are always decoded.
 */
function mask(blocks) {
  Object.defineProperty(GPUAdapterInfo.prototype, "isFallbackAdapter", { get: () => false });
  if (blocks) return;
  const { get } = Object.getOwnPropertyDescriptor(GPUAdapter.prototype, "features");
  const fewer = (features) => new Set([...features].filter((name) => !name.startsWith("texture-compression-bc")));
  Object.defineProperty(GPUAdapter.prototype, "features", { get: function () { return fewer(get.call(this)); } });
  const request = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = function (asked) {
    if ([...(asked?.requiredFeatures ?? [])].includes("texture-compression-bc")) {
      throw new TypeError("texture-compression-bc is not here");
    }
    return request.call(this, asked);
  };
}

inBrowser("blocks_are_decoded_without_device_support", async () => {
  const drawn = [];
  for (const blocks of [true, false]) {
    const before = `(${mask})(${blocks})`;
    const { page, faults, close } = await bare(opened, { size: SIZE, before });
    const gpuBytes = await page.evaluate(() => pelage.info.gpuBytes);
    drawn.push({ gpuBytes, file: await picture(page, `blocks_${blocks}`) });
    assert.deepEqual(faults, []);
    await close();
  }
  const [kept, decoded] = drawn;
  assert.ok(decoded.gpuBytes > 1.3 * kept.gpuBytes, JSON.stringify(drawn));
  assertSame(kept.file, decoded.file);
  assertSame(decoded.file, rendered("render_blocks", SIZE));
});

inBrowser("lost_device_is_replaced_without_changes", async () => {
  const keep = () => {
    const request = GPUAdapter.prototype.requestDevice;
    window.devices = [];
    GPUAdapter.prototype.requestDevice = async function (...args) {
      const device = await request.apply(this, args);
      devices.push(device);
      return device;
    };
  };
  const { page, close } = await bare(opened, { size: SIZE, before: keep });
  await page.evaluate(() => {
    pelage.orbitBy(0.2, 0.1);
    pelage.play("Walk");
    pelage.pause();
    pelage.seek(0.2);
    pelage.setLight({ color: [1, 0.8, 0.6] });
  });
  const before = await picture(page, "before_loss");
  for (let times = 1; times <= 2; times += 1) {
    await page.evaluate(() => devices.at(-1).destroy());
    const restored = (times) => happened.filter(([type]) => type === "devicerestored").length === times;
    await page.waitForFunction(restored, times, { timeout: LONG_MS });
    assert.deepEqual(bytesOf(await picture(page, "after_loss")), bytesOf(before));
  }
  const happened = await page.evaluate(() => happened.map(([type]) => type));
  assert.deepEqual(happened, ["devicelost", "devicerestored", "devicelost", "devicerestored"]);
  // If no adapter is left, that is reported.
  await page.evaluate(() => {
    GPU.prototype.requestAdapter = async () => null;
    devices.at(-1).destroy();
  });
  await page.waitForFunction(() => happened.some(([type]) => type === "error"), null, { timeout: LONG_MS });
  const [, message] = await page.evaluate(() => happened.find(([type]) => type === "error"));
  assert.match(message, /could not be replaced.*offers no graphics adapter; turn on hardware acceleration/);
  await close();
});

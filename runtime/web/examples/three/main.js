// A furry hare in a scene of three.js, with a shared device, colour texture and depth buffer.
//
// three.js draws its meshes into a render target, pelage draws fur over it with the same depth buffer, and three.js
// draws the result on the canvas with its tone mapping. Nothing is copied.

// Imported by path, to run without a bundler. With a bundler, import "pelage" and "three/webgpu".
import { PelagePass } from "./pelage/index.js";
import * as THREE from "./node_modules/three/build/three.webgpu.js";

const { texture, uv } = THREE.TSL;

/** Direction towards the sun, for both renderers. */
const SUN = new THREE.Vector3(-0.5, 0.8, 0.6).normalize();
const canvas = document.getElementById("stage");

// pelage opens the device, because it knows the features that fur requires; three.js uses the same device.
const fur = await PelagePass.open({ color: "rgba16float", depth: "depth32float" });
const renderer = new THREE.WebGPURenderer({ canvas, device: fur.device });
renderer.toneMapping = THREE.ACESFilmicToneMapping;
await renderer.init();
await fur.load("hare.pelage");
fur.setLight({ towards: SUN.toArray() });

const scene = new THREE.Scene();
scene.background = new THREE.Color("#6f7a86");
const camera = new THREE.PerspectiveCamera(30, 1, 0.05, 50);
camera.position.set(0.7, 0.45, 1.0);
camera.lookAt(0, 0.2, 0);
const sun = new THREE.DirectionalLight("#ffffff", 3);
sun.position.copy(SUN);
scene.add(sun, new THREE.AmbientLight("#8090a0", 1.2));

const mesh = (geometry, color, x, y, z) => {
  const made = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ color, roughness: 0.7 }));
  made.position.set(x, y, z);
  scene.add(made);
  return made;
};
mesh(new THREE.CylinderGeometry(2, 2, 0.02, 64), "#74805e", 0, -0.012, 0);
mesh(new THREE.CapsuleGeometry(0.024, 0.18, 8, 24), "#b4573f", 0.24, 0.11, 0.02);
mesh(new THREE.BoxGeometry(0.16, 0.4, 0.16), "#5d6f8c", -0.12, 0.19, -0.16);
const ring = mesh(new THREE.TorusGeometry(0.17, 0.014, 16, 64), "#d9b04c", 0, 0.2, 0);
ring.rotation.x = Math.PI / 2 + 0.2;

// Render target of both, and the quad that shows it.
const target = new THREE.RenderTarget(1, 1, { type: THREE.HalfFloatType, samples: 0 });
target.depthTexture = new THREE.DepthTexture(1, 1, THREE.FloatType);
const shown = new THREE.MeshBasicNodeMaterial();
shown.colorNode = texture(target.texture, uv());
const screen = new THREE.QuadMesh(shown);

function resize() {
  const ratio = Math.min(devicePixelRatio, 2);
  renderer.setPixelRatio(ratio);
  renderer.setSize(innerWidth, innerHeight, false);
  target.setSize(Math.max(innerWidth * ratio, 1), Math.max(innerHeight * ratio, 1));
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener("resize", resize);
resize();

/** Returns the GPUTexture of a three.js texture; valid after something has been drawn to it. */
const gpu = (texture) => renderer.backend.get(texture).texture;

function frame(timeS) {
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  fur.draw({
    color: gpu(target.texture),
    depth: gpu(target.depthTexture),
    viewFromWorld: camera.matrixWorldInverse.elements,
    clipFromView: camera.projectionMatrix.elements,
    clip: fur.info.clips[0]?.name,
    timeS,
  });
  renderer.setRenderTarget(null);
  screen.render(renderer);
}

renderer.setAnimationLoop((ms) => {
  ring.position.y = 0.2 + 0.12 * Math.sin(ms / 1e3);
  frame(ms / 1e3);
});

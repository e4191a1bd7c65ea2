// Draws triangles with three.js: three.html?model=work/plate/model&mesh=work/plate/mesh&about=work/plate/about.json&width=400&height=300[&shadows].
// `window.viewer` is a promise of the same interface as that of glanz.js. Materials, lights and camera are the model's, in the closest
// form of three.js.

import * as THREE from "three";

const asked = new URLSearchParams(location.search);
const canvas = document.querySelector("canvas");
const size = [Number(asked.get("width")), Number(asked.get("height"))];

/** The JSON part of a model. */
function partOf(bytes) {
  const length = new DataView(bytes).getUint32(8, true);
  return JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 16, length)));
}

/** All triangles in one geometry, with a group for each object. */
function geometryOf(bytes, about) {
  const floats = 3 * about.vertices;
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(bytes, 0, floats), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(bytes, 4 * floats, floats), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes, 8 * floats), 1));
  let first = 0;
  for (const [number, part] of about.parts.entries()) {
    geometry.addGroup(first, 3 * part.triangles, number);
    first += 3 * part.triangles;
  }
  return geometry;
}

const colour = (rgb) => new THREE.Color().setRGB(...rgb, THREE.LinearSRGBColorSpace);

/** The closest material of three.js. */
function materialOf(material) {
  const side = THREE.DoubleSide;
  if (material.exponent !== null) {
    // Its lobe is about the half vector: four times the exponent gives the same width.
    const shininess = 4 * material.exponent;
    return new THREE.MeshPhongMaterial({ color: colour(material.base), specular: colour(material.specular), shininess, side });
  }
  const { metalness, roughness } = { metalness: material.metallic, roughness: material.roughness };
  return new THREE.MeshStandardMaterial({ color: colour(material.base), metalness, roughness, side });
}

/** Lights; area lights become points with the intensity towards `target`. */
function lightsOf(lights, target) {
  const found = [];
  for (const light of lights) {
    const strongest = Math.max(...light.intensity) || 1;
    const rgb = colour(light.intensity.map((x) => x / strongest));
    if (light.kind === "infinite") {
      found.push(new THREE.AmbientLight(rgb, Math.PI * strongest));
    } else if (light.kind === "distant") {
      const lamp = new THREE.DirectionalLight(rgb, strongest);
      lamp.position.set(...light.direction).multiplyScalar(-1);
      found.push(lamp);
    } else {
      const lamp = new THREE.PointLight(rgb, strongest);
      lamp.position.set(...light.position);
      if (light.kind === "area") {
        const way = new THREE.Vector3(...target).sub(lamp.position).normalize();
        lamp.intensity *= Math.max(0, way.dot(new THREE.Vector3(...light.direction)));
      }
      found.push(lamp);
    }
  }
  return found;
}

/** Adds shadows of distant lights on the whole model, by a map that is drawn once. */
function castShadows(renderer, scene, [low, high]) {
  const middle = new THREE.Vector3(...low).add(new THREE.Vector3(...high)).multiplyScalar(0.5);
  const radius = middle.distanceTo(new THREE.Vector3(...high));
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.autoUpdate = false;
  renderer.shadowMap.needsUpdate = true;
  scene.traverse((object) => {
    object.castShadow = object.isMesh || object.isDirectionalLight;
    object.receiveShadow = object.isMesh;
    if (!object.isDirectionalLight) return;
    object.target.position.copy(middle);
    object.target.updateMatrixWorld();
    object.position.setLength(radius).add(middle);
    object.shadow.mapSize.set(2048, 2048);
    Object.assign(object.shadow.camera, { left: -radius, right: radius, bottom: -radius, top: radius, near: 0, far: 2 * radius });
    object.shadow.normalBias = radius / 500;
  });
}

/** The model's camera; for a mirrored world it is rotated, and the picture has to be mirrored. */
function cameraOf({ position, right, up, forward, fieldOfView }) {
  const [width, height] = size;
  const vertical = 2 * Math.atan(Math.tan(fieldOfView / 2) * (height / Math.min(width, height)));
  const camera = new THREE.PerspectiveCamera((180 / Math.PI) * vertical, width / height, 0.05, 1e4);
  const [r, u, b] = [right, up, forward.map((x) => -x)].map((axis) => new THREE.Vector3(...axis));
  const isMirrored = new THREE.Vector3().crossVectors(r, u).dot(b) < 0;
  if (isMirrored) r.negate();
  camera.matrixAutoUpdate = false;
  camera.matrix.makeBasis(r, u, b).setPosition(...position);
  camera.updateMatrixWorld(true);
  canvas.style.transform = isMirrored ? "scaleX(-1)" : "";
  return camera;
}

async function viewer() {
  const load = async (name) => (await fetch(asked.get(name))).arrayBuffer();
  const [bytes, mesh] = [await load("model"), await load("mesh")];
  const about = await (await fetch(asked.get("about"))).json();
  const model = partOf(bytes);
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
  renderer.setPixelRatio(1);
  renderer.setSize(...size);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color().setRGB(0.5, 0.5, 0.5, THREE.SRGBColorSpace);
  const materials = about.parts.map((part) => materialOf(model.materials[model.objects[part.object ?? 0].material]));
  const triangles = new THREE.Mesh(geometryOf(mesh, about), materials);
  // Not culled: nearly everything is visible.
  triangles.frustumCulled = false;
  scene.add(triangles);
  const { position, forward, distance } = model.camera;
  for (const light of lightsOf(
    model.lights,
    position.map((x, i) => x + distance * forward[i]),
  ))
    scene.add(light);
  if (asked.has("shadows")) castShadows(renderer, scene, model.bounds);
  const gl = renderer.getContext();
  const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  const draw = (camera) => {
    renderer.render(scene, cameraOf(camera));
    wait();
    return { triangles: renderer.info.render.triangles, draws: renderer.info.render.calls };
  };
  const time = (cameras) =>
    cameras.map((camera) => {
      const start = performance.now();
      draw(camera);
      return performance.now() - start;
    });
  return { draw, time, about: { camera: model.camera, bounds: model.bounds, bytes: mesh.byteLength } };
}

window.viewer = viewer();

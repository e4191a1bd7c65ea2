// Draws a model with the page's own renderer: glanz.html?model=work/plate/model&width=400&height=300. `window.viewer` is a promise
// of the interface for compare.js: `draw(camera)`, `time(cameras)`, `about`.

import { decodeModel } from "./web/model.js";
import { Renderer } from "./web/gl/renderer.js";

const asked = new URLSearchParams(location.search);
const canvas = document.querySelector("canvas");
canvas.width = Number(asked.get("width"));
canvas.height = Number(asked.get("height"));

async function viewer() {
  const bytes = await (await fetch(asked.get("model"))).arrayBuffer();
  const model = decodeModel(bytes);
  const renderer = new Renderer(canvas);
  renderer.setModel(model);
  const gl = canvas.getContext("webgl2");
  const hidden = new Set();
  const view = (camera) => ({
    camera,
    width: canvas.width,
    height: canvas.height,
    hidden,
    selected: null,
    exposure: 0,
    shading: "material",
    stripes: 16,
    curvature: 1,
    edges: false,
    isocurves: 0,
    net: false,
    section: null,
    maps: false,
    seams: true,
    edge: null,
    background: [0.5, 0.5, 0.5],
  });
  const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  const draw = (camera) => {
    const statistics = renderer.draw(view(camera));
    wait();
    return statistics;
  };
  const time = (cameras) =>
    cameras.map((camera) => {
      const start = performance.now();
      draw(camera);
      return performance.now() - start;
    });
  return { draw, time, about: { camera: model.camera, bounds: model.bounds, bytes: bytes.byteLength } };
}

window.viewer = viewer();

import assert from "node:assert/strict";
import { test } from "node:test";

import { corners, project } from "../web/camera.js";
import { Viewpoint } from "../web/viewpoint.js";

/** @typedef {import("../web/camera.js").Bounds} Bounds */

/** A cube whose diagonal is 10 m. @type {Bounds} */
const CUBE = [
  [0, 0, 0],
  [10 / Math.sqrt(3), 10 / Math.sqrt(3), 10 / Math.sqrt(3)],
];

/** Looks along y at the origin from 10 m away. */
function viewpoint() {
  const made = new Viewpoint(() => {});
  made.size = { width: 400, height: 300 };
  /** @type {Parameters<Viewpoint["enter"]>[0]["camera"]} */
  const camera = {
    kind: "perspective",
    position: [0, -10, 0],
    right: [1, 0, 0],
    up: [0, 0, 1],
    forward: [0, 1, 0],
    fieldOfView: Math.PI / 2,
    height: null,
    distance: 10,
  };
  made.enter({ camera, up: [0, 0, 1], bounds: CUBE }, false);
  return made;
}

/** @param {number} actual @param {number} expected */
const near = (actual, expected) => assert.ok(Math.abs(actual - expected) < 1e-9, `${actual} is not ${expected}`);

test("scene turns about what its camera looks at", () => {
  assert.deepEqual(viewpoint().center, [0, 0, 0]);
});

test("way as long as the shorter side is half a turn", () => {
  const view = viewpoint();
  view.orbit(300, 0);
  near(view.camera.position[1], 10);
  near(view.camera.forward[1], -1);
});

test("zooming in for ever ends a ten-millionth of the scene's size away, and out at a thousand times", () => {
  const view = viewpoint();
  for (let i = 0; i < 1000; i++) view.zoom(0.5);
  near(view.camera.distance / 1e-6, 1);
  for (let i = 0; i < 1000; i++) view.zoom(2);
  near(view.camera.distance / 1e4, 1);
});

test("zooming to a known point turns about that from then on", () => {
  const view = viewpoint();
  view.zoom(0.5, 200, 150, [0, -6, 0]);
  assert.deepEqual(view.center, [0, -6, 0]);
  near(view.camera.position[1], -8);
  near(view.camera.distance, 2);
});

test("center goes along with a moved scene, and stays where it is in the picture's depth", () => {
  const view = viewpoint();
  // 300 pixels are 20 m at 10 m: 15 pixels are 1 m.
  view.pan(-15, 30);
  near(view.center[0], 1);
  near(view.center[2], 2);
  near(view.depth, 10);
});

test("camera that went past its center turns about what is before it", () => {
  const view = viewpoint();
  view.camera = { ...view.camera, position: [0, 5, 0] };
  view.orbitAboutFocus();
  assert.deepEqual(view.center, [0, 15, 0]);
});

test("orthographic camera has the whole scene before it, wherever it turns", () => {
  const view = viewpoint();
  view.zoom(0.01);
  view.switchProjection();
  for (let i = 0; i < 20; i++) {
    view.orbit(31, 7);
    for (const corner of corners(CUBE)) assert.ok((project(view.camera, view.size, corner)?.depth ?? -1) > 0);
  }
});

test("changed file leaves the camera where it is, but for its home", () => {
  const view = viewpoint();
  view.orbit(30, 0);
  const { camera } = view;
  view.enter({ camera: { ...camera, fieldOfView: 1 }, up: [0, 0, 1], bounds: CUBE }, true);
  assert.equal(view.camera, camera);
  assert.equal(view.home.fieldOfView, 1);
});

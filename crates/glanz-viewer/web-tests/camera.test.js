import assert from "node:assert/strict";
import { test } from "node:test";

import * as cameras from "../web/camera.js";
import { between } from "../web/transition.js";

/** @typedef {import("../web/camera.js").Camera} Camera */
/** @typedef {import("../web/camera.js").Vector} Vector */

const SIZE = { width: 400, height: 300 };
/** @type {Vector} */
const UP = [0, 0, 1];
const SQRT2 = Math.SQRT2;

/** Ten metres before the origin, looking along y; 90 degrees of view make tangents 1. @type {Camera} */
const FRONT = {
  kind: "perspective",
  position: [0, -10, 0],
  right: [1, 0, 0],
  up: [0, 0, 1],
  forward: [0, 1, 0],
  fieldOfView: Math.PI / 2,
  height: 20,
  distance: 10,
};

/** The same seen in a mirror. @type {Camera} */
const MIRRORED = { ...FRONT, right: [-1, 0, 0] };

/** @param {readonly number[]} actual @param {readonly number[]} expected */
function near(actual, expected, tolerance = 1e-12) {
  assert.equal(actual.length, expected.length);
  const distance = Math.hypot(...actual.map((x, i) => x - expected[i]));
  assert.ok(distance <= tolerance, `[${actual}] is ${distance} away from [${expected}]`);
}

/** @param {Camera} camera */
function orthonormal(camera) {
  const axes = [camera.right, camera.up, camera.forward];
  axes.forEach((a, i) => axes.forEach((b, j) => near([a[0] * b[0] + a[1] * b[1] + a[2] * b[2]], [i === j ? 1 : 0])));
}

/** @param {Camera} camera @param {Vector} point */
function pixel(camera, point) {
  const seen = cameras.project(camera, SIZE, point);
  assert.ok(seen, "the point is before the camera");
  return [seen.x, seen.y];
}

test("a picture of another shape shows all that the scene's own does", () => {
  // Twice as wide as tall, 90 degrees over its height: tangents 2 and 1.
  for (const [width, height, x, y] of [
    [800, 400, 2, 1],
    [400, 400, 2, 2],
    [300, 600, 2, 4],
    [900, 300, 3, 1],
  ]) {
    const size = { width, height };
    const half = cameras.halfSides(cameras.framed(FRONT, 2, size), size);
    assert.ok(Math.abs(half.x - x) < 1e-12 && Math.abs(half.y - y) < 1e-12, `${width} ${height}`);
    const flat = cameras.framed({ ...FRONT, kind: "orthographic" }, 0.5, size);
    const across = cameras.halfSides(flat, size);
    // 20 m across its width, 40 m along its height.
    assert.ok(across.x >= 10 - 1e-12 && across.y >= 20 - 1e-12 && Math.min(across.x - 10, across.y - 20) < 1e-12);
  }
});

test("ray through the upper middle of a square angle of 90 degrees rises by 45 degrees", () => {
  const ray = cameras.rayThrough(FRONT, SIZE, 200, 0);
  near(ray.origin, FRONT.position);
  near(ray.direction, [0, 1 / SQRT2, 1 / SQRT2]);
});

test("field of view and height are those of the shorter side", () => {
  const upright = { width: 300, height: 400 };
  near(cameras.rayThrough(FRONT, upright, 300, 200).direction, [1 / SQRT2, 1 / SQRT2, 0]);
  near(cameras.rayThrough({ ...FRONT, kind: "orthographic" }, upright, 300, 200).origin, [10, -10, 0]);
});

test("point on the ray of a pixel is seen at that pixel by every kind and handedness of camera", () => {
  for (const camera of [FRONT, MIRRORED].flatMap((c) => [c, { ...c, kind: /** @type {const} */ ("orthographic") }])) {
    const ray = cameras.rayThrough(camera, SIZE, 37, 251);
    const point = ray.origin.map((x, i) => x + 7 * ray.direction[i]);
    near(pixel(camera, /** @type {Vector} */ (point)), [37, 251], 1e-9);
  }
});

test("what is behind a perspective camera has no place in its picture", () => {
  assert.equal(cameras.project(FRONT, SIZE, [0, -11, 0]), null);
  assert.equal(cameras.project(FRONT, SIZE, [0, -10, 0]), null);
});

test("quarter turn to the right shows what was on the left side", () => {
  const turned = cameras.orbited(FRONT, UP, [0, 0, 0], Math.PI / 2, 0);
  near(turned.position, [-10, 0, 0]);
  near(turned.forward, [1, 0, 0]);
  near(turned.right, [0, -1, 0]);
  orthonormal(turned);
});

test("what is before the center goes along with the hand, in mirrored worlds too", () => {
  for (const camera of [FRONT, MIRRORED]) {
    const [x, y] = pixel(camera, [0, -1, 0]);
    const turned = pixel(cameras.orbited(camera, UP, [0, 0, 0], 0.1, 0), [0, -1, 0]);
    assert.ok(turned[0] > x && Math.abs(turned[1] - y) < 1e-9, "to the right");
    assert.ok(pixel(cameras.orbited(camera, UP, [0, 0, 0], 0, 0.1), [0, -1, 0])[1] > y, "down");
  }
});

test("turntable keeps a mirrored world mirrored", () => {
  const turned = cameras.orbited(MIRRORED, UP, [1, 2, 3], 0.7, 0.4);
  assert.equal(cameras.handedness(turned), cameras.handedness(MIRRORED));
  orthonormal(turned);
});

test("turntable stops at the poles with the heading that it came with", () => {
  const top = cameras.orbited(FRONT, UP, [0, 0, 0], 0, 100);
  near(top.position, [0, 0, 10]);
  near(top.forward, [0, 0, -1]);
  near(top.up, [0, 1, 0]);
  near(top.right, [1, 0, 0]);
  const back = cameras.orbited(top, UP, [0, 0, 0], 0, -Math.PI / 2);
  near(back.position, FRONT.position, 1e-9);
  near(back.right, FRONT.right, 1e-9);
});

test("turntable spins at the pole and stays level on the way down", () => {
  const top = cameras.orbited(FRONT, UP, [0, 0, 0], 0, 100);
  const spun = cameras.orbited(cameras.orbited(top, UP, [0, 0, 0], Math.PI / 2, 0), UP, [0, 0, 0], 0, -Math.PI / 4);
  near(spun.right, [0, -1, 0], 1e-9);
  near(spun.forward, [1 / SQRT2, 0, -1 / SQRT2], 1e-9);
});

test("turntable keeps the distance from its center, and the center's place in the picture", () => {
  /** @type {Vector} */
  const center = [1, -2, 0.5];
  const turned = cameras.orbited(FRONT, UP, center, 0.3, -0.2);
  near(pixel(turned, center), pixel(FRONT, center), 1e-9);
});

test("orbiting a ten thousand times leaves the axes at right angles", () => {
  let camera = FRONT;
  for (let i = 0; i < 10000; i++) {
    camera = cameras.orbited(camera, UP, [1, 2, 3], 0.01, 0.01 * Math.cos(i));
  }
  orthonormal(camera);
  near([camera.right[2]], [0], 1e-9);
});

test("panned scene follows the cursor at its depth", () => {
  for (const kind of /** @type {const} */ (["perspective", "orthographic"])) {
    const camera = { ...FRONT, kind };
    const [x, y] = pixel(camera, [1, 0, 2]);
    near(pixel(cameras.panned(camera, SIZE, 10, 13, -7), [1, 0, 2]), [x + 13, y - 7], 1e-9);
  }
});

test("zooming keeps the point under the cursor and doubles what is beside it", () => {
  for (const kind of /** @type {const} */ (["perspective", "orthographic"])) {
    const camera = { ...FRONT, kind };
    const [x, y] = pixel(camera, [1, 0, 2]);
    const [besideX] = pixel(camera, [2, 0, 2]);
    const nearer = cameras.zoomed(camera, [1, 0, 2], 0.5);
    near(pixel(nearer, [1, 0, 2]), [x, y], 1e-9);
    near(pixel(nearer, [2, 0, 2]), [x + 2 * (besideX - x), y], 1e-9);
  }
});

test("fitted box touches the margin and stays within it", () => {
  /** @type {import("../web/camera.js").Bounds} */
  const bounds = [
    [-1, 2, -3],
    [4, 5, 6],
  ];
  for (const camera of [FRONT, { ...MIRRORED, kind: /** @type {const} */ ("orthographic") }]) {
    const turned = cameras.orbited(camera, UP, [0, 0, 0], 0.6, 0.5);
    const fit = cameras.fitted(turned, SIZE, bounds);
    near(fit.forward, turned.forward);
    const places = cameras.corners(bounds).map((corner) => pixel(fit, corner));
    // Shares of half a side; the margin is 6 %.
    const reach = places.flatMap(([x, y]) => [Math.abs(x / 200 - 1), Math.abs(y / 150 - 1)]);
    near([Math.max(...reach)], [0.94], 1e-9);
  }
});

test("point can be fitted", () => {
  const fit = cameras.fitted(FRONT, SIZE, [
    [1, 1, 1],
    [1, 1, 1],
  ]);
  near(pixel(fit, [1, 1, 1]), [200, 150], 1e-6);
});

test("top view has the front below, front view the top above", () => {
  for (const camera of [FRONT, MIRRORED]) {
    const top = cameras.standard(camera, UP, [0, 0, 0], "top");
    assert.ok(pixel(top, [0, -1, 0])[1] > 150);
    const front = cameras.standard(top, UP, [0, 0, 0], "front");
    near(front.forward, [0, 1, 0]);
    near(front.up, UP);
    assert.equal(cameras.handedness(front), cameras.handedness(camera));
  }
});

test("right view of a right-handed world looks against x, where y is up too", () => {
  near(cameras.standard(FRONT, UP, [0, 0, 0], "right").forward, [-1, 0, 0]);
  near(cameras.standard(FRONT, [0, 1, 0], [0, 0, 0], "right").forward, [-1, 0, 0]);
  near(cameras.standard(FRONT, [0, 1, 0], [0, 0, 0], "front").forward, [0, 0, -1]);
});

test("isometric view shows the three axes at equal lengths", () => {
  const view = cameras.standard({ ...FRONT, kind: "orthographic" }, UP, [0, 0, 0], "isometric");
  const middle = pixel(view, [0, 0, 0]);
  /** @type {Vector[]} */
  const ends = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  // An axis at the angle acos(1 / sqrt 3) to the line of sight is seen sqrt(2 / 3) long; 300 pixels are 20 m.
  for (const end of ends) {
    const [x, y] = pixel(view, end);
    near([Math.hypot(x - middle[0], y - middle[1])], [15 * Math.sqrt(2 / 3)], 1e-9);
  }
});

test("every standard view keeps the distance from its center and has the center in the middle", () => {
  for (const view of /** @type {const} */ (["front", "back", "left", "right", "top", "bottom", "isometric"])) {
    const camera = cameras.standard(FRONT, UP, [0, 2, 0], view);
    orthonormal(camera);
    near(pixel(camera, [0, 2, 0]), [200, 150], 1e-9);
    near([camera.distance], [12]);
  }
});

test("other projection keeps sizes at the center and returns", () => {
  /** @type {Vector} */
  const center = [0, -3, 0];
  const flat = cameras.otherProjection(FRONT, center);
  // Seven metres away, half of 90 degrees: 150 pixels are 7 m.
  near(pixel(flat, [1, -3, 1]), [200 + 150 / 7, 150 - 150 / 7], 1e-9);
  near(pixel(FRONT, [1, -3, 1]), [200 + 150 / 7, 150 - 150 / 7], 1e-9);
  const back = cameras.otherProjection(flat, center);
  near(back.position, FRONT.position, 1e-9);
  assert.equal(back.kind, "perspective");
});

test("movedBehind orthographic camera has the whole box before it, and the same picture", () => {
  /** @type {import("../web/camera.js").Bounds} */
  const bounds = [
    [-1, -50, -1],
    [1, 50, 1],
  ];
  const camera = { ...FRONT, kind: /** @type {const} */ ("orthographic") };
  const back = cameras.movedBehind(camera, bounds);
  for (const corner of cameras.corners(bounds)) {
    assert.ok((cameras.project(back, SIZE, corner)?.depth ?? -1) > 0);
    near(pixel(back, corner), pixel(camera, corner), 1e-9);
  }
  near(cameras.focus(back), cameras.focus(camera));
  assert.equal(cameras.movedBehind(FRONT, bounds), FRONT, "perspective cameras stand where they stand");
});

test("half way between views at right angles are 45 degrees and the geometric mean of the distances", () => {
  const right = { ...cameras.standard(FRONT, UP, [0, 0, 0], "right"), position: /** @type {Vector} */ ([40, 0, 0]) };
  const middle = between(FRONT, { ...right, distance: 40 }, 0.5);
  near(middle.forward, [-1 / SQRT2, 1 / SQRT2, 0]);
  near(middle.position, [20 / SQRT2, -20 / SQRT2, 0], 1e-9);
  orthonormal(middle);
});

test("half way between opposite views is a quarter turn", () => {
  const back = cameras.standard(FRONT, UP, [0, 0, 0], "back");
  const middle = between(FRONT, back, 0.5);
  near([middle.forward[0] * FRONT.forward[0] + middle.forward[1] * FRONT.forward[1] + middle.forward[2]], [0], 1e-9);
  near(between(FRONT, back, 1).position, back.position);
});

test("camera of the server without field of view or height gets them at its distance", () => {
  const { fieldOfView: _unused, ...flat } = { ...FRONT, kind: /** @type {const} */ ("orthographic") };
  assert.equal(cameras.withDefaults(flat).height, 20);
  const { height: _height, ...deep } = FRONT;
  // tan 45 degrees = 1: as high as twice the distance.
  near([cameras.withDefaults(deep).height], [20]);
});

import assert from "node:assert/strict";
import { test } from "node:test";

import { edgeDimensions, edgesNear, isInSight } from "../web/edge_picking.js";
import { shownRuns } from "../web/gl/edge_lines.js";

/** Looks along y from (0, -2, 0), half a metre to each side at a metre. @type {import("../web/model.js").Camera} */
const CAMERA = {
  kind: "perspective",
  position: [0, -2, 0],
  right: [1, 0, 0],
  up: [0, 0, 1],
  forward: [0, 1, 0],
  fieldOfView: 2 * Math.atan(0.5),
  height: 2,
  distance: 2,
};
const SIZE = { width: 200, height: 200 };

/** An edge from (0, 0, 0) to (0.5, 2, 0), and one along z through (0.5, 0, 0); the copy is one metre farther down than the first one. */
const MODEL = /** @type {import("../web/model.js").Model} */ (
  /** @type {unknown} */ ({
    edges: [
      { first: 0, count: 2, kind: "line", radii: [], length: Math.hypot(0.5, 2), angle: 0, shapes: [0, 1] },
      { first: 2, count: 3, kind: "line", radii: [], length: 2, angle: 0, shapes: [1] },
    ],
    edgeCopies: [
      { toWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], first: 0, count: 2, firstLeaf: 0 },
      { toWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1], first: 0, count: 2, firstLeaf: 2 },
    ],
    blocks: { edgePoints: new Float32Array([0, 0, 0, 0.5, 2, 0, 0.5, 0, -0.1, 0.5, 0, 0.1, 0.5, 0, 0.3]) },
  })
);

test("the nearest place of an edge in perspective is on the edge in space", () => {
  // Half of the way in the picture, from x = 100 to x = 125, is a third of the way in space: x / y' = 1 / 16 with y' = 2 + 4 x.
  const [nearest, ...others] = edgesNear(MODEL, CAMERA, SIZE, { x: 112.5, y: 97 }, new Set(), null);
  assert.deepEqual(others, []);
  assert.deepEqual([nearest.copy, nearest.edge], [0, 0]);
  assert.ok(Math.abs(nearest.distance - 3) < 1e-9);
  const expected = [1 / 6, 2 / 3, 0];
  nearest.point.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) < 1e-9, `${nearest.point}`));
  assert.ok(Math.abs(nearest.depth - (2 + 2 / 3)) < 1e-9);
});

test("edges beyond the reach and those of hidden shapes are not picked", () => {
  assert.deepEqual(edgesNear(MODEL, CAMERA, SIZE, { x: 112.5, y: 93 }, new Set(), null), []);
  const near = { x: 149, y: 90 };
  assert.deepEqual(
    edgesNear(MODEL, CAMERA, SIZE, near, new Set([0]), null).map(({ edge }) => edge),
    [1],
  );
  assert.deepEqual(edgesNear(MODEL, CAMERA, SIZE, near, new Set([1]), null), []);
});

test("an edge some pixels behind the surface beside it is in sight, one far behind is not", () => {
  const [place] = edgesNear(MODEL, CAMERA, SIZE, { x: 150, y: 100 }, new Set(), null);
  // A pixel at this depth is a centimetre.
  assert.ok(isInSight(CAMERA, SIZE, place, null));
  assert.ok(isInSight(CAMERA, SIZE, place, [0.5, -0.03, 0]));
  assert.ok(!isInSight(CAMERA, SIZE, place, [0.5, -0.06, 0]));
});

test("edges that are shown form runs", () => {
  const [first, second] = MODEL.edgeCopies;
  assert.deepEqual(shownRuns(MODEL, first, new Set()), [[0, 2]]);
  assert.deepEqual(shownRuns(MODEL, first, new Set([1])), [[0, 1]]);
  assert.deepEqual(shownRuns(MODEL, second, new Set([2, 3])), []);
});

test("what a section plane cuts away is not picked, what it leaves of an edge is", () => {
  // Keeps y <= 1, where the first edge is at x = 100 to 116.67.
  const section = { normal: /** @type {[number, number, number]} */ ([0, 1, 0]), offset: 1 };
  const beyond = { x: 122, y: 97 };
  assert.equal(edgesNear(MODEL, CAMERA, SIZE, beyond, new Set(), null).length, 1);
  assert.deepEqual(edgesNear(MODEL, CAMERA, SIZE, beyond, new Set(), section), []);
  const [place] = edgesNear(MODEL, CAMERA, SIZE, { x: 119, y: 100 }, new Set(), section);
  assert.ok(Math.abs(place.point[1] - 1) < 1e-9, `${place.point}`);
  assert.ok(Math.abs(place.depth - 3) < 1e-9);
});

test("an edge with one end behind the camera is picked where it is seen", () => {
  const model = {
    ...MODEL,
    edges: [{ ...MODEL.edges[0], first: 0, count: 2 }],
    edgeCopies: [{ ...MODEL.edgeCopies[0], first: 0, count: 1 }],
    // From 2 m behind the camera to 2 m before it, 0.25 m to the right.
    blocks: { ...MODEL.blocks, edgePoints: new Float32Array([0.25, -4, 0, 0.25, 0, 0]) },
  };
  // At a depth of 1 m the camera sees half a metre to each side.
  const [place] = edgesNear(model, CAMERA, SIZE, { x: 150, y: 101 }, new Set(), null);
  assert.ok(Math.abs(place.depth - 1) < 1e-6, `${place.depth}`);
  assert.ok(Math.abs(place.point[1] + 1) < 1e-6, `${place.point}`);
  const behind = { ...model, blocks: { ...MODEL.blocks, edgePoints: new Float32Array([0.25, -4, 0, 0.25, -3, 0]) } };
  assert.deepEqual(edgesNear(behind, CAMERA, SIZE, { x: 150, y: 101 }, new Set(), null), []);
});

test("copies enlarge lengths, and those that distort leave no radius", () => {
  const circle = { ...MODEL.edges[0], kind: /** @type {const} */ ("circle"), radii: [0.3], length: 2, angle: 1 };
  /** @param {number[]} toWorld */
  const placed = (toWorld) => ({ ...MODEL, edges: [circle], edgeCopies: [{ ...MODEL.edgeCopies[0], toWorld }] });
  const dimensions = (/** @type {number[]} */ toWorld) => edgeDimensions(placed(toWorld), { copy: 0, edge: 0 });
  const enlarged = dimensions([0, 2, 0, -2, 0, 0, 0, 0, 2, 5, 6, 7]);
  assert.deepEqual(enlarged, { kind: "circle", length: 4, isExact: true, radii: [0.6], angle: 1 });
  const stretched = dimensions([2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
  // Its points are (0, 0, 0) and (0.5, 2, 0).
  const expected = { kind: "ellipse", length: Math.hypot(1, 2), isExact: false, radii: [], angle: null };
  assert.deepEqual(stretched, expected);
  // Columns of the same length that are not at right angles.
  assert.equal(dimensions([1, 0, 0, 0.6, 0.8, 0, 0, 0, 1, 0, 0, 0]).angle, null);
});

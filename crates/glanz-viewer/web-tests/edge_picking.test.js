import assert from "node:assert/strict";
import { test } from "node:test";

import { edgesNear, isInSight } from "../web/edge_picking.js";
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
  const [nearest, ...others] = edgesNear(MODEL, CAMERA, SIZE, { x: 112.5, y: 97 }, new Set());
  assert.deepEqual(others, []);
  assert.deepEqual([nearest.copy, nearest.edge], [0, 0]);
  assert.ok(Math.abs(nearest.distance - 3) < 1e-9);
  const expected = [1 / 6, 2 / 3, 0];
  nearest.point.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) < 1e-9, `${nearest.point}`));
  assert.ok(Math.abs(nearest.depth - (2 + 2 / 3)) < 1e-9);
});

test("edges beyond the reach and those of hidden shapes are not picked", () => {
  assert.deepEqual(edgesNear(MODEL, CAMERA, SIZE, { x: 112.5, y: 93 }, new Set()), []);
  const near = { x: 149, y: 90 };
  assert.deepEqual(
    edgesNear(MODEL, CAMERA, SIZE, near, new Set([0])).map(({ edge }) => edge),
    [1],
  );
  assert.deepEqual(edgesNear(MODEL, CAMERA, SIZE, near, new Set([1])), []);
});

test("an edge some pixels behind the surface beside it is in sight, one far behind is not", () => {
  const [place] = edgesNear(MODEL, CAMERA, SIZE, { x: 150, y: 100 }, new Set());
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

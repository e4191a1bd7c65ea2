import assert from "node:assert/strict";
import { test } from "node:test";

import { leafBounds } from "../web/leaf_bounds.js";

/** Turned about z by a quarter, then moved to x = 10. */
const TURNED = [0, 1, 0, -1, 0, 0, 0, 0, 1, 10, 0, 0];

/** A rational patch of degree 1 x 1 of which one weight is 2, a mesh of one triangle, and a cubic surface in a box. */
const MODEL = /** @type {import("../web/model.js").Model} */ (
  /** @type {unknown} */ ({
    surfaces: [
      { kind: "patches", first: 0, count: 1, origin: [0, 0, 0], region: null, mapping: "patch" },
      { kind: "mesh", firstVertex: 1, vertices: 3, firstIndex: 0, indices: 3, origin: [0, 0, 0] },
      { kind: "algebraic", terms: [], min: [-1, -2, -3], max: [1, 2, 3] },
    ],
    objects: [
      { surface: 0, leaf: 0, toWorld: TURNED },
      { surface: 1, leaf: 1, toWorld: TURNED },
      { surface: 2, leaf: 2, toWorld: TURNED },
    ],
    blocks: {
      patches: Uint32Array.of(1 + 256 + 65536, 0, ...Array(14).fill(0)),
      points: Float32Array.of(0, 0, 0, 1, 4, 0, 0, 2, 0, 3, 0, 1, 1, 1, 1, 1),
      positions: Float32Array.of(99, 99, 99, 0, 0, 0, 1, 0, 0, 0, 2, 0),
    },
  })
);

test("bounds hold the control points where they are in the world", () => {
  // (x, y) becomes (10 - y, x); the point of weight 2 is (2, 0, 0).
  assert.deepEqual(leafBounds(MODEL, 0, 1), [
    [7, 0, 0],
    [10, 2, 1],
  ]);
});

test("meshes and algebraic surfaces have bounds too", () => {
  assert.deepEqual(leafBounds(MODEL, 1, 2), [
    [8, 0, 0],
    [10, 1, 0],
  ]);
  assert.deepEqual(leafBounds(MODEL, 2, 3), [
    [8, -1, -3],
    [12, 1, 3],
  ]);
});

test("bounds of several leaves hold all of them, and no leaf has none", () => {
  assert.deepEqual(leafBounds(MODEL, 0, 3), [
    [7, -1, -3],
    [12, 2, 3],
  ]);
  assert.equal(leafBounds(MODEL, 3, 4), null);
});

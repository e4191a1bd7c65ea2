import assert from "node:assert/strict";
import { test } from "node:test";

import { isCut } from "../web/gl/surface_boxes.js";
import { gridOf } from "../web/gl/grids.js";
import { gridLevels, sideLevel } from "../web/gl/grid_levels.js";
import { BOUNDS, SIDE, SIDES, findBorders, boundPatches } from "../web/gl/patch_bounds.js";
import { Subpatches } from "../web/gl/subpatches.js";
import { decodeModel } from "../web/model.js";
import { encodeModel, patchModel } from "./small_model.js";

/** A quarter of a circle of radius 1 in the plane of x and y, times the segment from z = 0 to 2. */
const CYLINDER = [
  [1, 0],
  [1, 1],
  [0, 1],
].flatMap(([x, y], i) => [0, 2].flatMap((z) => [x, y, z, 1].map((value) => value * (i === 1 ? Math.SQRT1_2 : 1))));

/** @param {number} degreeU @param {number} degreeV @param {number[]} points */
function modelOf(degreeU, degreeV, points) {
  return decodeModel(encodeModel(patchModel({ degreeU, degreeV, points })));
}

/** Points of a net of plain points with weight 1. @param {number[][]} rows */
function plain(rows) {
  return rows.flatMap(([x, y, z]) => [x, y, z, 1]);
}

test("levels_of_a_parabola_are_the_fewest_that_keep_its_chords_within_the_tolerance", () => {
  // z = x^2 has the second derivative 2: over 2^-k a chord is 4^-k / 4 off. At 1000 tolerances per metre 4^k >= 250, k = 4.
  const points = plain([
    [0, 0, 0],
    [0, 1, 0],
    [0.5, 0, 0],
    [0.5, 1, 0],
    [1, 0, 1],
    [1, 1, 1],
  ]);
  const measures = boundPatches(modelOf(2, 1, points));
  // The surface's own second derivative is that of z, across it where z' = 0 and less elsewhere.
  assert.deepEqual([...measures.slice(BOUNDS, BOUNDS + 3)], [2, 0, 0]);
  assert.equal(gridLevels(2, 0, 0, 1000, 0, 0), 4);
  assert.equal(sideLevel(measures[SIDES + 4], 1000), 4);
  assert.equal(sideLevel(measures[SIDES + 2 * SIDE + 4], 1000), 0);
});

test("twist_alone_refines_both_directions_alike", () => {
  // 2 uv / 8 = 256 tolerances at level 0, halved by every step: 8 steps, four each.
  assert.equal(gridLevels(0, 1024, 0, 1, 0, 0), 4 + 16 * 4);
});

test("levels_never_go_below_those_of_the_sides", () => {
  assert.equal(gridLevels(0, 0, 0, 1000, 3, 5), 3 + 16 * 5);
});

test("bending_of_an_arc_bounds_the_distance_of_its_chords", () => {
  const model = modelOf(2, 1, CYLINDER);
  const measures = boundPatches(model);
  const subpatches = new Subpatches(model, measures);
  const at = (/** @type {number} */ u) => {
    subpatches.evaluate(0, u, 0);
    return [subpatches.corner[0], subpatches.corner[1]];
  };
  for (let level = 0; level < 8; level++) {
    const h = 2 ** -level;
    for (let k = 0; k < 2 ** level; k++) {
      const [a, b] = [at(k * h), at((k + 1) * h)];
      assert.ok(Math.abs(Math.hypot(...a) - 1) < 1e-6);
      // The sagitta of a chord of a circle of radius 1: 1 minus the distance of its middle from the centre.
      const sagitta = 1 - Math.hypot((a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
      assert.ok(sagitta <= (measures[SIDES + 4] * h * h) / 8 + 1e-6, `level ${level}, chord ${k}`);
    }
  }
});

test("a_side_has_the_same_measures_read_from_either_end", () => {
  const rows = [
    [0, 0, 0],
    [0.1, 1.7, 0.2],
    [0.33, 0.2, 0.9],
    [1.01, 0.4, 0.3],
  ];
  const other = rows.map(([x, y, z]) => [x, y, z + 3]);
  const along = modelOf(1, 3, plain([...rows, ...other]));
  const back = modelOf(1, 3, plain([...other.slice().reverse(), ...rows.slice().reverse()]));
  const side = (/** @type {Float64Array} */ measures, /** @type {number} */ number) => [
    ...measures.slice(SIDES + number * SIDE, SIDES + (number + 1) * SIDE),
  ];
  assert.deepEqual(side(boundPatches(along), 2), side(boundPatches(back), 3));
});

test("a_flat_patch_bends_at_its_curved_sides_alone_but_for_the_share_that_its_parameters_are_allowed", () => {
  // A sector of the unit disk: quarter circle to the centre.
  const arc = [
    [1, 0, 1],
    [1, 1, Math.SQRT1_2],
    [0, 1, 1],
  ];
  const points = arc.flatMap(([x, y, w]) => [x * w, y * w, 0, w, 0, 0, 0, w]);
  const measures = boundPatches(modelOf(2, 1, points));
  for (let k = 0; k < 3; k++) assert.equal(measures[4 + k], measures[BOUNDS + k] / 32);
  // The largest second derivative of the arc across itself is at its ends: squared speed sqrt(2)^2 over the radius.
  assert.ok(measures[SIDES + 4] > 2);
});

test("a_side_that_is_a_point_is_no_border", () => {
  const arc = [
    [1, 0, 1],
    [1, 1, Math.SQRT1_2],
    [0, 1, 1],
  ];
  const points = arc.flatMap(([x, y, w]) => [x * w, y * w, 0, w, 0, 0, 0, w]);
  // Sides v = 0 (the arc), u = 0 and u = 1 (radii), but not v = 1 (the centre).
  assert.deepEqual([...findBorders(modelOf(2, 1, points))], [1 + 4 + 8]);
});

test("a_grid_covers_its_square_once", () => {
  const { corners, triangles } = gridOf(2, 1);
  let area = 0;
  for (let k = 0; k < triangles.length; k += 3) {
    const [a, b, c] = [0, 1, 2].map((i) => [corners[4 * triangles[k + i]], corners[4 * triangles[k + i] + 1]]);
    const twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert.equal(twice, 1);
    area += twice / 2;
  }
  assert.equal(area, 4 * 2);
});

test("a_plane_cuts_a_turned_box_up_to_its_corner", () => {
  // A cube of half side 1, turned by 45 degrees about z and moved to x = 5: its edge is at x = 5 - sqrt(2).
  const c = Math.SQRT1_2;
  const toWorld = [c, c, 0, -c, c, 0, 0, 0, 1, 5, 0, 0];
  /** @type {import("../web/gl/surface_boxes.js").Box} */
  const box = { middle: [0, 0, 0], half: [1, 1, 1] };
  const at = (/** @type {number} */ offset) => isCut(box, toWorld, { normal: [1, 0, 0], offset });
  assert.ok(at(5 - Math.SQRT2 + 1e-9));
  assert.ok(!at(5 - Math.SQRT2 - 1e-9));
});

import assert from "node:assert/strict";
import { test } from "node:test";

import { SceneParts, ranges } from "../web/scene_parts.js";

/** @typedef {import("../web/model.js").TreeNode} TreeNode */

/** @param {string} name @param {number} leaf @returns {TreeNode} */
const shape = (name, leaf) => ({ name, kind: "shape", leaf, what: "nurbs", place: `car.pbrt:${leaf + 10}` });

/** @returns {TreeNode} */
const car = () => ({
  name: "car",
  kind: "group",
  children: [
    { name: "body", kind: "group", children: [shape("hood", 0), shape("door", 1)] },
    shape("", 2),
    { name: "wheels", kind: "group", children: [shape("left", 3), shape("right", 4)] },
  ],
});

/** @param {SceneParts} parts @param {string} [search] */
const labels = (parts, search) => parts.rows(search).map(({ label }) => label);

test("unfolded groups are listed from top to bottom, shapes without a name by their kind", () => {
  const parts = new SceneParts(car());
  assert.deepEqual(labels(parts), ["car", "body", "hood", "door", "nurbs", "wheels", "left", "right"]);
  parts.root.children[0].expanded = false;
  assert.deepEqual(labels(parts), ["car", "body", "nurbs", "wheels", "left", "right"]);
});

test("large groups are folded at first, the whole scene is not", () => {
  const many = Array.from({ length: 100 }, (_, i) => shape(`part ${i}`, i));
  assert.equal(new SceneParts({ name: "all", kind: "group", children: many }).rows().length, 101);
  const nested = { name: "all", kind: /** @type {const} */ ("group"), children: [{ ...car(), children: many }] };
  assert.deepEqual(labels(new SceneParts(nested)), ["all", "car"]);
});

test("search finds names, kinds and places without case, in folded groups too", () => {
  const parts = new SceneParts(car());
  parts.root.children[2].expanded = false;
  assert.deepEqual(labels(parts, "RIGHT"), ["right"]);
  assert.deepEqual(labels(parts, "nurbs"), ["hood", "door", "nurbs", "left", "right"]);
  assert.deepEqual(labels(parts, "pbrt:12"), ["nurbs"]);
  assert.deepEqual(labels(parts, "bumper"), []);
});

test("shape of a leaf is found, and there is none of other numbers", () => {
  const parts = new SceneParts(car());
  assert.deepEqual(
    [0, 2, 4].map((leaf) => parts.shape(leaf)?.label),
    ["hood", "nurbs", "right"],
  );
  assert.equal(parts.shape(5), null);
  assert.equal(parts.shape(-1), null);
});

test("group of which some shapes are hidden is neither shown nor hidden", () => {
  const parts = new SceneParts(car());
  const [body] = parts.root.children;
  parts.show(body.children[0], false);
  assert.deepEqual([parts.visibility(body), parts.visibility(parts.root)], ["mixed", "mixed"]);
  parts.show(body, false);
  assert.deepEqual([...parts.hidden], [0, 1]);
  assert.deepEqual([parts.visibility(body), parts.visibility(parts.root)], ["hidden", "mixed"]);
  parts.show(parts.root, true);
  assert.equal(parts.visibility(parts.root), "shown");
});

test("isolating hides all else, and again brings back what was shown before", () => {
  const parts = new SceneParts(car());
  parts.show(parts.root.children[1], false);
  parts.isolate(parts.root.children[2]);
  assert.deepEqual([...parts.hidden], [0, 1, 2]);
  parts.isolate(parts.root.children[2]);
  assert.deepEqual([...parts.hidden], [2]);
});

test("selecting unfolds the groups around, and a group has no leaf", () => {
  const parts = new SceneParts(car());
  parts.root.expanded = false;
  parts.root.children[2].expanded = false;
  parts.select(parts.shape(4));
  assert.ok(parts.rows().some(({ label }) => label === "right"));
  assert.equal(parts.selectedLeaf, 4);
  parts.select(parts.root.children[2]);
  assert.equal(parts.selectedLeaf, null);
});

test("changed file keeps what is hidden and selected if it has as many shapes", () => {
  const before = new SceneParts(car());
  before.show(before.root.children[0], false);
  before.select(before.shape(3));
  const after = new SceneParts(car());
  after.inherit(before);
  assert.deepEqual([...after.hidden], [0, 1]);
  assert.equal(after.selected, after.shape(3));
  const other = new SceneParts({ name: "one", kind: "group", children: [shape("only", 0)] });
  other.inherit(before);
  assert.equal(other.hidden.size, 0);
});

test("runs of leaves become their first and last", () => {
  assert.deepEqual(ranges(new Set([7, 3, 1, 2, 9, 10])), [[1, 3], 7, [9, 10]]);
  assert.deepEqual(ranges(new Set()), []);
});

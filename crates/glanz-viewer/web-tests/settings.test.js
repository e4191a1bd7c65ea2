import assert from "node:assert/strict";
import { test } from "node:test";

import {
  defaultSettings,
  fullColour,
  luxSettings,
  luxSettingsText,
  nextShading,
  realTimeOnly,
  sectionPlane,
  shareThrough,
} from "../web/settings.js";

/** @type {import("../web/camera.js").Bounds} */
const BOX = [
  [-1, 0, 2],
  [3, 8, 4],
];

/** Scenes without edges of their own: one of parts, and a lit room. */
const PLAIN = { hasEdges: false, hasMaps: false, hasWalls: false, isCompared: false };
const ROOM = { ...PLAIN, hasMaps: true, hasWalls: true };

test("a key turns its own shading on whichever other is shown, and off again", () => {
  /** @type {import("../web/settings.js").Shading[]} */
  const order = ["material", "gaussian", "mean"];
  assert.equal(nextShading("material", order), "gaussian");
  assert.equal(nextShading("zebra", order), "gaussian");
  assert.equal(nextShading("gaussian", order), "mean");
  assert.equal(nextShading("mean", order), "material");
});

test("untouched settings are rendered, and everything that rendering does not show is a reason not to", () => {
  assert.equal(realTimeOnly(defaultSettings(), PLAIN), null);
  /** @type {Partial<import("../web/settings.js").Settings>[]} */
  const reasons = [
    { integrator: "none" },
    { section: true },
    { shading: "zebra" },
    { maps: true },
    { net: true },
    { edges: true },
    { isocurves: 1 },
    { seeThrough: true },
  ];
  for (const reason of reasons)
    assert.ok(realTimeOnly({ ...defaultSettings(), ...reason }, ROOM), JSON.stringify(reason));
});

test("what a scene does not have excludes no rendering, two designs do", () => {
  const settings = { ...defaultSettings(), seeThrough: true, maps: true };
  assert.equal(realTimeOnly(settings, PLAIN), null);
  assert.equal(realTimeOnly(defaultSettings(), ROOM), null);
  assert.equal(realTimeOnly(defaultSettings(), { ...PLAIN, isCompared: true }), "two designs");
});

test("settings of lux maps are kept, and what is none of them is left out", () => {
  const settings = { ...defaultSettings(), luxScale: /** @type {const} */ ("percentile"), luxTail: 2.5, isolux: true };
  const kept = luxSettings(luxSettingsText({ ...settings, isoluxLevels: "300 500" }));
  assert.deepEqual(kept, { luxScale: "percentile", luxTail: 2.5, isolux: true, isoluxLevels: "300 500" });
  for (const luxTail of [null, true, "5", [1], -1, 11]) assert.deepEqual(luxSettings(JSON.stringify({ luxTail })), {});
  for (const text of [null, "", "[", "null", "7"]) assert.deepEqual(luxSettings(text), {});
  const damaged = JSON.stringify({ luxScale: "cubic", luxTail: 60, isolux: 1, isoluxLevels: "many", shading: "zebra" });
  assert.deepEqual(luxSettings(damaged), {});
});

test("section plane goes from one end of the box to the other", () => {
  const settings = { ...defaultSettings(), section: true, sectionAxis: /** @type {const} */ ("y") };
  assert.equal(sectionPlane({ ...settings, section: false }, BOX), null);
  assert.deepEqual(sectionPlane({ ...settings, sectionShare: 0 }, BOX), { normal: [0, 1, 0], offset: 0 });
  assert.deepEqual(sectionPlane({ ...settings, sectionShare: 0.25 }, BOX), { normal: [0, 1, 0], offset: 2 });
});

test("other side of a section plane is cut by the same plane", () => {
  const settings = { ...defaultSettings(), section: true, sectionFlip: true, sectionShare: 0.75 };
  const plane = sectionPlane(settings, BOX);
  // x = -1 + 0.75 * 4 = 2: what is kept has -x <= -2.
  assert.equal(plane?.normal[0], -1);
  assert.equal(plane?.offset, -2);
});

test("section through a picked point has it on the plane", () => {
  /** @type {import("../web/linear.js").Vector} */
  const normal = [0.6, 0, 0.8];
  const settings = {
    ...defaultSettings(),
    section: true,
    sectionAxis: /** @type {const} */ ("picked"),
    pickedNormal: normal,
  };
  // 0.6 * 1 + 0.8 * 3 = 3: the middle of the box.
  assert.ok(Math.abs(shareThrough(settings, BOX, [1, 5, 3]) - 0.5) < 1e-12);
  const share = shareThrough(settings, BOX, [2, 0, 2.5]);
  const plane = sectionPlane({ ...settings, sectionShare: share }, BOX);
  assert.ok(Math.abs((plane?.offset ?? 0) - 3.2) < 1e-12);
});

test("full colour is a power of ten over the size of the scene", () => {
  assert.equal(fullColour({ ...defaultSettings(), curvature: 2 }, 4), 25);
});

test("edges of the scene are drawn over the rendered image, borders of patches are not", () => {
  const settings = { ...defaultSettings(), edges: true };
  assert.equal(realTimeOnly(settings, { ...PLAIN, hasEdges: true }), null);
  assert.equal(realTimeOnly(settings, PLAIN), "lines on surfaces");
});

import assert from "node:assert/strict";
import { test } from "node:test";

import { defaultSettings, fullColour, realTimeOnly, sectionPlane, shareThrough } from "../web/settings.js";

/** @type {import("../web/camera.js").Bounds} */
const BOX = [
  [-1, 0, 2],
  [3, 8, 4],
];

test("untouched settings are rendered, and everything that rendering does not show is a reason not to", () => {
  assert.equal(realTimeOnly(defaultSettings()), null);
  /** @type {Partial<import("../web/settings.js").Settings>[]} */
  const reasons = [
    { integrator: "none" },
    { section: true },
    { shading: "zebra" },
    { maps: true },
    { net: true },
    { edges: true },
    { isocurves: 1 },
  ];
  for (const reason of reasons) assert.ok(realTimeOnly({ ...defaultSettings(), ...reason }), JSON.stringify(reason));
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

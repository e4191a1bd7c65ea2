/**
 * Bounding boxes of leaves of the scene.
 *
 * @module
 */

import { corners } from "./camera.js";
import { boxesOfSurfaces } from "./gl/surface_boxes.js";
import { add, mapPoint, subtract } from "./linear.js";

/** @typedef {import("./camera.js").Bounds} Bounds */
/** @typedef {import("./model.js").Model} Model */

/**
 * A box around the shapes of some leaves.
 * @param {Model} model
 * @param {number} first
 * @param {number} end
 * @returns {Bounds | null} `null` if none of them is drawn
 */
export function leafBounds(model, first, end) {
  /** @type {Bounds} */
  const box = [
    [Infinity, Infinity, Infinity],
    [-Infinity, -Infinity, -Infinity],
  ];
  const boxes = boxesOfSurfaces(model);
  for (const object of model.objects) {
    if (object.leaf < first || object.leaf >= end) continue;
    const { middle, half } = boxes[object.surface];
    for (const point of corners([subtract(middle, half), add(middle, half)])) {
      mapPoint(object.toWorld, point).forEach((x, axis) => {
        box[0][axis] = Math.min(box[0][axis], x);
        box[1][axis] = Math.max(box[1][axis], x);
      });
    }
  }
  return box[0][0] <= box[1][0] ? box : null;
}

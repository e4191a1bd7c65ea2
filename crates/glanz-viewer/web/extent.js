/**
 * How far parts of a scene reach.
 *
 * @module
 */

import { corners } from "./camera.js";
import { mapPoint } from "./linear.js";
import { patchFacts } from "./model.js";

/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./camera.js").Bounds} Bounds */
/** @typedef {import("./model.js").Model} Model */
/** @typedef {import("./model.js").SceneObject} SceneObject */

/**
 * Points that span a hull of a surface, relative to its origin: a rational patch lies within that of its control points.
 * @param {Model} model
 * @param {number} index of the surface
 * @returns {Generator<Vector>}
 */
function* hull(model, index) {
  const surface = model.surfaces[index];
  const { points, positions } = model.blocks;
  if (surface.kind === "algebraic") {
    yield* corners([surface.min, surface.max]);
  } else if (surface.kind === "mesh") {
    for (let i = surface.firstVertex; i < surface.firstVertex + surface.vertices; i++) {
      yield [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]];
    }
  } else {
    for (let patch = surface.first; patch < surface.first + surface.count; patch++) {
      const { degreeU, degreeV, firstPoint } = patchFacts(model, patch);
      for (let i = firstPoint; i < firstPoint + (degreeU + 1) * (degreeV + 1); i++) {
        const w = points[4 * i + 3];
        if (w > 0) yield [points[4 * i] / w, points[4 * i + 1] / w, points[4 * i + 2] / w];
      }
    }
  }
}

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
  for (const object of model.objects) {
    if (object.leaf < first || object.leaf >= end) continue;
    for (const point of hull(model, object.surface)) {
      mapPoint(object.toWorld, point).forEach((x, axis) => {
        box[0][axis] = Math.min(box[0][axis], x);
        box[1][axis] = Math.max(box[1][axis], x);
      });
    }
  }
  return box[0][0] <= box[1][0] ? box : null;
}

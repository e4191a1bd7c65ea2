/**
 * Boxes about the surfaces of a model, each in the surface's own frame.
 *
 * @module
 */

import { dot, mapPoint } from "../linear.js";
import { patchHeader } from "../model.js";

/** @typedef {import("../linear.js").Vector} Vector */
/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("../model.js").MeshSurface} MeshSurface */
/** @typedef {import("../model.js").PatchSurface} PatchSurface */

/**
 * `half`: of the box's sides.
 * @typedef {{ middle: Vector, half: Vector }} Box
 */

/** @param {Model} model @returns {Box[]} */
export function boxesOfSurfaces(model) {
  return model.surfaces.map((surface) => {
    if (surface.kind === "mesh") return boxOfMesh(model.blocks.positions, surface);
    if (surface.kind === "algebraic") return boxBetween(surface.min, surface.max);
    return boxOfPatches(model, surface);
  });
}

/** @param {Vector} low @param {Vector} high @returns {Box} */
function boxBetween(low, high) {
  const middle = /** @type {Vector} */ (low.map((x, axis) => (x + high[axis]) / 2));
  return { middle, half: /** @type {Vector} */ (high.map((x, axis) => x - middle[axis])) };
}

/** @param {Model} model @param {PatchSurface} surface @returns {Box} */
function boxOfPatches(model, surface) {
  const { points } = model.blocks;
  const [low, high] = nothing();
  for (let patch = surface.first; patch < surface.first + surface.count; patch++) {
    const { degreeU, degreeV, firstPoint } = patchHeader(model, patch);
    const end = (firstPoint + (degreeU + 1) * (degreeV + 1)) * 4;
    for (let k = firstPoint * 4; k < end; k += 4) {
      for (let axis = 0; axis < 3; axis++) {
        low[axis] = Math.min(low[axis], points[k + axis] / points[k + 3]);
        high[axis] = Math.max(high[axis], points[k + axis] / points[k + 3]);
      }
    }
  }
  return boxBetween(low, high);
}

/** @param {Float32Array} positions @param {MeshSurface} surface @returns {Box} */
export function boxOfMesh(positions, surface) {
  const [low, high] = nothing();
  const [first, end] = [surface.firstVertex * 3, (surface.firstVertex + surface.vertices) * 3];
  for (let k = first; k < end; k++) {
    const axis = (k - first) % 3;
    low[axis] = Math.min(low[axis], positions[k]);
    high[axis] = Math.max(high[axis], positions[k]);
  }
  return boxBetween(low, high);
}

/** @returns {[Vector, Vector]} */
function nothing() {
  return [
    [Infinity, Infinity, Infinity],
    [-Infinity, -Infinity, -Infinity],
  ];
}

/**
 * Whether a plane may cut a box that is mapped to the world.
 * @param {Box} box
 * @param {ArrayLike<number>} toWorld twelve numbers
 * @param {{ normal: Vector, offset: number }} plane
 */
export function isCut({ middle, half }, toWorld, { normal, offset }) {
  const columns = [0, 3, 6].map((at) => /** @type {Vector} */ ([toWorld[at], toWorld[at + 1], toWorld[at + 2]]));
  const reach = columns.reduce((sum, column, axis) => sum + Math.abs(dot(normal, column)) * half[axis], 0);
  return Math.abs(dot(normal, mapPoint(toWorld, middle)) - offset) <= reach;
}

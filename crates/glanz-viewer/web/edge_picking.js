/**
 * Feature edges near a place of the picture.
 *
 * @module
 */

import { metresPerPixel, project } from "./camera.js";
import { isEdgeShown } from "./gl/edge_lines.js";
import { add, dot, mapPoint, scale, subtract } from "./linear.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Size} Size */
/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./model.js").Model} Model */

/** Distance up to which edges are picked, CSS pixels. */
const REACH = 6;

/** Distance behind a surface up to which an edge is in sight, pixels. */
const SIGHT = 4;

/**
 * A place on an edge. `distance`: from the place that was asked for, CSS pixels. `x`, `y`: its own.
 * @typedef {{ copy: number, edge: number, point: Vector, distance: number, x: number, y: number, depth: number }} EdgePlace
 */

/**
 * The nearest place of every edge that passes near a place of the picture, the nearest first, whether surfaces hide it or not.
 * @param {Model} model
 * @param {Camera} camera
 * @param {Size} size CSS pixels
 * @param {{ x: number, y: number }} place
 * @param {Set<number>} hidden leaves
 * @returns {EdgePlace[]}
 */
export function edgesNear(model, camera, size, { x, y }, hidden) {
  /** @type {EdgePlace[]} */
  const found = [];
  model.edgeCopies.forEach((copy, number) => {
    for (let edge = copy.first; edge < copy.first + copy.count; edge++) {
      if (!isEdgeShown(model.edges[edge], copy, hidden)) continue;
      const nearest = nearestPlace(model, camera, size, [x, y], { copy: number, edge });
      if (nearest && nearest.distance <= REACH) found.push(nearest);
    }
  });
  return found.sort((a, b) => a.distance - b.distance);
}

/**
 * The place of an edge that is nearest in the picture.
 * @param {Model} model
 * @param {Camera} camera
 * @param {Size} size
 * @param {[number, number]} place
 * @param {import("./gl/edge_lines.js").PlacedEdge} placed
 * @returns {EdgePlace | null}
 */
function nearestPlace(model, camera, size, [x, y], placed) {
  const { first, count } = model.edges[placed.edge];
  const { toWorld } = model.edgeCopies[placed.copy];
  const { edgePoints } = model.blocks;
  /** @type {EdgePlace | null} */
  let best = null;
  /** @type {Vector | null} */
  let before = null;
  for (let k = first; k < first + count; k++) {
    const point = mapPoint(toWorld, [edgePoints[3 * k], edgePoints[3 * k + 1], edgePoints[3 * k + 2]]);
    const [from, to] = [before && project(camera, size, before), project(camera, size, point)];
    if (before && from && to) {
      const [dx, dy] = [to.x - from.x, to.y - from.y];
      const along = ((x - from.x) * dx + (y - from.y) * dy) / Math.max(dx * dx + dy * dy, 1e-30);
      const t = Math.max(0, Math.min(1, along));
      const distance = Math.hypot(from.x + t * dx - x, from.y + t * dy - y);
      if (distance < (best?.distance ?? Infinity)) {
        // The share of the picture's line is not that of the line in space.
        const share = camera.kind === "perspective" ? (t * from.depth) / (t * from.depth + (1 - t) * to.depth) : t;
        const at = add(before, scale(subtract(point, before), share));
        const depth = from.depth + (to.depth - from.depth) * share;
        best = { ...placed, point: at, distance, x: from.x + t * dx, y: from.y + t * dy, depth };
      }
    }
    before = point;
  }
  return best;
}

/**
 * Whether a place of an edge is not behind the surface that is seen there.
 * @param {Camera} camera
 * @param {Size} size
 * @param {EdgePlace} place
 * @param {Vector | null} seen the surface's point, `null` if there is none
 */
export function isInSight(camera, size, place, seen) {
  if (seen === null) return true;
  const depth = dot(subtract(seen, camera.position), camera.forward);
  return place.depth <= depth + SIGHT * metresPerPixel(camera, size, depth);
}

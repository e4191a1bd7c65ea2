/**
 * Feature edges near a place of the picture.
 *
 * @module
 */

import { metresPerPixel, project } from "./camera.js";
import { isEdgeShown } from "./gl/edge_lines.js";
import { add, dot, length, mapPoint, scale, similarityFactor, subtract } from "./linear.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Size} Size */
/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./model.js").Model} Model */
/** @typedef {import("./settings.js").Plane} Plane */
/** @typedef {import("./gl/edge_lines.js").PlacedEdge} PlacedEdge */

/** Distance up to which edges are picked, CSS pixels. */
const REACH = 6;

/** Distance behind a surface up to which an edge is in sight, pixels. */
const SIGHT = 4;

/** Depth of the part of a segment that is picked, as a share of its farther end's: what is nearer in perspective has no place in the picture. */
const NEAREST = 1e-6;

/**
 * A place on an edge. `distance`: from the place that was asked for, CSS pixels. `x`, `y`: its own.
 * @typedef {{ copy: number, edge: number, point: Vector, distance: number, x: number, y: number, depth: number }} EdgePlace
 */

/**
 * The nearest place of every edge that passes near a place of the picture, the nearest first, whether surfaces hide it or not. What is cut away is left out.
 * @param {Model} model
 * @param {Camera} camera
 * @param {Size} size CSS pixels
 * @param {{ x: number, y: number }} place
 * @param {Set<number>} hidden leaves
 * @param {Plane | null} section
 * @returns {EdgePlace[]}
 */
export function edgesNear(model, camera, size, { x, y }, hidden, section) {
  /** @type {EdgePlace[]} */
  const found = [];
  model.edgeCopies.forEach((copy, number) => {
    for (let edge = copy.first; edge < copy.first + copy.count; edge++) {
      if (!isEdgeShown(model.edges[edge], copy, hidden)) continue;
      const nearest = nearestPlace(model, camera, size, [x, y], { copy: number, edge }, section);
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
 * @param {PlacedEdge} placed
 * @param {Plane | null} section
 * @returns {EdgePlace | null}
 */
function nearestPlace(model, camera, size, [x, y], placed, section) {
  const { first, count } = model.edges[placed.edge];
  const { toWorld } = model.edgeCopies[placed.copy];
  const { edgePoints } = model.blocks;
  /** @type {EdgePlace | null} */
  let best = null;
  /** @type {Vector | null} */
  let before = null;
  for (let k = first; k < first + count; k++) {
    const point = mapPoint(toWorld, [edgePoints[3 * k], edgePoints[3 * k + 1], edgePoints[3 * k + 2]]);
    const part = before && visiblePart(before, point, camera, section);
    before = point;
    if (!part) continue;
    const [from, to] = [project(camera, size, part[0]), project(camera, size, part[1])];
    if (from && to) {
      const [dx, dy] = [to.x - from.x, to.y - from.y];
      const along = ((x - from.x) * dx + (y - from.y) * dy) / Math.max(dx * dx + dy * dy, 1e-30);
      const t = Math.max(0, Math.min(1, along));
      const distance = Math.hypot(from.x + t * dx - x, from.y + t * dy - y);
      if (distance < (best?.distance ?? Infinity)) {
        // The share of the picture's line is not that of the line in space.
        const share = camera.kind === "perspective" ? (t * from.depth) / (t * from.depth + (1 - t) * to.depth) : t;
        const at = add(part[0], scale(subtract(part[1], part[0]), share));
        const depth = from.depth + (to.depth - from.depth) * share;
        best = { ...placed, point: at, distance, x: from.x + t * dx, y: from.y + t * dy, depth };
      }
    }
  }
  return best;
}

/**
 * The part of a segment that is before the camera and not cut away.
 * @param {Vector} from
 * @param {Vector} to
 * @param {Camera} camera
 * @param {Plane | null} section
 * @returns {[Vector, Vector] | null}
 */
function visiblePart(from, to, camera, section) {
  /** @type {[Vector, Vector] | null} */
  let part = [from, to];
  if (section) part = kept(part, (p) => section.offset - dot(section.normal, p));
  if (!part || camera.kind === "orthographic") return part;
  const depth = (/** @type {Vector} */ p) => dot(subtract(p, camera.position), camera.forward);
  const farthest = Math.max(depth(part[0]), depth(part[1]));
  return farthest > 0 ? kept(part, (p) => depth(p) - NEAREST * farthest) : null;
}

/**
 * The part of a segment where an affine function is not negative.
 * @param {[Vector, Vector]} segment
 * @param {(point: Vector) => number} value
 * @returns {[Vector, Vector] | null}
 */
function kept([from, to], value) {
  const [a, b] = [value(from), value(to)];
  if (a < 0 && b < 0) return null;
  if (a >= 0 && b >= 0) return [from, to];
  const border = add(from, scale(subtract(to, from), a / (a - b)));
  return a < 0 ? [border, to] : [from, border];
}

/**
 * What is known of an edge of a copy, in the world. Where the copy is not enlarged the same in all directions, radii and angle are unknown, and the length of a
 * curve is that of the line through its points. `isExact`: whether it is that of the curve. `angle`: between the normals of its faces.
 * @typedef {{ kind: import("./model.js").Edge["kind"], length: number, isExact: boolean, radii: number[], angle: number | null }} EdgeDimensions
 */

/**
 * Lengths and angle of an edge of a copy.
 * @param {Model} model
 * @param {PlacedEdge} placed
 * @returns {EdgeDimensions}
 */
export function edgeDimensions(model, placed) {
  const { toWorld } = model.edgeCopies[placed.copy];
  const { first, count, kind, radii, angle, ...edge } = model.edges[placed.edge];
  const factor = similarityFactor(toWorld);
  if (factor !== null) {
    return { kind, length: factor * edge.length, isExact: true, radii: radii.map((r) => factor * r), angle };
  }
  const { edgePoints } = model.blocks;
  const point = (/** @type {number} */ k) =>
    mapPoint(toWorld, [edgePoints[3 * k], edgePoints[3 * k + 1], edgePoints[3 * k + 2]]);
  let sum = 0;
  for (let k = first + 1; k < first + count; k++) sum += length(subtract(point(k), point(k - 1)));
  const isExact = kind === "line";
  return { kind: kind === "circle" ? "ellipse" : kind, length: sum, isExact, radii: [], angle: null };
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

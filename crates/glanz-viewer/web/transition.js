/**
 * The way from one camera to another.
 *
 * @module
 */

import { focus, rotated, rotationInPlane } from "./camera.js";
import { add, cross, length, normalize, scale, subtract } from "./linear.js";

/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./camera.js").Camera} Camera */

/**
 * A camera on the way from one to another; they must be of the same kind and handedness.
 * @param {Camera} from
 * @param {Camera} to
 * @param {number} share 0: `from`, 1: `to`
 * @returns {Camera}
 */
export function between(from, to, share) {
  if (share >= 1) {
    return to;
  }
  const rotation = rotationBetween(from, to, share);
  /** @param {number} a @param {number} b sizes change by equal factors in equal times */
  const geometric = (a, b) => a * (b / a) ** share;
  const distance = geometric(from.distance, to.distance);
  const [start, end] = [focus(from), focus(to)];
  const turned = rotated(from, from.position, rotation);
  const target = add(start, scale(subtract(end, start), share));
  return {
    ...to,
    right: turned.right,
    up: turned.up,
    forward: turned.forward,
    distance,
    height: geometric(from.height, to.height),
    position: subtract(target, scale(turned.forward, distance)),
  };
}

/**
 * A share of the rotation about one axis that turns the axes of one camera into those of another.
 * @param {Camera} from
 * @param {Camera} to
 * @param {number} share
 * @returns {(vector: Vector) => Vector}
 */
function rotationBetween(from, to, share) {
  /** @type {["right", "up", "forward"]} */
  const names = ["right", "up", "forward"];
  /** @param {number} i @param {number} j element of the rotation matrix: sum of outer products of new and old axes */
  const element = (i, j) => names.reduce((sum, name) => sum + to[name][i] * from[name][j], 0);
  const cos = Math.max(-1, Math.min(1, (element(0, 0) + element(1, 1) + element(2, 2) - 1) / 2));
  /** @type {Vector} twice the sine of the angle, along the axis */
  const skew = [element(2, 1) - element(1, 2), element(0, 2) - element(2, 0), element(1, 0) - element(0, 1)];
  const angle = Math.atan2(length(skew) / 2, cos);
  if (angle < 1e-12) {
    return (vector) => vector;
  }
  const axis = length(skew) > 1e-6 ? normalize(skew) : halfTurnAxis(element);
  // Two directions at right angles to the axis span the plane of the rotation.
  /** @type {Vector} */
  const aside = Math.abs(axis[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0];
  const first = normalize(cross(axis, aside));
  return rotationInPlane(first, cross(axis, first), angle * share);
}

/**
 * The axis of a rotation by half a turn: (R + 1) / 2 is the product of the axis with itself.
 * @param {(i: number, j: number) => number} element
 * @returns {Vector}
 */
function halfTurnAxis(element) {
  const column = [0, 1, 2].reduce((best, i) => (element(i, i) > element(best, best) ? i : best), 0);
  /** @param {number} i */
  const entry = (i) => element(i, column) + (i === column ? 1 : 0);
  return normalize([entry(0), entry(1), entry(2)]);
}

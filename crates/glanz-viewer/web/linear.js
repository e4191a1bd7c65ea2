/**
 * Vectors in double precision.
 *
 * @module
 */

/** @typedef {[number, number, number]} Vector */

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export function add(a, b) {
  return [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
}

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export function subtract(a, b) {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** @param {Vector} a @param {number} factor @returns {Vector} */
export function scale(a, factor) {
  return [a[0] * factor, a[1] * factor, a[2] * factor];
}

/** @param {Vector} a @param {Vector} b */
export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** @param {Vector} a */
export function length(a) {
  return Math.hypot(a[0], a[1], a[2]);
}

/** @param {Vector} a not zero @returns {Vector} */
export function normalize(a) {
  return scale(a, 1 / length(a));
}

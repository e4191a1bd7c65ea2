/**
 * Vectors and matrices in double precision.
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

/**
 * An affine map: columns of a 3 x 3 matrix, then the image of the origin.
 * @typedef {ArrayLike<number>} Affine twelve numbers
 */

/** @param {Affine} map @param {Vector} p @returns {Vector} */
export function mapPoint(map, p) {
  return add(mapDirection(map, p), [map[9], map[10], map[11]]);
}

/** @param {Affine} map @param {Vector} d @returns {Vector} */
export function mapDirection(map, d) {
  return [
    map[0] * d[0] + map[3] * d[1] + map[6] * d[2],
    map[1] * d[0] + map[4] * d[1] + map[7] * d[2],
    map[2] * d[0] + map[5] * d[1] + map[8] * d[2],
  ];
}

/** Relative difference of lengths, and cosine of right angles, that are so up to rounding. */
const ROUNDING = 1e-9;

/**
 * The factor by which a map enlarges, `null` if it is not the same in all directions.
 * @param {Affine} map
 */
export function similarityFactor(map) {
  const [a, b, c] = [0, 3, 6].map((at) => /** @type {Vector} */ ([map[at], map[at + 1], map[at + 2]]));
  const square = dot(a, a);
  const off = [dot(b, b) - square, dot(c, c) - square, dot(a, b), dot(b, c), dot(c, a)];
  return off.every((x) => Math.abs(x) <= ROUNDING * square) ? Math.sqrt(square) : null;
}

/**
 * A bound on the factor by which a map lengthens: the largest eigenvalue of M^T M is at most its largest sum of absolute values in a row.
 * @param {Affine} map
 */
export function largestStretch(map) {
  const columns = [0, 3, 6].map((at) => /** @type {Vector} */ ([map[at], map[at + 1], map[at + 2]]));
  const sums = columns.map((a) => columns.reduce((sum, b) => sum + Math.abs(dot(a, b)), 0));
  return Math.sqrt(Math.max(...sums));
}

/**
 * Rows of the inverse of a map's matrix, or null if it flattens.
 * @param {Affine} map
 * @returns {[Vector, Vector, Vector] | null}
 */
export function inverseRows(map) {
  const [a, b, c] = [0, 3, 6].map((at) => /** @type {Vector} */ ([map[at], map[at + 1], map[at + 2]]));
  const determinant = dot(a, cross(b, c));
  if (!(Math.abs(determinant) > 0)) return null;
  return [
    scale(cross(b, c), 1 / determinant),
    scale(cross(c, a), 1 / determinant),
    scale(cross(a, b), 1 / determinant),
  ];
}

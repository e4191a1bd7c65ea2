/**
 * Deviation of a surface from its tangent plane, estimated from second derivatives at sample parameters.
 *
 * Second derivatives have a part along the surface, which only says how its parameters run; triangles with corners on it are off by the other part.
 *
 * @module
 */

/** Sample parameters: near the sides of a patch, but not on them, because a side may be a point. */
const PLACES = [0.02, 0.25, 0.5, 0.75, 0.98];

/** Second derivatives between the places are taken to be at most this many times as large. */
const SAFETY = 1.5;

/** Bernstein polynomials with first and second derivatives at \`PLACES\`, by degree. @type {Map<number, number[][][]>} */
const BASES = new Map();

/**
 * For every place: values, first and second derivatives of the Bernstein polynomials of a degree.
 * @param {number} degree
 * @returns {number[][][]}
 */
function basesOf(degree) {
  let bases = BASES.get(degree);
  if (!bases) {
    bases = PLACES.map((t) => {
      const first = differences(bernstein(degree - 1, t), degree);
      const second =
        degree < 2 ? first.map(() => 0) : differences(differences(bernstein(degree - 2, t), degree - 1), degree);
      return [bernstein(degree, t), first, second];
    });
    BASES.set(degree, bases);
  }
  return bases;
}

/**
 * The Bernstein polynomials of a degree at t.
 * @param {number} degree
 * @param {number} t
 */
export function bernstein(degree, t) {
  const values = [1];
  for (let n = 1; n <= degree; n++) {
    values.push(0);
    for (let k = n; k >= 0; k--) values[k] = (1 - t) * values[k] + (k > 0 ? t * values[k - 1] : 0);
  }
  return values;
}

/** From values of a degree less one to derivatives: n (B[k - 1] - B[k]). @param {number[]} values @param {number} degree */
function differences(values, degree) {
  return Array.from({ length: values.length + 1 }, (_, k) => degree * ((values[k - 1] ?? 0) - (values[k] ?? 0)));
}

/** Homogeneous sums of control points: the point, and its derivatives in the order u, v, uu, uv, vv. */
const ORDERS = [
  [0, 0],
  [1, 0],
  [0, 1],
  [2, 0],
  [1, 1],
  [0, 2],
];

/** Scratch: six vectors with weights. */
const sums = new Float64Array(24);

/**
 * Point and derivatives of a rational patch at two of the places, as plain vectors in `sums`.
 * @param {Float32Array} points
 * @param {{ first: number, stepU: number, stepV: number, degreeU: number, degreeV: number }} net
 * @param {number} placeU
 * @param {number} placeV
 */
function evaluate(points, { first, stepU, stepV, degreeU, degreeV }, placeU, placeV) {
  const basesU = basesOf(degreeU)[placeU];
  const basesV = degreeV === 0 ? [[1], [0], [0]] : basesOf(degreeV)[placeV];
  sums.fill(0);
  for (let i = 0; i <= degreeU; i++) {
    for (let j = 0; j <= degreeV; j++) {
      const at = (first + i * stepU + j * stepV) * 4;
      for (let order = 0; order < 6; order++) {
        const factor = basesU[ORDERS[order][0]][i] * basesV[ORDERS[order][1]][j];
        for (let axis = 0; axis < 4; axis++) sums[4 * order + axis] += factor * points[at + axis];
      }
    }
  }
  // The quotient rule, from lower to higher derivatives.
  const w = [0, 1, 2, 3, 4, 5].map((order) => sums[4 * order + 3]);
  for (let axis = 0; axis < 3; axis++) {
    const s = (sums[axis] /= w[0]);
    const su = (sums[4 + axis] = (sums[4 + axis] - w[1] * s) / w[0]);
    const sv = (sums[8 + axis] = (sums[8 + axis] - w[2] * s) / w[0]);
    sums[12 + axis] = (sums[12 + axis] - 2 * w[1] * su - w[3] * s) / w[0];
    sums[16 + axis] = (sums[16 + axis] - w[1] * sv - w[2] * su - w[4] * s) / w[0];
    sums[20 + axis] = (sums[20 + axis] - 2 * w[2] * sv - w[5] * s) / w[0];
  }
}

/**
 * The largest parts along the normal of the second derivatives of a patch: along u, mixed, along v.
 * @param {Float32Array} points
 * @param {{ first: number, stepU: number, stepV: number, degreeU: number, degreeV: number }} net
 * @returns {[number, number, number]}
 */
export function normalDeviation(points, net) {
  /** @type {[number, number, number]} */
  const largest = [0, 0, 0];
  for (let i = 0; i < PLACES.length; i++) {
    for (let j = 0; j < PLACES.length; j++) {
      evaluate(points, net, i, j);
      const x = sums[5] * sums[10] - sums[6] * sums[9];
      const y = sums[6] * sums[8] - sums[4] * sums[10];
      const z = sums[4] * sums[9] - sums[5] * sums[8];
      const area = Math.hypot(x, y, z);
      for (let k = 0; k < 3; k++) {
        const at = 12 + 4 * k;
        const off = Math.abs(x * sums[at] + y * sums[at + 1] + z * sums[at + 2]) / area;
        // Where there is no normal nothing is known: the bound of the control points holds.
        largest[k] = Math.max(largest[k], area > 0 ? SAFETY * off : Infinity);
      }
    }
  }
  return largest;
}

/**
 * The largest part across a curve of its second derivative.
 * @param {Float32Array} points
 * @param {{ first: number, stepU: number, stepV: number, degreeU: number, degreeV: number }} curve a net with degree 0 along v
 */
export function curveDeviation(points, curve) {
  let largest = 0;
  for (let i = 0; i < PLACES.length; i++) {
    evaluate(points, curve, i, 0);
    const [a, b, c, , , , , , d, e, f] = sums.subarray(4, 16);
    const speed = Math.hypot(a, b, c);
    const across = Math.hypot(b * f - c * e, c * d - a * f, a * e - b * d);
    largest = Math.max(largest, speed > 0 ? (SAFETY * across) / speed : Infinity);
  }
  return largest;
}

/**
 * Parts of patches: where they lie, which of them are in sight.
 *
 * @module
 */

import { patchFacts } from "../model.js";
import { STRIDE } from "./measures.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./frame.js").Frame} Frame */

/** Parts of a patch are looked at in this many steps of halving, to tell how near it comes. */
const LOOKS = 2;

export class Pieces {
  /**
   * @param {Model} model
   * @param {Float64Array} measures of `measurePatches`
   */
  constructor(model, measures) {
    this.model = model;
    this.measures = measures;
    /** What `inSight` found: numbers of parts along u and v, and their depths. */
    this.found = 0;
    this.cells = new Uint16Array(0);
    this.nearest = new Float32Array(0);
    /** Scratch: corners and the sphere about them. */
    this.corner = new Float64Array(3);
    this.sphere = new Float64Array(4);
  }

  /**
   * The depths of what is in sight of a patch that is near: nearest, farthest, and the nearest to count pixels with, above 0.
   * @param {Frame} frame
   * @param {Float64Array} places
   * @param {number} object
   * @param {number} stretch
   * @param {number} patch
   * @returns {[number, number, number] | null} null if nothing is in sight
   */
  depthRange(frame, places, object, stretch, patch) {
    let near = Infinity;
    let far = -Infinity;
    let least = Infinity;
    const parts = 1 << LOOKS;
    for (let i = 0; i < parts; i++) {
      for (let j = 0; j < parts; j++) {
        this.locate(patch, i / parts, j / parts, 1 / parts, 1 / parts);
        if (!this.isInSight(frame, places, object, stretch)) continue;
        const { sphere } = this;
        near = Math.min(near, sphere[2] - sphere[3]);
        far = Math.max(far, sphere[2] + sphere[3]);
        least = Math.min(least, Math.max(sphere[2] - sphere[3], 0.05 * sphere[3]));
      }
    }
    return near === Infinity ? null : [near, far, least];
  }

  /**
   * Finds those of 2^partsU x 2^partsV parts that are in sight.
   * @param {Frame} frame
   * @param {Float64Array} places
   * @param {number} object
   * @param {number} stretch
   * @param {number} patch
   * @param {number} partsU
   * @param {number} partsV
   * @param {number} most
   * @returns {boolean} false if there are more than `most` and it could be fewer
   */
  inSight(frame, places, object, stretch, patch, partsU, partsV, most) {
    this.found = 0;
    if (this.nearest.length < most) {
      this.nearest = new Float32Array(most);
      this.cells = new Uint16Array(2 * most);
    }
    const deepest = Math.max(partsU, partsV);
    /** @param {number} depth @param {number} i @param {number} j @returns {boolean} */
    const descend = (depth, i, j) => {
      const [depthU, depthV] = [Math.min(depth, partsU), Math.min(depth, partsV)];
      const [sizeU, sizeV] = [2 ** -depthU, 2 ** -depthV];
      this.locate(patch, i * sizeU, j * sizeV, sizeU, sizeV);
      if (!this.isInSight(frame, places, object, stretch)) return true;
      if (depth === deepest) {
        if (this.found === most) return false;
        this.cells[2 * this.found] = i;
        this.cells[2 * this.found + 1] = j;
        this.nearest[this.found++] = this.sphere[2] - this.sphere[3];
        return true;
      }
      const [stepsU, stepsV] = [depth < partsU ? 2 : 1, depth < partsV ? 2 : 1];
      for (let a = 0; a < stepsU; a++) {
        for (let b = 0; b < stepsV; b++) if (!descend(depth + 1, i * stepsU + a, j * stepsV + b)) return false;
      }
      return true;
    };
    return descend(0, 0, 0);
  }

  /**
   * A sphere about a part of a patch, in the surface's own frame: about its corners, as much larger as it bends.
   * @param {number} patch
   * @param {number} u0
   * @param {number} v0
   * @param {number} sizeU
   * @param {number} sizeV
   */
  locate(patch, u0, v0, sizeU, sizeV) {
    const { corner, sphere, measures } = this;
    sphere.fill(0);
    for (let k = 0; k < 4; k++) {
      this.evaluate(patch, u0 + (k & 1) * sizeU, v0 + (k >> 1) * sizeV);
      for (let axis = 0; axis < 3; axis++) sphere[axis] += corner[axis] / 4;
    }
    for (let k = 0; k < 4; k++) {
      this.evaluate(patch, u0 + (k & 1) * sizeU, v0 + (k >> 1) * sizeV);
      const distance = Math.hypot(corner[0] - sphere[0], corner[1] - sphere[1], corner[2] - sphere[2]);
      sphere[3] = Math.max(sphere[3], distance);
    }
    const at = patch * STRIDE;
    const { 4: uu, 5: uv, 6: vv } = measures.subarray(at, at + 7);
    sphere[3] += (uu * sizeU * sizeU + 2 * uv * sizeU * sizeV + vv * sizeV * sizeV) / 8;
  }

  /** Moves the sphere to the camera. @param {Frame} frame @param {Float64Array} places @param {number} object @param {number} stretch */
  isInSight(frame, places, object, stretch) {
    const { sphere } = this;
    const m = 12 * object;
    const [x, y, z] = sphere;
    for (let row = 0; row < 3; row++) {
      sphere[row] = places[m + row] * x + places[m + 3 + row] * y + places[m + 6 + row] * z + places[m + 9 + row];
    }
    sphere[3] *= stretch;
    return frame.sees(sphere[0], sphere[1], sphere[2], sphere[3]);
  }

  /** The point of a patch at (u, v), into `corner`. @param {number} patch @param {number} u @param {number} v */
  evaluate(patch, u, v) {
    const { degreeU, degreeV, firstPoint } = patchFacts(this.model, patch);
    const { points } = this.model.blocks;
    const [bernsteinU, bernsteinV] = [bernstein(degreeU, u), bernstein(degreeV, v)];
    let [x, y, z, w] = [0, 0, 0, 0];
    for (let i = 0; i <= degreeU; i++) {
      for (let j = 0; j <= degreeV; j++) {
        const at = (firstPoint + i * (degreeV + 1) + j) * 4;
        const factor = bernsteinU[i] * bernsteinV[j];
        x += factor * points[at];
        y += factor * points[at + 1];
        z += factor * points[at + 2];
        w += factor * points[at + 3];
      }
    }
    this.corner[0] = x / w;
    this.corner[1] = y / w;
    this.corner[2] = z / w;
  }
}

/**
 * The Bernstein polynomials of a degree at t.
 * @param {number} degree
 * @param {number} t
 */
function bernstein(degree, t) {
  const values = [1];
  for (let n = 1; n <= degree; n++) {
    values.push(0);
    for (let k = n; k >= 0; k--) values[k] = (1 - t) * values[k] + (k > 0 ? t * values[k - 1] : 0);
  }
  return values;
}

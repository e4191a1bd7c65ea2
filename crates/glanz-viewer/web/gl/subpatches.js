/**
 * Subpatches: where they lie, and which of them are in view.
 *
 * @module
 */

import { patchHeader } from "../model.js";
import { bernstein } from "./deviation.js";
import { FINEST, LARGEST_GRID } from "./grid_levels.js";
import { BOUNDS, STRIDE } from "./patch_bounds.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./frame.js").Frame} Frame */

/** Number of bisections along each parameter with which the depth range of a near patch is found. */
const DEPTH_LEVELS = 2;

/** Subpatches that are partly in view are halved down to 2^4 cells along a side. */
const SMALLEST_GRID = 4;

/** Largest number of subpatches of one patch that are drawn. */
const MOST = 128;

export class Subpatches {
  /**
   * @param {Model} model
   * @param {Float64Array} measures of `boundPatches`
   */
  constructor(model, measures) {
    this.model = model;
    this.patchBounds = measures;
    /** Result of `inSight`: first cell along u and v and levels of every subpatch, and its depth. */
    this.found = 0;
    this.parts = new Uint16Array(4 * MOST);
    this.depths = new Float32Array(MOST);
    /** Scratch: corners and the sphere about them. */
    this.corner = new Float64Array(3);
    this.sphere = new Float64Array(4);
  }

  /**
   * Depth range of the visible subpatches of a near patch: nearest, farthest, and the nearest positive depth for the pixel size.
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
    const parts = 1 << DEPTH_LEVELS;
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
   * Cuts a grid into parts that are in sight, by halving what is only partly so.
   * @param {Frame} frame
   * @param {Float64Array} places
   * @param {number} object
   * @param {number} stretch
   * @param {number} patch
   * @param {number} levelU of the whole grid
   * @param {number} levelV
   * @param {number} sides levels of the sides, as in `INSTANCE_WORDS`
   * @returns {boolean} false if there are more parts than `MOST`
   */
  inSight(frame, places, object, stretch, patch, levelU, levelV, sides) {
    this.found = 0;
    /** @param {number} gridU level of the part @param {number} gridV @param {number} i number of the part @param {number} j @returns {boolean} */
    const descend = (gridU, gridV, i, j) => {
      const sizeU = 2 ** (gridU - levelU);
      const sizeV = 2 ** (gridV - levelV);
      const u = range(i, sizeU, j === 0 ? sides >> 8 : FINEST, (j + 1) * sizeV === 1 ? sides >> 12 : FINEST);
      const v = range(j, sizeV, i === 0 ? sides >> 16 : FINEST, (i + 1) * sizeU === 1 ? sides >> 20 : FINEST);
      this.locate(patch, u[0], v[0], u[1] - u[0], v[1] - v[0]);
      if (!this.isInSight(frame, places, object, stretch)) return true;
      const { 0: x, 1: y, 2: z, 3: radius } = this.sphere;
      const smallest = frame.contains(x, y, z, radius) ? LARGEST_GRID : SMALLEST_GRID;
      const stepsU = gridU > smallest ? 2 : 1;
      const stepsV = gridV > smallest ? 2 : 1;
      if (stepsU === 1 && stepsV === 1) return this.keep(i << gridU, j << gridV, gridU, gridV, z - radius);
      for (let a = 0; a < stepsU; a++) {
        for (let b = 0; b < stepsV; b++) {
          if (!descend(gridU + 1 - stepsU, gridV + 1 - stepsV, i * stepsU + a, j * stepsV + b)) return false;
        }
      }
      return true;
    };
    return descend(levelU, levelV, 0, 0);
  }

  /** @param {number} cellU @param {number} cellV @param {number} gridU @param {number} gridV @param {number} depth */
  keep(cellU, cellV, gridU, gridV, depth) {
    if (this.found === MOST) return false;
    this.parts.set([cellU, cellV, gridU, gridV], 4 * this.found);
    this.depths[this.found] = depth;
    this.found += 1;
    return true;
  }

  /**
   * Bounding sphere of a subpatch in the surface's frame: about its corners, enlarged by the bound on its curvature.
   * @param {number} patch
   * @param {number} u0
   * @param {number} v0
   * @param {number} sizeU
   * @param {number} sizeV
   */
  locate(patch, u0, v0, sizeU, sizeV) {
    const { corner, sphere, patchBounds } = this;
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
    const at = patch * STRIDE + BOUNDS;
    const [uu, uv, vv] = patchBounds.subarray(at, at + 3);
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
    const { degreeU, degreeV, firstPoint } = patchHeader(this.model, patch);
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
 * Range that a subpatch draws along one direction: its own, and at a side of the patch whole segments of that side's grid.
 * @param {number} number of the part
 * @param {number} size
 * @param {number} lowSide level of the side that it lies at, in the lowest four bits
 * @param {number} highSide
 * @returns {[number, number]}
 */
function range(number, size, lowSide, highSide) {
  const count = 2 ** Math.min(lowSide & 15, highSide & 15);
  return [Math.floor(number * size * count) / count, Math.ceil((number + 1) * size * count) / count];
}

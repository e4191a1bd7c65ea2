/**
 * Bounds of patches that do not depend on the view: spheres, deviation from flatness, border sides.
 *
 * @module
 */

import { patchHeader } from "../model.js";
import { curveDeviation, normalDeviation } from "./deviation.js";

/** @typedef {import("../model.js").Model} Model */

/** Parameters of a region that count as its border. */
const AT_BORDER = 1e-5;

/** Floats per patch: sphere (4), deviation along u, mixed, along v (3), `SIDE` numbers for each of four sides, bounds on the second derivatives (3). */
export const STRIDE = 30;

/** Offset of the bounds on the second derivatives. */
export const BOUNDS = 27;

/** Parameters are found again at every pixel: there the grid may be off by this many times the tolerance. */
const ALONG = 32;

/** Floats per side: sphere (4), deviation. */
export const SIDE = 5;

/** Offset of the first side. Sides: v = 0, v = 1, u = 0, u = 1. */
export const SIDES = 7;

/**
 * The measures of all patches of a model, `STRIDE` numbers each.
 *
 * A chord over a parameter range h is nowhere farther from its curve than h^2 / 8 times a bound on the second derivative (@filip1986). For rational curves
 * H = (w p, w): a chord joins the same points as the chord of H, whose error (E, e) is at most h^2 / 8 times the second derivatives of H; the point differs from
 * the chord's by (E - p e) / w, with p counted from the middle of the points (after @zheng2000). Bending is the part of that across the surface, or
 * the curve, as far as a few places tell, but at least 1 / `ALONG` of the bound.
 * @param {Model} model
 * @returns {Float64Array}
 */
export function boundPatches(model) {
  const count = model.blocks.patches.length / 16;
  const measures = new Float64Array(count * STRIDE);
  for (let patch = 0; patch < count; patch++) {
    const { degreeU, degreeV, firstPoint } = patchHeader(model, patch);
    const net = new Net(model.blocks.points, firstPoint, degreeV + 1, 1);
    const at = patch * STRIDE;
    const { radius, lightest } = net.measureSphere(measures, at, degreeU + 1, degreeV + 1);
    const bend = (/** @type {number} */ du, /** @type {number} */ dv) =>
      net.bending(measures, at, degreeU, degreeV, du, dv, radius, lightest);
    const bounds = [bend(2, 0), bend(1, 1), bend(0, 2)];
    measures.set(bounds, at + BOUNDS);
    const across = normalDeviation(model.blocks.points, net.shape(degreeU, degreeV));
    for (let k = 0; k < 3; k++) measures[at + 4 + k] = Math.max(Math.min(across[k], bounds[k]), bounds[k] / ALONG);
    boundSides(model, patch, measures);
  }
  return measures;
}

/** @param {Model} model @param {number} patch @param {Float64Array} measures */
function boundSides(model, patch, measures) {
  for (let side = 0; side < 4; side++) {
    const { first, step, degree } = sidePoints(model, patch, side);
    const at = patch * STRIDE + SIDES + side * SIDE;
    const net = new Net(model.blocks.points, first, step, 0);
    const { radius, lightest } = net.measureSphere(measures, at, degree + 1, 1);
    const bound = net.bending(measures, at, degree, 0, 2, 0, radius, lightest);
    const across = curveDeviation(model.blocks.points, net.shape(degree, 0));
    // Single precision, so that the same curve in the other direction rounds alike.
    measures[at + 4] = Math.fround(Math.max(Math.min(across, bound), bound / ALONG));
  }
}

/**
 * Indices of the control points of a side.
 * @param {Model} model
 * @param {number} patch
 * @param {number} side 0 to 3: v = 0, v = 1, u = 0, u = 1
 */
export function sidePoints(model, patch, side) {
  const { degreeU, degreeV, firstPoint } = patchHeader(model, patch);
  const row = degreeV + 1;
  switch (side) {
    case 0:
      return { first: firstPoint, step: row, degree: degreeU };
    case 1:
      return { first: firstPoint + degreeV, step: row, degree: degreeU };
    case 2:
      return { first: firstPoint, step: 1, degree: degreeV };
    default:
      return { first: firstPoint + degreeU * row, step: 1, degree: degreeV };
  }
}

/** A net of homogeneous control points within a block. */
class Net {
  /**
   * @param {Float32Array} points
   * @param {number} first
   * @param {number} stepU from point to point along u
   * @param {number} stepV along v
   */
  constructor(points, first, stepU, stepV) {
    this.points = points;
    this.first = first;
    this.stepU = stepU;
    this.stepV = stepV;
    /** Scratch: one homogeneous vector. */
    this.sum = new Float64Array(4);
  }

  /** @param {number} degreeU @param {number} degreeV */
  shape(degreeU, degreeV) {
    return { first: this.first, stepU: this.stepU, stepV: this.stepV, degreeU, degreeV };
  }

  /**
   * Writes a sphere about the points (middle of their box, radius). The same bits come out when they are read backwards.
   * @param {Float64Array} out
   * @param {number} at
   * @param {number} countU
   * @param {number} countV
   * @returns {{ radius: number, lightest: number }} with the smallest weight
   */
  measureSphere(out, at, countU, countV) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    let lightest = Infinity;
    this.each(countU, countV, (k) => {
      const weight = this.points[k + 3];
      lightest = Math.min(lightest, weight);
      for (let axis = 0; axis < 3; axis++) {
        const x = this.points[k + axis] / weight;
        low[axis] = Math.min(low[axis], x);
        high[axis] = Math.max(high[axis], x);
      }
    });
    for (let axis = 0; axis < 3; axis++) out[at + axis] = (low[axis] + high[axis]) / 2;
    let square = 0;
    this.each(countU, countV, (k) => {
      const weight = this.points[k + 3];
      let sum = 0;
      for (let axis = 0; axis < 3; axis++) sum += (this.points[k + axis] / weight - out[at + axis]) ** 2;
      square = Math.max(square, sum);
    });
    out[at + 3] = Math.sqrt(square);
    return { radius: out[at + 3], lightest };
  }

  /** @param {number} countU @param {number} countV @param {(k: number) => void} visit with the place of a point's first number */
  each(countU, countV, visit) {
    for (let i = 0; i < countU; i++) {
      for (let j = 0; j < countV; j++) visit((this.first + i * this.stepU + j * this.stepV) * 4);
    }
  }

  /**
   * Bound on a second derivative of the surface, as described at `boundPatches`.
   * @param {Float64Array} middle point that the vectors are counted from, at
   * @param {number} at
   * @param {number} degreeU
   * @param {number} degreeV
   * @param {number} du order of the derivative along u
   * @param {number} dv along v
   * @param {number} radius largest distance of a point from the middle
   * @param {number} lightest smallest weight
   */
  bending(middle, at, degreeU, degreeV, du, dv, radius, lightest) {
    if (degreeU < du || degreeV < dv) return 0;
    let longest = 0;
    let heaviest = 0;
    this.each(degreeU + 1 - du, degreeV + 1 - dv, (k) => {
      this.difference(k, du, dv);
      const weight = this.sum[3];
      let square = 0;
      for (let axis = 0; axis < 3; axis++) square += (this.sum[axis] - middle[at + axis] * weight) ** 2;
      longest = Math.max(longest, square);
      heaviest = Math.max(heaviest, Math.abs(weight));
    });
    const factor = du === 1 ? degreeU * degreeV : du === 2 ? degreeU * (degreeU - 1) : degreeV * (degreeV - 1);
    return (factor * (Math.sqrt(longest) + radius * heaviest)) / lightest;
  }

  /** Second difference of the points beginning at k, into `sum`; symmetric, so that it reads the same backwards. @param {number} k @param {number} du @param {number} dv */
  difference(k, du, dv) {
    const [u, v] = [this.stepU * 4, this.stepV * 4];
    for (let axis = 0; axis < 4; axis++) {
      const p = (/** @type {number} */ offset) => this.points[k + axis + offset];
      if (du === 2) this.sum[axis] = p(0) + p(2 * u) - 2 * p(u);
      else if (dv === 2) this.sum[axis] = p(0) + p(2 * v) - 2 * p(v);
      else this.sum[axis] = p(0) + p(u + v) - (p(u) + p(v));
    }
  }
}

/**
 * Which sides of patches are borders of their surface: one bit per side. A side that another patch of the surface has too, or that is only a point, is none; nor is a side within the
 * region of a trimmed surface, whose patches may have been cut.
 * @param {Model} model
 * @returns {Uint8Array}
 */
export function findBorders(model) {
  const borders = new Uint8Array(model.blocks.patches.length / 16);
  /** @type {Map<string, { patch: number, side: number, count: number }>} */
  const seen = new Map();
  model.surfaces.forEach((surface, number) => {
    if (surface.kind !== "patches") return;
    for (let patch = surface.first; patch < surface.first + surface.count; patch++) {
      for (let side = 0; side < 4; side++) {
        const key = sideKey(model, patch, side);
        if (key === null || (surface.region !== null && isWithin(model, patch, side, surface.mapping))) continue;
        const name = `${number} ${key}`;
        const known = seen.get(name);
        if (known) known.count += 1;
        else seen.set(name, { patch, side, count: 1 });
      }
    }
  });
  for (const { patch, side, count } of seen.values()) if (count === 1) borders[patch] |= 1 << side;
  return borders;
}

/**
 * Whether a side of a patch is not on the border of its region, whose parameters run from 0 to 1.
 * @param {Model} model
 * @param {number} patch
 * @param {number} side
 * @param {"patch" | "revolution"} mapping
 */
function isWithin(model, patch, side, mapping) {
  const { patches } = model.blocks;
  const words = new Float32Array(patches.buffer, patches.byteOffset + patch * 64 + 16, 8);
  const [a, b, c, d, e, f, g, h] = words;
  /** The parameters of the side's ends that are the same for both, if any are. @type {number[]} */
  let ends;
  if (mapping === "revolution") ends = [[c], [d], [a], [b]][side];
  else {
    const corners = [
      [a, b],
      [c, d],
      [e, f],
      [g, h],
    ];
    const [from, to] = [corners[[0, 2, 0, 1][side]], corners[[1, 3, 2, 3][side]]];
    ends = [0, 1].filter((axis) => from[axis] === to[axis]).map((axis) => from[axis]);
  }
  return !ends.some((x) => x <= AT_BORDER || x >= 1 - AT_BORDER);
}

/**
 * The same text for the same curve in either direction: its ends and the middle of its control points, to about six digits of its size.
 * @param {Model} model
 * @param {number} patch
 * @param {number} side
 * @returns {string | null} null for a side that is a point
 */
function sideKey(model, patch, side) {
  const { first, step, degree } = sidePoints(model, patch, side);
  const { points } = model.blocks;
  const at = (/** @type {number} */ k) => {
    const from = (first + k * step) * 4;
    return [0, 1, 2].map((axis) => points[from + axis] / points[from + 3]);
  };
  const corners = Array.from({ length: degree + 1 }, (_, k) => at(k));
  const size = Math.max(...corners.flat().map(Math.abs));
  const grid = 10 ** (Math.ceil(Math.log10(size || 1)) - 5);
  const text = (/** @type {number[]} */ p) => p.map((x) => Math.round(x / grid) + 0).join(",");
  const ends = [text(corners[0]), text(corners[degree])].sort();
  const sum = corners.reduce((total, p) => total.map((x, axis) => x + p[axis]), [0, 0, 0]);
  const middle = text(sum.map((x) => x / (degree + 1)));
  return ends[0] === ends[1] && ends[0] === middle ? null : `${ends[0]};${ends[1]};${middle}`;
}

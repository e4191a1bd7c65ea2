/**
 * Resolution of the grid over a patch.
 *
 * @module
 */

/** No finer than 2^12 cells along a side. */
export const FINEST = 12;

/** Grids drawn at once have at most 2^7 cells along a side; finer ones are drawn in parts, of which those out of sight are left out. */
export const LARGEST_GRID = 7;

/** Sides longer than this many pixels are cut, into at most 2^`MOST_FOR_LENGTH` segments. */
const LONGEST_SEGMENT = 1024;
const MOST_FOR_LENGTH = 4;

/**
 * The level of one direction: 2^level cells, so that a chord is at most the tolerance off.
 * @param {number} bending metres, see `boundPatches`
 * @param {number} resolution tolerances per metre
 */
export function sideLevel(bending, resolution) {
  // bending h^2 / 8 <= tolerance with h = 2^-level.
  const squares = (bending * resolution) / 8;
  if (!(squares > 1)) return 0;
  return Math.min(FINEST, Math.ceil(Math.log2(squares) / 2));
}

/**
 * The level that cuts a long side of little bending into segments, so that parts of a patch that is close have short ones: a part out of sight draws none that is in sight.
 * @param {number} length pixels
 */
export function lengthLevel(length) {
  if (!(length > LONGEST_SEGMENT)) return 0;
  return Math.min(MOST_FOR_LENGTH, Math.ceil(Math.log2(length / LONGEST_SEGMENT)));
}

/**
 * The levels of a grid of triangles: coarse as possible with (bendUU hu^2 + 2 bendUV hu hv + bendVV hv^2) / 8 at most the tolerance (@filip1986).
 * @param {number} bendUU metres
 * @param {number} bendUV metres
 * @param {number} bendVV metres
 * @param {number} resolution tolerances per metre
 * @param {number} leastU levels not to go below
 * @param {number} leastV
 * @returns {number} level along u + 16 * level along v
 */
export function gridLevels(bendUU, bendUV, bendVV, resolution, leastU, leastV) {
  let [u, v] = [leastU, leastV];
  let uu = (bendUU * resolution * 4 ** -u) / 8;
  let uv = (bendUV * resolution * 2 ** -(u + v)) / 4;
  let vv = (bendVV * resolution * 4 ** -v) / 8;
  while (uu + uv + vv > 1 && (u < FINEST || v < FINEST)) {
    // The direction that gives more; where twist gives most, that of longer cells.
    const preferU = uv > uu && uv > vv ? u <= v : uu >= vv;
    const alongU = v >= FINEST || (u < FINEST && preferU);
    if (alongU) {
      u += 1;
      uu /= 4;
    } else {
      v += 1;
      vv /= 4;
    }
    uv /= 2;
  }
  return u + 16 * v;
}

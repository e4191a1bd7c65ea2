/**
 * Scales of illuminance for false colours, round levels for legends and isolux lines.
 *
 * @module
 */

/** @typedef {"linear" | "logarithmic" | "percentile"} LuxScaleKind */

/**
 * Colours go from `low` to `high`, lx; with `logarithmic` by equal factors. `percent`: of the area that has at most `low` and at most `high`; 0 if `low` is 0 lx.
 * @typedef {{ low: number, high: number, logarithmic: boolean, percent?: [number, number] }} LuxScale
 */

/** Kinds of scales, in the order in which a key goes through them. @type {LuxScaleKind[]} */
export const LUX_SCALES = ["linear", "logarithmic", "percentile"];

/** Least value of a logarithmic scale as a share of the largest one, unless all cells have more. */
const DEPTH = 1e-3;

/** Share of the largest illuminance below which differences are none: light is even there but for the digits of the numbers. */
const EVEN = 1e-4;

/** Number of levels at equal steps that is aimed at, and the most at equal factors. */
const LINEAR_LEVELS = 7;
const MOST_LOGARITHMIC_LEVELS = 10;

/** Most isolux lines. */
export const MOST_LEVELS = 16;

/** Illuminances of EN 12464-1 (@en12464), each about 1.5 times the one before, and coarser series. */
const SERIES = [
  [1, 1.5, 2, 3, 5, 7.5],
  [1, 2, 5],
  [1, 3],
];

/**
 * The cells of several models by ascending illuminance, as luxScale and percentile take them.
 * @param {Float32Array[]} lists illuminance, lx, and area of each cell
 */
export function sortedCells(lists) {
  const cells = new Float32Array(lists.reduce((sum, list) => sum + list.length, 0));
  lists.reduce((at, list) => (cells.set(list, at), at + list.length), 0);
  const order = Array.from({ length: cells.length / 2 }, (_, i) => i).sort((i, j) => cells[2 * i] - cells[2 * j]);
  return Float32Array.from(order.flatMap((i) => [cells[2 * i], cells[2 * i + 1]]));
}

/**
 * The illuminance that a share of the area has at most.
 * @param {Float32Array} cells sorted
 * @param {number} share 0 to 1
 */
export function percentile(cells, share) {
  let left = share * cells.reduce((sum, value, i) => (i % 2 === 1 ? sum + value : sum), 0);
  for (let i = 0; i < cells.length; i += 2) {
    left -= cells[i + 1];
    if (left <= 0) return cells[i];
  }
  return cells[cells.length - 2] ?? 0;
}

/**
 * The scale for some cells; that of darkness ends at 1 lx.
 * @param {Float32Array} cells sorted
 * @param {LuxScaleKind} kind
 * @param {number} tail percent of the area that percentiles leave out at each end
 * @returns {LuxScale}
 */
export function luxScale(cells, kind, tail) {
  const most = cells[cells.length - 2] ?? 0;
  if (!(most > 0)) return { low: 0, high: 1, logarithmic: false };
  if (kind === "logarithmic") {
    const least = cells.find((value, i) => i % 2 === 0 && value > 0) ?? most;
    // Where all is alike, a scale of one value has no colours.
    const low = Math.max(least, DEPTH * most);
    return { low: low < (1 - EVEN) * most ? low : 0.5 * most, high: most, logarithmic: true };
  }
  if (kind === "percentile") {
    const low = percentile(cells, tail / 100);
    const high = percentile(cells, 1 - tail / 100);
    if (low < (1 - EVEN) * high && low > 0) return { low, high, logarithmic: false, percent: [tail, 100 - tail] };
    if (high > 0) return { low: 0, high, logarithmic: false, percent: [0, 100 - tail] };
  }
  return { low: 0, high: most, logarithmic: false };
}

/**
 * Position of an illuminance on a scale, 0 to 1.
 * @param {LuxScale} scale
 * @param {number} lux
 */
export function positionOn({ low, high, logarithmic }, lux) {
  const position = logarithmic ? Math.log(lux / low) / Math.log(high / low) : (lux - low) / (high - low);
  return Math.min(1, Math.max(0, position));
}

/**
 * Round numbers within a scale, ascending: multiples of 1, 2, 2.5 or 5 times a power of ten, or illuminances of EN 12464-1 at equal factors.
 * @param {LuxScale} scale
 */
export function roundLevels({ low, high, logarithmic }) {
  // Steps would be smaller than the digits of the numbers.
  if (!(high - low >= EVEN * high && high > 0)) return [];
  const within = (/** @type {number} */ level) => level > low && level < high;
  if (logarithmic && high >= 10 * low) {
    for (const digits of SERIES) {
      const levels = powers(low, high).flatMap((power) => digits.map((digit) => decimal(digit, power)));
      const shown = levels.filter(within);
      if (shown.length <= MOST_LOGARITHMIC_LEVELS || digits === SERIES[SERIES.length - 1]) return shown;
    }
  }
  const power = Math.floor(Math.log10((high - low) / LINEAR_LEVELS));
  const choices = [1, 2, 2.5, 5, 10].map((digit) => {
    const step = decimal(digit, power);
    const first = Math.floor(low / step);
    const count = Math.ceil(high / step) - first + 1;
    return Array.from({ length: count }, (_, i) => decimal((first + i) * digit, power)).filter(within);
  });
  const off = (/** @type {number[]} */ levels) => Math.abs(levels.length - LINEAR_LEVELS);
  return choices.reduce((best, levels) => (off(levels) < off(best) ? levels : best));
}

/**
 * The levels of isolux lines that may be somewhere: within the illuminances of some cells.
 * @param {Float32Array} cells sorted
 * @param {number[]} levels
 */
export function levelsWithin(cells, levels) {
  const [least, most] = [cells[0], cells[cells.length - 2]];
  return levels.filter((level) => level >= least && level <= most);
}

/** @param {number} low @param {number} high */
function powers(low, high) {
  const first = Math.floor(Math.log10(low));
  return Array.from({ length: Math.floor(Math.log10(high)) - first + 1 }, (_, i) => first + i);
}

/** The number nearest to `digits` times a power of ten. @param {number} digits @param {number} power */
function decimal(digits, power) {
  return Number(`${digits}e${power}`);
}

/**
 * Levels as they are typed, ascending, or what is wrong with them. Nothing means round ones.
 * @param {string} text numbers with spaces or semicolons between them, or commas before spaces: a comma within a number may be that of a decimal fraction
 * @returns {{ levels: number[], error: string }}
 */
export function typedLevels(text) {
  const words = text.split(/(?:,(?=\s|$)|[\s;])+/).filter((word) => word !== "");
  const levels = words.map(Number);
  // Shaders have single precision.
  const wrong = words.find((_, i) => !(Math.fround(levels[i]) > 0 && Math.fround(levels[i]) < Infinity));
  if (wrong !== undefined)
    return { levels: [], error: `"${wrong}" is no illuminance: type numbers above 0, such as 0.5 300 500` };
  if (levels.length > MOST_LEVELS)
    return { levels: [], error: `${levels.length} levels are too many: type at most ${MOST_LEVELS}` };
  return { levels: [...new Set(levels)].sort((a, b) => a - b), error: "" };
}

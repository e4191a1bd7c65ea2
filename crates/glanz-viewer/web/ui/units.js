/**
 * Numbers formatted for people.
 *
 * @module
 */

/** @typedef {import("../linear.js").Vector} Vector */

/**
 * A number with so many significant digits, without zeros at its end.
 * @param {number} value
 * @param {number} digits
 */
export function plain(value, digits = 6) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : value < 0 ? "−∞" : "–";
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/** Units of length from the smallest: name, metres. @type {[string, number][]} */
const LENGTHS = [
  ["nm", 1e-9],
  ["µm", 1e-6],
  ["mm", 1e-3],
  ["m", 1],
  ["km", 1e3],
];

/** Units of CAD files: name, metres. @type {[string, number][]} */
const FILE_UNITS = [
  ["µm", 1e-6],
  ["mm", 1e-3],
  ["cm", 1e-2],
  ["in", 0.0254],
  ["ft", 0.3048],
  ["m", 1],
  ["km", 1e3],
];

/** Relative difference of the same unit, as files give it. */
const SAME_UNIT = 1e-6;

/** The unit of all lengths, `null` for one that depends on the length. @type {[string, number] | null} */
let fixedUnit = null;

/**
 * Fixes the unit of lengths, areas and volumes, if it is a known one.
 * @param {number | null} metres
 */
export function fixLengthUnit(metres) {
  fixedUnit = FILE_UNITS.find(([, unit]) => metres !== null && Math.abs(metres / unit - 1) < SAME_UNIT) ?? null;
}

/**
 * The fixed unit; without one the largest that makes a length at least 1, metres for nothing.
 * @param {number} metres
 */
function lengthUnit(metres) {
  if (fixedUnit) return fixedUnit;
  const size = Math.abs(metres);
  if (size === 0) return LENGTHS[3];
  return LENGTHS.findLast(([, unit]) => size >= unit) ?? LENGTHS[0];
}

/** @param {number} metres */
export function lengthText(metres) {
  const [name, unit] = lengthUnit(metres);
  return `${plain(metres / unit)} ${name}`;
}

/** @param {number} squareMetres */
export function areaText(squareMetres) {
  const [name, unit] = lengthUnit(Math.sqrt(Math.abs(squareMetres)));
  return `${plain(squareMetres / unit ** 2)} ${name}²`;
}

/** @param {number} cubicMetres */
export function volumeText(cubicMetres) {
  const [name, unit] = lengthUnit(Math.cbrt(Math.abs(cubicMetres)));
  return `${plain(cubicMetres / unit ** 3)} ${name}³`;
}

/** @param {Vector} point metres */
export function pointText(point) {
  const [name, unit] = fixedUnit ?? LENGTHS[3];
  return `${point.map((x) => plain(x / unit)).join(", ")} ${name}`;
}

/** @param {Vector} direction */
export function directionText(direction) {
  return direction.map((x) => plain(Math.abs(x) < 1e-9 ? 0 : x, 5)).join(", ");
}

/** @param {number} perMetre */
export function curvatureText(perMetre) {
  return `${plain(perMetre, 5)} /m`;
}

/** @param {number} radians */
export function angleText(radians) {
  return `${plain((radians * 180) / Math.PI, 5)}°`;
}

/** @param {number} seconds */
export function timeText(seconds) {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const minutes = Math.floor(seconds / 60);
  return `${minutes} min ${Math.floor(seconds - 60 * minutes)} s`;
}

/** Relative errors below this one are not told apart. */
const SMALL_ERROR = 1e-4;

/**
 * An illuminance with its standard error.
 * @param {import("../session.js").LuxReading} reading
 */
export function luxText({ lux, relativeError }) {
  const error = relativeError
    ? ` ± ${relativeError < SMALL_ERROR ? `< ${percentText(SMALL_ERROR)}` : percentText(relativeError)}`
    : "";
  return `${plain(lux, 4)} lx${error}`;
}

/**
 * The difference of an illuminance from another one.
 * @param {import("../session.js").LuxReading} first
 * @param {import("../session.js").LuxReading} second
 */
export function luxDifferenceText(first, second) {
  const difference = second.lux - first.lux;
  const sign = difference > 0 ? "+" : "";
  const share = first.lux > 0 ? ` (${sign}${percentText(difference / first.lux)})` : "";
  return `${sign}${plain(difference, 4)} lx${share}`;
}

/**
 * Illuminances of two designs and their difference; empty if neither has any.
 * @param {import("../session.js").LuxReading | null} first
 * @param {import("../session.js").LuxReading | null} second
 */
export function luxTexts(first, second) {
  if (!first && !second) return "";
  const texts = [first, second].map((reading, i) => `${"AB"[i]} ${reading ? luxText(reading) : "–"}`);
  if (first && second) texts.push(`B − A ${luxDifferenceText(first, second)}`);
  return texts.join(", ");
}

/** @param {number} share */
export function percentText(share) {
  return `${plain(100 * share, 2)} %`;
}

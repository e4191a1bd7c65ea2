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

/**
 * The largest unit that makes a length at least 1, metres for nothing.
 * @param {number} metres
 */
function lengthUnit(metres) {
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

/** @param {Vector} point metres */
export function pointText(point) {
  return `${point.map((x) => plain(x)).join(", ")} m`;
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

/** @param {number} share */
export function percentText(share) {
  return `${plain(100 * share, 2)} %`;
}

/**
 * Settings of the view.
 *
 * @module
 */

import { add, dot, scale } from "./linear.js";
import { LUX_SCALES, typedLevels } from "./lux_scale.js";

/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./camera.js").Bounds} Bounds */
/** @typedef {"material" | "zebra" | "gaussian" | "mean" | "maximum" | "normals"} Shading */

/**
 * `exposure`: stops. `stripes`: of the zebra. `curvature`: power of ten of what gets full colour, as a multiple of one over the scene's size. `isocurves`: per
 * patch. `luxTail`: percent of the area that a scale by percentiles leaves out at each end. `isoluxLevels`: text, lx; empty for round ones. `seeThrough`:
 * whether outer walls are left out where they are seen from outside. `sectionShare`: place of the plane between the ends of the scene's bounds. `pickedNormal`: of the point that a plane was put through.
 * @typedef {{ exposure: number, integrator: "none" | "path" | "guided", denoise: boolean, shading: Shading, stripes: number, curvature: number,
 *   isocurves: number, edges: boolean, net: boolean, maps: boolean,
 *   luxScale: import("./lux_scale.js").LuxScaleKind, luxTail: number, isolux: boolean, isoluxLevels: string, seeThrough: boolean, section: boolean, sectionAxis: "x" | "y" | "z" | "picked",
 *   sectionShare: number, sectionFlip: boolean, pickedNormal: Vector | null }} Settings
 */

/** @typedef {{ normal: Vector, offset: number }} Plane what is kept has `dot(normal, point) <= offset` */

/** @returns {Settings} */
export function defaultSettings() {
  return {
    exposure: 0,
    integrator: "path",
    denoise: false,
    shading: "material",
    stripes: 16,
    curvature: 1,
    isocurves: 0,
    edges: false,
    net: false,
    maps: false,
    luxScale: "linear",
    luxTail: 1,
    isolux: false,
    isoluxLevels: "",
    seeThrough: false,
    section: false,
    sectionAxis: "x",
    sectionShare: 0.5,
    sectionFlip: false,
    pickedNormal: null,
  };
}

/**
 * The settings of lux maps as a text to be kept.
 * @param {Settings} settings
 */
export function luxSettingsText({ luxScale, luxTail, isolux, isoluxLevels }) {
  return JSON.stringify({ luxScale, luxTail, isolux, isoluxLevels });
}

/**
 * The settings of lux maps from a text that was kept; what is none of these is left out.
 * @param {string | null} text
 * @returns {Partial<Settings>}
 */
export function luxSettings(text) {
  /** @type {Partial<Settings>} */
  const known = {};
  try {
    const kept = JSON.parse(text ?? "");
    if (LUX_SCALES.includes(kept.luxScale)) known.luxScale = kept.luxScale;
    const { luxTail } = kept;
    if (typeof luxTail === "number" && luxTail >= 0 && luxTail <= 10) known.luxTail = luxTail;
    if (typeof kept.isolux === "boolean") known.isolux = kept.isolux;
    if (typeof kept.isoluxLevels === "string" && typedLevels(kept.isoluxLevels).error === "")
      known.isoluxLevels = kept.isoluxLevels;
  } catch {
    // Nothing was kept, or by another version of the page.
  }
  return known;
}

/**
 * The next shading mode in a cycle that starts with the materials; a mode outside the cycle counts as its start.
 * @param {Shading} shading
 * @param {Shading[]} order
 * @returns {Shading}
 */
export function nextShading(shading, order) {
  const at = Math.max(0, order.indexOf(shading));
  return order[(at + 1) % order.length];
}

/**
 * Reason why these settings exclude rendering, `null` if they do not.
 * @param {Settings} settings
 * @param {{ hasEdges: boolean, hasMaps: boolean, hasWalls: boolean, isCompared: boolean }} scene whether it has edges of its own, which are drawn over the
 *   rendered image, too; whether it has light on surfaces, and outer walls; whether it is shown beside another one
 */
export function realTimeOnly(settings, { hasEdges, hasMaps, hasWalls, isCompared }) {
  if (settings.integrator === "none") return "chosen";
  if (isCompared) return "two designs";
  if (settings.section) return "section plane";
  if (settings.shading !== "material") return "surface colours";
  if (settings.maps && hasMaps) return "light on surfaces";
  if (settings.seeThrough && hasWalls) return "walls that are seen through";
  if (settings.net || settings.isocurves > 0 || (settings.edges && !hasEdges)) return "lines on surfaces";
  return null;
}

/**
 * 1/m at which a curvature gets full colour.
 * @param {Settings} settings
 * @param {number} extent metres, of the scene
 */
export function fullColour(settings, extent) {
  return 10 ** settings.curvature / extent;
}

/** @type {Record<"x" | "y" | "z", Vector>} */
const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

/**
 * The direction across the section plane, before it is turned around.
 * @param {Settings} settings
 * @returns {Vector}
 */
function sectionNormal(settings) {
  return settings.sectionAxis === "picked" ? (settings.pickedNormal ?? AXES.x) : AXES[settings.sectionAxis];
}

/**
 * Range of `dot(normal, point)` over a box.
 * @param {Vector} normal
 * @param {Bounds} bounds
 * @returns {[number, number]}
 */
function extentAlong(normal, bounds) {
  const middle = dot(normal, scale(add(bounds[0], bounds[1]), 0.5));
  const half = normal.reduce((sum, n, i) => sum + (Math.abs(n) * (bounds[1][i] - bounds[0][i])) / 2, 0);
  return [middle - half, middle + half];
}

/**
 * The section plane, `null` if there is none.
 * @param {Settings} settings
 * @param {Bounds} bounds
 * @returns {Plane | null}
 */
export function sectionPlane(settings, bounds) {
  if (!settings.section) return null;
  const normal = sectionNormal(settings);
  const [low, high] = extentAlong(normal, bounds);
  const offset = low + (high - low) * settings.sectionShare;
  return settings.sectionFlip ? { normal: scale(normal, -1), offset: -offset } : { normal, offset };
}

/**
 * The share of `sectionShare` at which the plane goes through a point.
 * @param {Settings} settings
 * @param {Bounds} bounds
 * @param {Vector} point
 */
export function shareThrough(settings, bounds, point) {
  const normal = sectionNormal(settings);
  const [low, high] = extentAlong(normal, bounds);
  return high > low ? Math.min(1, Math.max(0, (dot(normal, point) - low) / (high - low))) : 0.5;
}

/**
 * Properties of the selection.
 *
 * @module
 */

import { announce, describe, element } from "./dom.js";
import {
  angleText,
  areaText,
  curvatureText,
  directionText,
  lengthText,
  luxDifferenceText,
  luxText,
  plain,
  pointText,
  volumeText,
} from "./units.js";

/** @typedef {import("../session.js").Hit} Hit */
/** @typedef {import("../session.js").Dimensions} Dimensions */
/** @typedef {import("../session.js").LuxReading} LuxReading */
/** @typedef {import("../session.js").Measures} Measures */
/** @typedef {import("../scene_parts.js").Item} Item */

/** @typedef {[term: string, description: string][]} Rows */

/**
 * @param {Dimensions | null} dimensions
 * @returns {Rows}
 */
function dimensionRows(dimensions) {
  if (!dimensions) return [];
  const { radius, majorRadius, minorRadius, halfAngle } = dimensions;
  /** @type {Rows} */
  const rows = [];
  if (radius !== null) rows.push(["Radius", lengthText(radius)]);
  if (majorRadius !== null) rows.push(["Major radius", lengthText(majorRadius)]);
  if (minorRadius !== null) rows.push(["Minor radius", lengthText(minorRadius)]);
  if (halfAngle !== null) rows.push(["Half angle", angleText(halfAngle)]);
  return rows;
}

/** The term of an illuminance. */
const ILLUMINANCE = "Illuminance";

/**
 * Illuminance of the cell at a picked point, and of its receiver.
 * @param {LuxReading | null} reading
 * @returns {Rows}
 */
function luxRows(reading) {
  if (!reading) return [];
  const { receiver, cell, minimum, mean, maximum } = reading;
  return [
    [ILLUMINANCE, luxText(reading)],
    ["Receiver", receiver],
    ["Cell (i, j)", cell.join(", ")],
    ["Mean of the receiver", `${plain(mean, 4)} lx`],
    ["Least, largest", `${plain(minimum, 4)} lx, ${plain(maximum, 4)} lx`],
  ];
}

/**
 * Illuminances of two designs at a place.
 * @param {LuxReading | null} first
 * @param {LuxReading | null} second
 * @returns {Rows}
 */
function luxDifferenceRows(first, second) {
  if (!first && !second) return [];
  /** @type {Rows} */
  const rows = [
    ["Illuminance in A", first ? luxText(first) : "–"],
    ["Illuminance in B", second ? luxText(second) : "–"],
  ];
  if (first && second) rows.push(["B − A", luxDifferenceText(first, second)]);
  return rows;
}

/**
 * @param {Hit} hit
 * @param {Item | null} item the part that was hit
 * @returns {Rows}
 */
function hitRows(hit, item) {
  /** @type {Rows} */
  const rows = [["Name", hit.name || "–"]];
  if (hit.entity) rows.push(["Entity", hit.entity]);
  rows.push(["Kind", hit.kind], ["Material", hit.material || "–"]);
  rows.push(...luxRows(hit.lux));
  if (item?.node.place) rows.push(["Defined at", item.node.place]);
  if (hit.degree) rows.push(["Degree", `${hit.degree[0]} × ${hit.degree[1]}`]);
  if (hit.area !== null) rows.push(["Area", areaText(hit.area)]);
  rows.push(...dimensionRows(hit.dimensions));
  if (!hit.entity) rows.push(["Face", String(hit.face)]);
  rows.push(["(u, v)", hit.uv.map((x) => plain(x)).join(", ")]);
  rows.push(["Point", pointText(hit.point)], ["Normal", directionText(hit.normal)]);
  rows.push(["From the camera", lengthText(hit.distance)]);
  if (hit.curvature) {
    const { radius, minimum, maximum, gaussian, mean } = hit.curvature;
    rows.push(["Radius of curvature", radius === null ? "∞ (flat)" : lengthText(radius)]);
    rows.push(["Principal curvatures", `${curvatureText(minimum)}, ${curvatureText(maximum)}`]);
    rows.push(["Gaussian curvature", `${plain(gaussian, 5)} /m²`], ["Mean curvature", curvatureText(mean)]);
  }
  return rows;
}

/**
 * @param {Item} item
 * @returns {Rows}
 */
function itemRows(item) {
  const { node } = item;
  /** @type {Rows} */
  const rows = [["Name", item.label]];
  if (node.kind === "shape") rows.push(["Kind", node.what ?? "shape"]);
  else rows.push(["Shapes in it", String(item.end - item.first)]);
  if (node.place) rows.push(["Defined at", node.place]);
  return rows;
}

/**
 * What is known of a part.
 * @param {Item} part
 * @param {Measures} measures
 * @returns {Rows}
 */
function measureRows(part, { area, volume }) {
  /** @type {Rows} */
  const rows = [];
  if (area !== null) rows.push([`Area of ${part.label}`, areaText(area)]);
  if (volume !== null) rows.push([`Volume of ${part.label}`, volumeText(volume)]);
  return rows;
}

/** Names of the kinds of edges. */
const EDGES = { line: "Straight edge", circle: "Circular edge", ellipse: "Elliptical edge", spline: "Curved edge" };

/**
 * @param {import("../edge_picking.js").EdgeDimensions} edge
 * @param {string[]} faces names
 * @returns {Rows}
 */
export function edgeRows({ kind, length, isExact, radii, angle }, faces) {
  /** @type {Rows} */
  const rows = [
    ["Kind", EDGES[kind]],
    ["Length", `${isExact ? "" : "about "}${lengthText(length)}`],
  ];
  if (kind === "circle") rows.push(["Radius", lengthText(radii[0])], ["Arc", angleText(length / radii[0])]);
  if (kind === "ellipse" && radii.length > 0) rows.push(["Radii", radii.map(lengthText).join(", ")]);
  if (faces.length > 1 && angle !== null) rows.push(["Angle of the faces", angleText(angle)]);
  rows.push([faces.length > 1 ? "Faces" : "Face", faces.join(", ")]);
  return rows;
}

export class PropertiesPanel {
  constructor() {
    this.list = element("properties", HTMLElement);
    this.nothing = element("nothing", HTMLElement);
    this.copy = element("copy", HTMLButtonElement);
    /** @type {unknown} what the button copies */
    this.shown = null;
    /** @type {Rows} */
    this.rows = [];
    this.copy.addEventListener("click", () => this.toClipboard());
  }

  /**
   * @param {Hit | null} hit
   * @param {Item | null} item
   */
  show(hit, item) {
    this.showRows(hit ? hitRows(hit, item) : item ? itemRows(item) : []);
    this.shown = hit ?? Object.fromEntries(this.rows);
  }

  /**
   * Adds measures of a part to what is shown.
   * @param {Item} part
   * @param {Measures} measures
   */
  add(part, measures) {
    this.showRows([...this.rows, ...measureRows(part, measures)]);
    this.shown = { .../** @type {object} */ (this.shown), part: { name: part.label, ...measures } };
  }

  /**
   * Adds illuminances of two designs to what is shown, after the one that is there.
   * @param {LuxReading | null} first
   * @param {LuxReading | null} second
   */
  addDifference(first, second) {
    const rows = luxDifferenceRows(first, second);
    const at = this.rows.findIndex(([term]) => term === ILLUMINANCE) + 1 || this.rows.length;
    this.showRows([...this.rows.slice(0, at), ...rows, ...this.rows.slice(at)]);
    this.shown = { .../** @type {object} */ (this.shown), ...Object.fromEntries(rows) };
  }

  /** @param {Rows} rows */
  showRows(rows) {
    this.rows = rows;
    describe(this.list, rows);
    this.nothing.hidden = rows.length > 0;
    this.copy.hidden = rows.length === 0;
  }

  async toClipboard() {
    try {
      await navigator.clipboard.writeText(JSON.stringify(this.shown, null, 2));
      announce("Copied");
      this.copy.textContent = "Copied";
    } catch {
      // Pages that were not loaded over https or from this machine have no clipboard.
      announce("The browser does not let this page copy");
      this.copy.textContent = "Not allowed by the browser";
    }
    setTimeout(() => (this.copy.textContent = "Copy"), 2000);
  }
}

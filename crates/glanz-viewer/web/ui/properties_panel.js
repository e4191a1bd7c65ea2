/**
 * Properties of the selection.
 *
 * @module
 */

import { announce, describe, element } from "./dom.js";
import { areaText, curvatureText, directionText, lengthText, plain, pointText } from "./units.js";

/** @typedef {import("../session.js").Hit} Hit */
/** @typedef {import("../scene_parts.js").Item} Item */

/** @typedef {[term: string, description: string][]} Rows */

/**
 * @param {Hit} hit
 * @param {Item | null} item the part that was hit
 * @returns {Rows}
 */
function hitRows(hit, item) {
  /** @type {Rows} */
  const rows = [["Name", hit.name || "–"]];
  rows.push(["Kind", hit.kind], ["Material", hit.material || "–"]);
  if (item?.node.place) rows.push(["Defined at", item.node.place]);
  if (hit.degree) rows.push(["Degree", `${hit.degree[0]} × ${hit.degree[1]}`]);
  if (hit.area !== null) rows.push(["Area", areaText(hit.area)]);
  rows.push(["Face", String(hit.face)]);
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

export class PropertiesPanel {
  constructor() {
    this.list = element("properties", HTMLElement);
    this.nothing = element("nothing", HTMLElement);
    this.copy = element("copy", HTMLButtonElement);
    /** @type {unknown} what the button copies */
    this.shown = null;
    this.copy.addEventListener("click", () => this.toClipboard());
  }

  /**
   * @param {Hit | null} hit
   * @param {Item | null} item
   */
  show(hit, item) {
    const rows = hit ? hitRows(hit, item) : item ? itemRows(item) : [];
    describe(this.list, rows);
    this.nothing.hidden = rows.length > 0;
    this.copy.hidden = rows.length === 0;
    this.shown = hit ?? Object.fromEntries(rows);
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

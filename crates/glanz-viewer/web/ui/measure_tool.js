/**
 * The distance between two picked points, drawn over the view.
 *
 * @module
 */

import { project } from "../camera.js";
import { dot, length, subtract } from "../linear.js";
import { announce, describe, element } from "./dom.js";
import { angleText, lengthText } from "./units.js";

/** @typedef {import("../camera.js").Camera} Camera */
/** @typedef {import("../camera.js").Size} Size */
/** @typedef {import("../linear.js").Vector} Vector */

/** A point, with the normal of the surface there, if there is one. @typedef {{ point: Vector, normal: Vector | null }} MeasuredPoint */

/**
 * Distance, offset and angle between two points.
 * @param {MeasuredPoint} from
 * @param {MeasuredPoint} to
 */
export function measured(from, to) {
  const step = subtract(to.point, from.point);
  const cos = from.normal && to.normal ? Math.max(-1, Math.min(1, dot(from.normal, to.normal))) : null;
  return { distance: length(step), step, angle: cos === null ? null : Math.acos(cos) };
}

const SVG = "http://www.w3.org/2000/svg";

/**
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | number>} attributes
 * @param {string} text
 */
function shape(tag, attributes, text = "") {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.textContent = text;
  return made;
}

export class MeasureTool {
  constructor() {
    this.overlay = element("overlay", SVGSVGElement);
    this.section = element("measured", HTMLElement);
    this.list = element("distances", HTMLElement);
    this.active = false;
    /** @type {MeasuredPoint[]} */
    this.spots = [];
  }

  /** @param {boolean} active */
  activate(active) {
    this.active = active;
    this.spots = [];
    this.show();
    if (active) announce("Pick two points to measure between them");
  }

  /** @param {MeasuredPoint} spot */
  add(spot) {
    this.spots = this.spots.length === 2 ? [spot] : [...this.spots, spot];
    this.show();
  }

  show() {
    const [from, to] = this.spots;
    this.section.hidden = !this.active;
    if (!from || !to) {
      describe(this.list, [["Pick", from ? "the second point" : "two points"]]);
      return;
    }
    const { distance, step, angle } = measured(from, to);
    /** @type {[string, string][]} */
    const axes = [0, 1, 2].map((i) => [`Δ${"xyz"[i]}`, lengthText(step[i])]);
    if (angle !== null) axes.push(["Angle of the normals", angleText(angle)]);
    describe(this.list, [["Distance", lengthText(distance)], ...axes]);
    announce(`Distance ${lengthText(distance)}`);
  }

  /**
   * Draws the points where the camera sees them.
   * @param {Camera} camera
   * @param {Size} size CSS pixels
   */
  draw(camera, size) {
    const places = this.spots.map(({ point }) => project(camera, size, point));
    const [a, b] = places;
    /** @type {SVGElement[]} */
    const shapes = [];
    if (a && b) {
      const ends = { x1: a.x, y1: a.y, x2: b.x, y2: b.y };
      shapes.push(shape("line", { ...ends, class: "halo" }), shape("line", ends));
    }
    for (const place of places) if (place) shapes.push(shape("circle", { cx: place.x, cy: place.y, r: 4 }));
    if (a && b) {
      const text = lengthText(measured(this.spots[0], this.spots[1]).distance);
      shapes.push(shape("text", { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 - 8 }, text));
    }
    this.overlay.replaceChildren(...shapes);
  }
}

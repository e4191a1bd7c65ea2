/**
 * Legend of the false colours.
 *
 * @module
 */

import { DIVERGING, gradient, VIRIDIS } from "../colours.js";
import { create, element } from "./dom.js";
import { curvatureText, plain } from "./units.js";

/** @typedef {import("../colours.js").Colour} Colour */
/** @typedef {import("../model.js").LightMap} LightMap */
/** @typedef {import("../settings.js").Settings} Settings */

/** @type {Partial<Record<Settings["shading"], string>>} */
const CURVATURES = {
  gaussian: "Gaussian curvature (its root)",
  mean: "Mean curvature",
  maximum: "Largest curvature",
};

/**
 * @param {string} title
 * @param {Colour[]} colours
 * @param {string[]} ends what the colours at the ends, or at equal steps, stand for
 */
function scale(title, colours, ends) {
  const bar = create("div", "", "scale");
  bar.style.backgroundImage = gradient(colours);
  const labels = create("div", "", "ends");
  labels.append(...ends.map((end) => create("span", end)));
  return [create("div", title), bar, labels];
}

/**
 * Shows the legend of the selected shading mode, or none.
 * @param {Settings} settings
 * @param {number} curvature 1/m, at full colour
 * @param {LightMap[]} maps of numbers; those of light have no scale
 */
export function showLegend(settings, curvature, maps) {
  const legend = element("legend", HTMLElement);
  const title = CURVATURES[settings.shading];
  /** @type {HTMLElement[]} */
  let content = [];
  if (title) {
    const end = Number(curvature.toPrecision(3));
    content = scale(title, DIVERGING, [`concave ${curvatureText(-end)}`, "0", `convex ${curvatureText(end)}`]);
  } else if (settings.maps && settings.shading === "material") {
    content = maps.flatMap(({ name, unit, largest }) => scale(name, VIRIDIS, ["0", `${plain(largest, 3)} ${unit}`]));
  }
  legend.replaceChildren(...content);
  legend.hidden = content.length === 0;
}

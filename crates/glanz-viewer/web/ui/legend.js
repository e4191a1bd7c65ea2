/**
 * Legend of the false colours.
 *
 * @module
 */

import { DIVERGING, gradient, VIRIDIS } from "../colours.js";
import { positionOn, roundLevels } from "../lux_scale.js";
import { create, element } from "./dom.js";
import { curvatureText, plain } from "./units.js";

/** @typedef {import("../colours.js").Colour} Colour */
/** @typedef {import("../gl/renderer.js").LuxDisplay} LuxDisplay */
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

/** Width of a letter of a label and of the gap between labels, as shares of the scale's length. */
const LETTER = 0.026;
const GAP = 0.015;

/**
 * The ends of a scale, with as many digits as tell them apart, and the area that it shows.
 * @param {import("../lux_scale.js").LuxScale} scale
 */
export function limitsText({ low, high, percent }) {
  const texts = [3, 4, 5, 6].map((digits) => [low, high].map((lux) => plain(lux, digits)));
  const limits = (texts.find(([first, last]) => first !== last) ?? texts[3]).join(" to ");
  if (!percent) return limits;
  const [first, last] = percent.map((x) => plain(x));
  return `${percent[0] > 0 ? `${first} % to ${last} %` : `up to ${last} %`} of the area, ${limits}`;
}

/**
 * The scale of illuminances, with round numbers where their colours are, and the isolux lines.
 * @param {LuxDisplay} lux
 * @param {Settings} settings
 */
function luxLegend({ scale: range, levels }, { isolux }) {
  const title = create("div", `Illuminance, lx (${limitsText(range)})`);
  const bar = create("div", "", "scale");
  bar.style.backgroundImage = gradient(VIRIDIS);
  const labels = create("div", "", "levels");
  // Where the last label ends.
  let end = 0;
  for (const level of roundLevels(range)) {
    const position = positionOn(range, level);
    const half = (plain(level).length * LETTER) / 2;
    if (position - half < end || position + half > 1 + 2 * GAP) continue;
    end = position + half + GAP;
    const label = create("span", plain(level));
    label.style.left = `${100 * position}%`;
    labels.append(label);
  }
  for (const level of levels) {
    if (level < range.low || level > range.high) continue;
    const mark = create("span", "", "mark");
    mark.style.left = `${100 * positionOn(range, level)}%`;
    bar.append(mark);
  }
  const lines = levels.length > 0 ? levels.map((level) => plain(level)).join(", ") : "none";
  return [title, bar, labels, ...(isolux ? [create("div", `Lines: ${lines}`)] : [])];
}

/**
 * Shows the legend of the selected shading mode, or none.
 * @param {Settings} settings
 * @param {number} curvature 1/m, at full colour
 * @param {LuxDisplay | null} lux how illuminances are shown, `null` if no surface shows any; light has no scale
 */
export function showLegend(settings, curvature, lux) {
  const legend = element("legend", HTMLElement);
  const title = CURVATURES[settings.shading];
  /** @type {HTMLElement[]} */
  let content = [];
  if (title) {
    const end = Number(curvature.toPrecision(3));
    content = scale(title, DIVERGING, [`concave ${curvatureText(-end)}`, "0", `convex ${curvatureText(end)}`]);
  } else if (settings.maps && settings.shading === "material" && lux) {
    content = luxLegend(lux, settings);
  }
  legend.replaceChildren(...content);
  legend.hidden = content.length === 0;
}

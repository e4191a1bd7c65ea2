/**
 * The status bar: renderer, progress, cursor position.
 *
 * @module
 */

import { announce, element } from "./dom.js";
import { percentText, pointText, timeText } from "./units.js";

/** @typedef {import("../rendered_image.js").RenderStatus} RenderStatus */
/** @typedef {import("../linear.js").Vector} Vector */

/** @type {Record<string, string>} */
const INTEGRATORS = { path: "Path tracing", guided: "Guided path tracing" };

export class StatusBar {
  constructor() {
    this.renderer = element("renderer", HTMLElement);
    this.cursor = element("cursor", HTMLElement);
    this.busy = element("busy", HTMLProgressElement);
    this.done = false;
  }

  /**
   * @param {RenderStatus | null} image
   * @param {string} integrator
   * @param {string | null} why what shows in real time only, if something is chosen that does
   */
  show(image, integrator, why) {
    this.renderer.textContent = image ? renderingText(image, integrator) : realTimeText(why);
    this.busy.hidden = !image || image.done || image.error !== null;
    const done = image?.done ?? false;
    if (done && !this.done) announce("Rendering is done");
    this.done = done;
  }

  /**
   * @param {Vector | null} point under the cursor
   * @param {string} lux illuminance there
   */
  point(point, lux) {
    this.cursor.textContent = [lux, point ? pointText(point) : ""].filter((text) => text !== "").join(" at ");
  }
}

/** @param {string | null} why */
function realTimeText(why) {
  return why === null ? "Real time" : `Real time only (${why})`;
}

/**
 * @param {RenderStatus} image
 * @param {string} integrator
 */
function renderingText(image, integrator) {
  const name = INTEGRATORS[integrator] ?? integrator;
  if (image.error !== null) return `${name}: ${image.error}`;
  if (image.queued) return `${name} is queued behind other pages`;
  if (image.samples === 0) return `${name} begins`;
  const noise = image.noise === null ? [] : [`noise ${percentText(image.noise)}`];
  const parts = [
    `${image.samples} ${image.samples === 1 ? "sample" : "samples"}`,
    ...noise,
    timeText(image.seconds),
    ...(image.denoised === null ? [] : [`denoised at ${image.denoised}`]),
    ...(image.done ? ["done"] : []),
  ];
  return `${name}: ${parts.join(", ")}`;
}

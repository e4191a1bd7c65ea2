/**
 * The line below the view: who renders, and how far it is.
 *
 * @module
 */

import { announce, element } from "./element.js";
import { percentText, pointText, timeText } from "./units.js";

/** @typedef {import("../truth.js").TruthStatus} TruthStatus */
/** @typedef {import("../linear.js").Vector} Vector */

/** @type {Record<string, string>} */
const INTEGRATORS = { path: "Path tracing", guided: "Guided path tracing" };

export class Status {
  constructor() {
    this.renderer = element("renderer", HTMLElement);
    this.cursor = element("cursor", HTMLElement);
    this.busy = element("busy", HTMLProgressElement);
    this.done = false;
  }

  /**
   * @param {TruthStatus | null} truth
   * @param {string} integrator
   * @param {string | null} why what shows in real time only, if something is chosen that does
   */
  show(truth, integrator, why) {
    this.renderer.textContent = truth ? truthText(truth, integrator) : realTimeText(why);
    this.busy.hidden = !truth || truth.done || truth.error !== null;
    const done = truth?.done ?? false;
    if (done && !this.done) announce("Rendering is done");
    this.done = done;
  }

  /** @param {Vector | null} point under the cursor */
  point(point) {
    this.cursor.textContent = point ? pointText(point) : "";
  }
}

/** @param {string | null} why */
function realTimeText(why) {
  return why === null ? "Real time" : `Real time only (${why})`;
}

/**
 * @param {TruthStatus} truth
 * @param {string} integrator
 */
function truthText(truth, integrator) {
  const name = INTEGRATORS[integrator] ?? integrator;
  if (truth.error !== null) return `${name}: ${truth.error}`;
  if (truth.waits) return `${name} waits for other pages`;
  if (truth.samples === 0) return `${name} begins`;
  const noise = truth.noise === null ? [] : [`noise ${percentText(truth.noise)}`];
  const parts = [
    `${truth.samples} ${truth.samples === 1 ? "sample" : "samples"}`,
    ...noise,
    timeText(truth.seconds),
    ...(truth.done ? ["done"] : []),
  ];
  return `${name}: ${parts.join(", ")}`;
}

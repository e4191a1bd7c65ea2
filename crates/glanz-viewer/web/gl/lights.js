/**
 * The lights of a model, and their numbers in the block that all programs share.
 *
 * @module
 */

import { add, length, normalize, scale, subtract } from "../linear.js";
import { FRAME_HEAD, FRAME_LIGHT, MOST_LIGHTS } from "./frame.js";

/** @typedef {import("../linear.js").Vector} Vector */
/** @typedef {import("../model.js").Light} Light */
/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./frame.js").Frame} Frame */

/** Without an environment, mirrors reflect this fraction of the light that arrives at the focus, and rough surfaces receive the same fraction of it. */
const SEEN_IN_MIRRORS = 0.45;
const FILL = 0.3;

/** Radiance of the lower half of the environment over that of the upper half: if the scene gives one radiance for both, and if it gives none. */
const GROUND = 0.6;
const GROUND_OF_NONE = 0.15;

/** Irradiance of the light at the eye in scenes without any, W/m^2: a white surface shows 0.8. */
const HEADLIGHT = 0.8 * Math.PI;

const KINDS = { distant: 0, point: 1, spot: 2, area: 3, infinite: -1 };

/** Luminance of linear Rec. 709 light. @param {Vector} rgb */
function luminance(rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

export class Lights {
  /** @param {Model} model */
  constructor(model) {
    this.model = model;
    const { position, forward, distance } = model.camera;
    const middle = add(position, scale(forward, distance));
    const size = length(subtract(model.bounds[1], model.bounds[0])) / 2 || 1;
    /** Lamps, the brightest at what the scene's camera looks at first. */
    this.lamps = model.lights
      .filter((light) => light.kind !== "infinite")
      .map((light) => ({ light, bright: irradianceAt(light, middle, size) }))
      .sort((a, b) => b.bright - a.bright)
      .slice(0, MOST_LIGHTS)
      .map(({ light }) => light);
    /** Irradiance of all lamps there, by channel. */
    const lit = this.lamps.reduce(
      (sum, light) =>
        add(sum, scale(light.intensity, irradianceAt(light, middle, size) / (luminance(light.intensity) || 1))),
      /** @type {Vector} */ ([0, 0, 0]),
    );
    const surroundings = model.lights.filter((light) => light.kind === "infinite");
    this.hasSurroundings = surroundings.length > 0;
    /** Radiance from above. @type {Vector} */
    this.sky = surroundings.reduce((sum, light) => add(sum, light.intensity), /** @type {Vector} */ ([0, 0, 0]));
    if (!this.hasSurroundings) this.sky = scale(lit, SEEN_IN_MIRRORS / Math.PI);
    if (this.isDark) this.sky = [0.3, 0.3, 0.3];
  }

  /** True if the scene has no lights; then a headlight is used. */
  get isDark() {
    return this.lamps.length === 0 && !this.hasSurroundings;
  }

  /** The light that throws shadows, or null. */
  get main() {
    return this.lamps[0] ?? null;
  }

  /**
   * Writes lights and surroundings into the shared block.
   * @param {Float32Array} block
   * @param {Frame} frame
   * @param {boolean} shadows whether the main light's shadows are known
   */
  write(block, frame, shadows) {
    const lamps = this.isDark ? [headlight(frame)] : this.lamps;
    block.set([...this.sky, lamps.length], 36);
    block.set([...scale(this.sky, this.hasSurroundings ? GROUND : GROUND_OF_NONE), 0], 40);
    block.fill(this.hasSurroundings ? 1 : FILL, 44, 48);
    lamps.forEach((light, k) => {
      const at = FRAME_HEAD + k * FRAME_LIGHT;
      block.set([...frame.toCamera(light.position), KINDS[light.kind]], at);
      block.set([...frame.turn(light.direction), light.cosInner], at + 4);
      block.set([...light.intensity, light.cosOuter], at + 8);
      block.set([light.range ?? 0, shadows && k === 0 ? 1 : 0, 0, 0], at + 12);
    });
  }
}

/** A light beside the eye. @param {Frame} frame @returns {Light} */
function headlight(frame) {
  const { position, right, up, forward } = frame.camera;
  const direction = normalize(add(forward, add(scale(right, 0.25), scale(up, -0.35))));
  const intensity = /** @type {Vector} */ ([HEADLIGHT, HEADLIGHT, HEADLIGHT]);
  return { kind: "distant", position, direction, intensity, cosInner: 1, cosOuter: 1, range: null };
}

/**
 * About how much light of a lamp arrives at a place, luminance; of lamps with a side or a cone, what they send along their axis.
 * @param {Light} light
 * @param {Vector} at
 * @param {number} size of the scene: nearer lamps count as if they were a tenth of it away
 */
function irradianceAt(light, at, size) {
  const bright = luminance(light.intensity);
  if (light.kind === "distant") return bright;
  return bright / Math.max(length(subtract(light.position, at)), size / 10) ** 2;
}

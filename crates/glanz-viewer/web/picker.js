/**
 * What is at places of the view: surfaces, which the server finds, and edges.
 *
 * @module
 */

import { rayThrough } from "./camera.js";
import { edgesNear, isInSight } from "./edge_picking.js";
import { ranges } from "./scene_parts.js";

/** @typedef {import("./edge_picking.js").EdgePlace} EdgePlace */
/** @typedef {import("./scene_parts.js").Item} Item */
/** @typedef {import("./session.js").Hit} Hit */
/** @typedef {import("./session.js").Measures} Measures */

/** Edges near a place that are tested for being in sight, the nearest first. */
const MOST_EDGES = 4;

export class Picker {
  /** @param {Pick<import("./page.js").Page, "hidden" | "model" | "section" | "session" | "settings" | "viewpoint">} page */
  constructor(page) {
    this.page = page;
    /** The last request for measures. */
    this.measuring = 0;
  }

  /**
   * What is at a place of the canvas, CSS pixels; `null` also while there is no server to ask.
   * @param {number} x
   * @param {number} y
   * @returns {Promise<Hit | null>}
   */
  async surface(x, y) {
    const { session, section: plane, settings, viewpoint } = this.page;
    const { seeThrough, maps } = settings;
    const { origin, direction } = rayThrough(viewpoint.camera, viewpoint.size, x, y);
    const section = plane && [...plane.normal, plane.offset];
    const hidden = ranges(this.page.hidden);
    try {
      return (await session.request({ type: "pick", origin, direction, hidden, section, seeThrough, maps })).hit;
    } catch {
      return null;
    }
  }

  /**
   * The edge in sight at a place of the canvas, with the surface there.
   * @param {number} x
   * @param {number} y
   * @returns {Promise<{ place: EdgePlace, hit: Hit | null } | null>}
   */
  async edge(x, y) {
    const { model, section, settings, viewpoint } = this.page;
    if (!model || !settings.edges) return null;
    const { camera, size } = viewpoint;
    const places = edgesNear(model, camera, size, { x, y }, this.page.hidden, section);
    for (const place of places.slice(0, MOST_EDGES)) {
      const hit = await this.surface(place.x, place.y);
      if (isInSight(camera, size, place, hit?.point ?? null)) return { place, hit };
    }
    return null;
  }

  /**
   * Area and volume of the part that an item is in; `null` if there are none, and once others are asked for.
   * @param {Item | null} item
   * @returns {Promise<{ part: Item, measures: Measures } | null>}
   */
  async measures(item) {
    const number = ++this.measuring;
    const part = item?.node.kind === "shape" ? item.parent : item;
    if (!part || part.first === part.end) return null;
    try {
      const reply = await this.page.session.request({ type: "measure", leaves: [[part.first, part.end - 1]] });
      return number === this.measuring ? { part, measures: reply.measures } : null;
    } catch {
      return null;
    }
  }
}

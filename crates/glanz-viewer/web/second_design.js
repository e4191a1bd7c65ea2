/**
 * The second of two designs that are compared: its own view beside the first one's, with the same camera, settings and scale.
 *
 * @module
 */

import { Renderer } from "./gl/renderer.js";
import { fetchModel } from "./model.js";
import { Picker } from "./picker.js";
import { SceneParts } from "./scene_parts.js";
import { Session } from "./session.js";
import { create, element } from "./ui/dom.js";
import { PointerControls } from "./ui/pointer_controls.js";

/** @typedef {import("./gl/renderer.js").View} View */
/** @typedef {import("./model.js").Model} Model */
/** @typedef {import("./page.js").Page} Page */
/** @typedef {import("./session.js").Hit} Hit */

/** Milliseconds between pictures while programs are compiled. */
const COMPILE_PAUSE = 40;

export class SecondDesign {
  /** @param {Page} page of the first design */
  constructor(page) {
    this.page = page;
    this.canvas = create("canvas", "", "second");
    this.canvas.setAttribute("aria-label", "Second design");
    this.label = create("p", "", "design");
    this.renderer = new Renderer(this.canvas);
    element("view", HTMLCanvasElement).after(this.canvas, this.label);
    this.renderer.onRestored = () => page.invalidate();
    /** @type {Model | null} */
    this.model = null;
    /** @type {SceneParts | null} */
    this.parts = null;
    this.path = "";
    /** What tells it from the first design. */
    this.name = "";
    this.isClosed = false;
    const nothing = () => {};
    const url = new URL("ws?design=b", location.href.replace(/^http/, "ws"));
    this.session = new Session(url, {
      online: () => this.showLabel(),
      offline: () => (this.label.textContent = "B: no connection"),
      scene: (message) => this.enter(message),
      progress: nothing,
      waiting: nothing,
      tile: nothing,
      stopped: nothing,
      failed: nothing,
    });
    this.picker = new Picker(this);
    const listener = {
      pick: async (/** @type {number} */ x, /** @type {number} */ y) =>
        (await this.picker.surface(x, y))?.point ?? null,
      clicked: (/** @type {number} */ x, /** @type {number} */ y) => this.click(x, y),
      hover: (/** @type {{ x: number, y: number } | null} */ place) => this.hover(place),
      released: nothing,
    };
    this.pointer = new PointerControls(this.canvas, page.viewpoint, listener);
  }

  get settings() {
    return this.page.settings;
  }

  get viewpoint() {
    return this.page.viewpoint;
  }

  get section() {
    return this.page.section;
  }

  /** What is hidden in the first design, if this one has as many shapes. @returns {Set<number>} */
  get hidden() {
    const { parts, hidden } = this.page;
    return parts?.count === this.parts?.count ? hidden : new Set();
  }

  /** @param {import("./session.js").SceneMessage} message */
  async enter({ model, name, label, error }) {
    if (error !== null) this.page.showProblemOf(this, name, error);
    if (model === null || model === this.path) return;
    this.path = model;
    try {
      const found = await fetchModel(model);
      if (this.path !== model || this.isClosed) return;
      this.model = found;
      this.parts = new SceneParts(this.model.tree);
      this.renderer.setModel(this.model);
      this.page.problem = null;
      this.name = label;
      this.showLabel();
      this.page.showNotes();
      this.page.settingsChanged();
    } catch (error) {
      // Another scene may have come meanwhile, or the first page has gone on to a file of its own.
      if (this.path !== model || this.isClosed) return;
      this.path = "";
      this.page.showProblemOf(this, name, error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {{ x: number, y: number } | null} place */
  hover(place) {
    // A timer may still run.
    if (!this.isClosed) this.page.hover(place);
  }

  showLabel() {
    this.label.textContent = this.name && `B: ${this.name}`;
  }

  /**
   * Draws the view of the first design.
   * @param {View} view
   * @param {boolean} whole whether to wait for programs that the browser still compiles
   */
  draw(view, whole) {
    if (!this.model) return;
    const own = { ...view, hidden: this.hidden, selected: null, edge: null };
    const { pending } = whole ? this.renderer.drawWhole(own) : this.renderer.draw(own);
    if (pending > 0) setTimeout(() => this.page.invalidate(), COMPILE_PAUSE);
  }

  /**
   * A click: the next end of a distance while measuring, else what is known of a place, and how both designs differ there.
   * @param {number} x
   * @param {number} y
   */
  async click(x, y) {
    const number = ++this.page.selections;
    const [first, second] = await Promise.all([this.page.picker.surface(x, y), this.picker.surface(x, y)]);
    const { measure, properties } = this.page;
    if (this.isClosed) return;
    if (measure.active) {
      if (second) measure.add({ point: second.point, normal: second.normal });
      this.page.invalidate();
      return;
    }
    if (number !== this.page.selections) return;
    this.page.select(null, null);
    properties.show(second, second && (this.parts?.shape(second.leaf) ?? null));
    properties.addDifference(first?.lux ?? null, second?.lux ?? null);
  }

  /**
   * Adds the illuminances in both designs to the properties of what was picked in the first one.
   * @param {Hit | null} first
   * @param {number} x
   * @param {number} y
   */
  async addDifference(first, x, y) {
    const number = this.page.selections;
    const second = await this.picker.surface(x, y);
    if (number === this.page.selections && !this.isClosed)
      this.page.properties.addDifference(first?.lux ?? null, second?.lux ?? null);
  }

  close() {
    this.isClosed = true;
    this.page.problem = null;
    this.page.hover(null);
    this.session.close();
    this.renderer.delete();
    this.canvas.remove();
    this.label.remove();
  }
}

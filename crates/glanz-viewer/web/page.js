/**
 * State of the page, and everything that changes it.
 *
 * @module
 */

import { edgeDimensions } from "./edge_picking.js";
import { Renderer } from "./gl/renderer.js";
import { fetchModel } from "./model.js";
import { AdaptiveResolution } from "./adaptive_resolution.js";
import { Picker } from "./picker.js";
import { SceneParts, ranges } from "./scene_parts.js";
import { Session } from "./session.js";
import { defaultSettings, fullColour, luxSettings, luxSettingsText, realTimeOnly, sectionPlane } from "./settings.js";
import { levelsWithin, luxScale, roundLevels, sortedCells, typedLevels } from "./lux_scale.js";
import { SecondDesign } from "./second_design.js";
import { RenderedImage } from "./rendered_image.js";
import { announce, create, element } from "./ui/dom.js";
import { showProblem } from "./ui/files.js";
import { HOVER_PAUSE, PointerControls } from "./ui/pointer_controls.js";
import { showLegend } from "./ui/legend.js";
import { MeasureTool } from "./ui/measure_tool.js";
import { PropertiesPanel, edgeRows } from "./ui/properties_panel.js";
import { store, stored } from "./ui/storage.js";
import { StatusBar } from "./ui/status_bar.js";
import { backgroundColour } from "./ui/theme.js";
import { SettingsPanel } from "./ui/settings_panel.js";
import { SceneTree } from "./ui/scene_tree.js";
import { fixLengthUnit, luxText, luxTexts, pointText } from "./ui/units.js";
import { Viewpoint } from "./viewpoint.js";

/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./model.js").Model} Model */
/** @typedef {import("./scene_parts.js").Item} Item */
/** @typedef {import("./session.js").Hit} Hit */
/** @typedef {import("./session.js").SceneMessage} SceneMessage */

/** Name under which the browser keeps the settings of lux maps. */
const LUX_SETTINGS = "glanz-lux";

/** Milliseconds between pictures while tiles come in over a scene that must be drawn below them. */
const TILE_PAUSE = 250;

/** Milliseconds between pictures while programs are compiled. */
const COMPILE_PAUSE = 40;

/** Milliseconds that what was just selected is shown marked, before the rendered picture comes back. */
const GLANCE = 1000;

export class Page {
  constructor() {
    this.canvas = element("view", HTMLCanvasElement);
    this.renderer = new Renderer(this.canvas);
    this.renderer.onRestored = () => this.invalidate();
    this.settings = { ...defaultSettings(), ...luxSettings(stored(LUX_SETTINGS)) };
    /** @type {Model | null} */
    this.model = null;
    this.scene = { model: "", name: "", label: "", session: "" };
    /** The last error of a scene since one was shown, and which design had it. @type {{ design: object, heading: string, text: string } | null} */
    this.problem = null;
    /** The design that is shown beside this one. @type {SecondDesign | null} */
    this.second = null;
    /** The cells of both designs. @type {{ models: Model[], cells: Float32Array }} */
    this.luxCells = { models: [], cells: new Float32Array() };
    /** How illuminances are shown, `null` if there are none. @type {import("./gl/renderer.js").LuxDisplay | null} */
    this.lux = null;
    /** @type {SceneParts | null} */
    this.parts = null;
    /** The last pick. @type {Hit | null} */
    this.hit = null;
    /** The selected edge. @type {import("./gl/edge_lines.js").PlacedEdge | null} */
    this.edge = null;
    /** The last picture of the model. @type {ReturnType<Renderer["draw"]> | null} */
    this.frame = null;
    /** Pixels of the canvas when nothing moves. @type {import("./camera.js").Size} */
    this.size = { width: 1, height: 1 };
    this.resolution = new AdaptiveResolution();
    this.drawRequested = false;
    this.drawnAt = 0;
    /** The model is still to be drawn for the first time, soon rather than whole. */
    this.isNew = false;
    /** Until when what is selected is seen rather than what is rendered. */
    this.glanceUntil = 0;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.tileTimer = undefined;
    this.rendered = "";
    /** Whether the last picture was a rendered one without noise. */
    this.isDenoised = false;
    this.saveExr = element("save-exr", HTMLButtonElement);
    /** Number of the last pick or selection: answers to those before come too late. */
    this.selections = 0;
    /** Number of the last question for what is under the pointer: answers to those before come too late. */
    this.hovers = 0;
    /** Where the pointer rests. @type {{ x: number, y: number } | null} */
    this.hovering = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.hoverTimer = undefined;
    this.isReady = () => {};
    /** Once the first scene is drawn, with its shadows. @type {Promise<void>} */
    this.ready = new Promise((resolve) => (this.isReady = resolve));
    this.viewpoint = new Viewpoint(() => this.viewChanged());
    this.session = new Session(new URL("ws", location.href.replace(/^http/, "ws")), this.listener());
    this.renderedImage = new RenderedImage(this.session, () => this.renderedImageChanged());
    this.picker = new Picker(this);
    this.tree = new SceneTree({
      selected: (item) => this.select(item, null),
      visibility: () => this.visibilityChanged(),
    });
    this.properties = new PropertiesPanel();
    this.measure = new MeasureTool();
    this.status = new StatusBar();
    this.tools = new SettingsPanel(this.settings, () => this.settingsChanged());
    this.pointer = new PointerControls(this.canvas, this.viewpoint, {
      pick: async (x, y) => (await this.picker.surface(x, y))?.point ?? null,
      clicked: (x, y) => this.click(x, y),
      hover: (place) => this.hover(place),
      // A click without a move leaves the rendered picture as it is.
      released: () => this.renderedImage.id === null && this.viewChanged(),
    });
    document.addEventListener("visibilitychange", () => {
      if (this.renderedImage.hide(document.hidden)) this.viewChanged();
    });
    this.renderedImage.hide(document.hidden);
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
  }

  /** @returns {import("./session.js").Listener} */
  listener() {
    return {
      online: () => this.showMessage(""),
      offline: (pause) => {
        this.renderedImage.lost();
        this.showMessage(
          `Connection to the server lost. Next attempt in ${Math.round(pause / 1000) || "less than 1"} s.`,
        );
      },
      scene: (message) => this.enter(message),
      progress: (message) => this.renderedImage.progress(message),
      waiting: (id) => this.renderedImage.queued(id),
      tile: (tile) => this.renderedImage.tile(tile),
      stopped: (id) => this.renderedImage.stopped(id),
      failed: (id, text) => this.renderedImage.failed(id, text) || announce(text),
    };
  }

  /** @param {string} text over the view; nothing if it is empty */
  showMessage(text) {
    const message = element("message", HTMLElement);
    message.textContent = text;
    message.hidden = text === "";
    if (text) announce(text);
  }

  /**
   * Takes over a scene that the server has for this page.
   * @param {SceneMessage} message
   */
  async enter(message) {
    this.scene.session = message.session ?? "";
    if (this.model === null && message.integrator) this.settings.integrator = message.integrator;
    this.tools.allowDenoising(message.denoiser ?? null);
    this.compare(message.compared === true);
    if (message.error !== null) this.showProblemOf(this, message.name, message.error);
    if (message.model === null || message.model === this.scene.model) {
      // After the connection was made anew, the picture has to be asked for again.
      this.viewChanged();
      return;
    }
    const isSame = message.name === this.scene.name;
    this.scene = { model: message.model, name: message.name, label: message.label, session: this.scene.session };
    try {
      const model = await fetchModel(message.model);
      if (this.scene.model === message.model) this.show(model, isSame);
    } catch (error) {
      // Another scene may have come meanwhile.
      if (this.scene.model !== message.model) return;
      this.scene.model = "";
      this.showProblemOf(this, message.name, error instanceof Error ? error.message : String(error));
    }
  }

  /**
   * Shows why a scene cannot be shown: once, if it is that of both designs.
   * @param {object} design
   * @param {string} name
   * @param {string} text
   */
  showProblemOf(design, name, text) {
    const heading = `${name} cannot be shown`;
    const last = this.problem;
    if (last && last.design !== design && last.heading === heading && last.text === text) return;
    this.problem = { design, heading, text };
    showProblem(heading, text);
  }

  /** Shows a second design beside this one, or none. @param {boolean} isCompared */
  compare(isCompared) {
    if (isCompared === (this.second !== null)) return;
    this.second?.close();
    this.second = null;
    try {
      if (isCompared) this.second = new SecondDesign(this);
    } catch (error) {
      showProblem("The second design cannot be shown", error instanceof Error ? error.message : String(error));
    }
    element("main", HTMLElement).classList.toggle("compared", this.second !== null);
    this.showNotes();
    this.resize();
  }

  /**
   * @param {Model} model
   * @param {boolean} isSame it is that of the same scene, after a change
   */
  show(model, isSame) {
    this.renderer.setModel(model);
    this.problem = null;
    this.model = model;
    this.frame = null;
    this.isNew = !isSame;
    fixLengthUnit(model.lengthUnit);
    const parts = new SceneParts(model.tree);
    if (isSame && this.parts) parts.inherit(this.parts);
    this.parts = parts;
    this.tree.set(parts);
    if (!isSame) {
      this.settings.maps = model.maps.length > 0;
      this.settings.edges = model.edges.length > 0;
      // Whoever looks into a room from outside wants to see what light there is in it.
      this.settings.seeThrough = this.hasLux;
    }
    this.tools.write();
    this.measure.activate(false);
    this.select(parts.selected, null);
    element("name", HTMLElement).textContent = model.name;
    element("first-design", HTMLElement).textContent = `A: ${this.scene.label}`;
    document.title = `${model.name} – Glanz`;
    this.canvas.setAttribute("aria-label", `${model.name}, ${parts.count} shapes`);
    this.showNotes();
    announce(`${model.name} is open, ${parts.count} shapes`);
    this.viewpoint.enter(model, isSame);
    this.settingsChanged();
  }

  /** Shows the notes of one design or two. */
  showNotes() {
    const second = this.second?.model?.notes ?? [];
    const notes = [...(this.model?.notes ?? []), ...second.map((note) => `B: ${note}`)];
    element("notes", HTMLElement).hidden = notes.length === 0;
    element("note-list", HTMLElement).replaceChildren(...notes.map((note) => create("li", note)));
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const width = Math.max(1, Math.round(clientWidth * devicePixelRatio));
    const height = Math.max(1, Math.round(clientHeight * devicePixelRatio));
    this.viewpoint.size = { width: Math.max(1, clientWidth), height: Math.max(1, clientHeight) };
    if (width !== this.size.width || height !== this.size.height) {
      this.size = { width, height };
      this.viewChanged();
    }
  }

  /** Hidden leaves. @returns {Set<number>} */
  get hidden() {
    return this.parts?.hidden ?? new Set();
  }

  /** The plane that cuts the scene, `null` if none does. */
  get section() {
    return sectionPlane(this.settings, this.viewpoint.bounds);
  }

  /**
   * @param {number} share of the sides' pixels
   * @returns {import("./gl/renderer.js").View}
   */
  view(share = 1) {
    const { exposure, shading, stripes, isocurves, edges, net, maps, seeThrough } = this.settings;
    return {
      camera: this.viewpoint.camera,
      width: Math.ceil(this.size.width * share),
      height: Math.ceil(this.size.height * share),
      hidden: this.hidden,
      selected: this.parts?.selectedLeaf ?? null,
      curvature: fullColour(this.settings, this.viewpoint.extent),
      section: this.section,
      // Slow graphics do without while something moves, and at first: seams and shadows take as long as the rest.
      seams: share === 1 && !this.isNew,
      shadows: !this.isNew,
      edge: this.edge,
      background: backgroundColour(),
      ...{ exposure, shading, stripes, isocurves, edges, net, maps, seeThrough, lux: this.lux },
    };
  }

  /** The request for the server, `null` if nothing is to be rendered. */
  wanted() {
    const { integrator, denoise } = this.settings;
    if (!this.parts || integrator === "none" || this.pointer.isDragging || this.viewpoint.isMoving) return null;
    const { camera } = this.viewpoint;
    return { camera, size: this.size, hidden: ranges(this.parts.hidden), integrator, denoise };
  }

  /** The view changed: draws at once, and requests a rendering when the camera rests. */
  viewChanged() {
    this.resolution.moved(performance.now());
    this.rendered = this.rendering;
    this.renderedImage.restart(this.rendered.startsWith("by") ? () => this.wanted() : null);
    this.invalidate();
    clearTimeout(this.hoverTimer);
    this.hoverTimer = setTimeout(() => this.updateHover(), HOVER_PAUSE);
  }

  get hasEdges() {
    return (this.model?.edges.length ?? 0) > 0;
  }

  /** The models of one design or two. */
  get models() {
    return [this.model, this.second?.model ?? null].filter((model) => model !== null);
  }

  /** Whether surfaces show maps: receivers that are meshes have illuminances, but no map. */
  get hasMaps() {
    return this.models.some(({ shownMaps }) => shownMaps.length > 0);
  }

  /** Whether surfaces show illuminances. */
  get hasLux() {
    return this.models.some(({ shownMaps }) => shownMaps.some(({ channels }) => channels === 1));
  }

  /** Whether there are walls that can be left out from outside. */
  get hasWalls() {
    return this.models.some(({ hasWalls }) => hasWalls);
  }

  /** Reason why nothing is rendered, `null` if there is none. */
  get realTimeOnly() {
    const { hasEdges, hasMaps, hasWalls } = this;
    return realTimeOnly(this.settings, { hasEdges, hasMaps, hasWalls, isCompared: this.second !== null });
  }

  /** The settings that the rendered picture depends on, as a key. */
  get rendering() {
    if (!this.model) return "no scene";
    const { integrator, denoise } = this.settings;
    return this.realTimeOnly ?? `by ${integrator}${denoise ? ", denoised" : ""}`;
  }

  settingsChanged() {
    const { extent } = this.viewpoint;
    const { hasMaps, hasLux, hasWalls } = this;
    this.updateLux();
    this.tools.describe(extent, this.section, { hasMaps, hasLux, hasWalls });
    showLegend(this.settings, fullColour(this.settings, extent), this.lux);
    // Exposure works on the picture that is there.
    if (this.rendering === this.rendered) this.invalidate();
    else this.viewChanged();
    this.updateHover();
  }

  /** Finds the scale of illuminances, which two designs share, and the levels of isolux lines. */
  updateLux() {
    const { luxScale: kind, luxTail, isolux, isoluxLevels } = this.settings;
    if (!this.hasLux) {
      this.lux = null;
      this.luxCells = { models: [], cells: new Float32Array() };
      return;
    }
    const { models } = this;
    if (models.length !== this.luxCells.models.length || models.some((model, i) => model !== this.luxCells.models[i]))
      this.luxCells = { models, cells: sortedCells(models.map(({ blocks }) => blocks.luxCells)) };
    const scale = luxScale(this.luxCells.cells, kind, luxTail);
    const { levels } = typedLevels(isoluxLevels);
    const wanted = levels.length > 0 ? levels : roundLevels(scale);
    this.lux = { scale, levels: isolux ? levelsWithin(this.luxCells.cells, wanted) : [] };
    store(LUX_SETTINGS, luxSettingsText(this.settings));
  }

  /** The settings were changed by something else than their controls. */
  settingsSet() {
    this.tools.write();
    this.settingsChanged();
  }

  visibilityChanged() {
    this.tree.refresh();
    this.viewChanged();
  }

  /** Schedules a draw before the next frame. */
  invalidate() {
    if (this.drawRequested) return;
    this.drawRequested = true;
    requestAnimationFrame(() => {
      this.drawRequested = false;
      this.draw();
    });
  }

  /** New tiles of the rendered image arrived. While it has holes the scene is drawn below it, so draws are limited to leave time for rendering. */
  renderedImageChanged() {
    const pause = this.renderedImage.picture?.covered ? 0 : TILE_PAUSE - (performance.now() - this.drawnAt);
    if (pause <= 0) this.invalidate();
    else this.tileTimer ??= setTimeout(() => this.invalidate(), pause);
  }

  /** @param {boolean} whole whether to wait for programs that the browser still compiles */
  draw(whole = false) {
    clearTimeout(this.tileTimer);
    this.tileTimer = undefined;
    this.drawnAt = performance.now();
    const { picture, status } = this.renderedImage;
    this.status.show(status, this.settings.integrator, this.realTimeOnly);
    element("orthographic", HTMLInputElement).checked = this.viewpoint.camera.kind === "orthographic";
    this.saveExr.disabled = (status?.samples ?? 0) === 0;
    if (!this.model) return;
    const share = whole ? 1 : this.resolution.shareAt(this.drawnAt);
    // A picture that is saved has everything.
    if (whole) this.isNew = false;
    const view = this.view(share);
    const { isNew } = this;
    const glance = this.drawnAt < this.glanceUntil;
    if (glance || !picture?.covered) this.drawScene(view, share, whole);
    const isDrawn = picture?.covered || this.frame?.pending === 0;
    const isRendered = picture !== null && !glance && !picture.empty && isDrawn;
    if (isRendered) this.renderer.drawRenderedImage(picture, view);
    this.isDenoised = isRendered && status?.denoised != null;
    this.second?.draw(view, whole);
    this.measure.draw(view.camera, this.viewpoint.size);
    if (picture?.covered || (this.frame?.pending === 0 && !isNew)) this.isReady();
  }

  /**
   * Draws in real time; again soon, if the browser still compiles some of the programs.
   * @param {import("./gl/renderer.js").View} view
   * @param {number} share of the sides' pixels, as in `view`
   * @param {boolean} whole
   */
  drawScene(view, share, whole) {
    const start = performance.now();
    this.frame = whole ? this.renderer.drawWhole(view) : this.renderer.draw(view);
    // The browser holds frames back until the graphics card has done with those before.
    requestAnimationFrame(() => requestAnimationFrame(() => this.resolution.record(share, performance.now() - start)));
    if (share < 1) setTimeout(() => this.invalidate(), this.resolution.untilRest(start));
    if (this.frame.pending > 0) setTimeout(() => this.invalidate(), COMPILE_PAUSE);
    else if (this.isNew) {
      this.isNew = false;
      setTimeout(() => this.invalidate(), COMPILE_PAUSE);
    }
  }

  /**
   * Selects a part, and shows what is known of it.
   * @param {Item | null} item
   * @param {Hit | null} hit where it was picked
   */
  select(item, hit) {
    this.selections += 1;
    this.hit = hit;
    this.edge = null;
    this.parts?.select(item);
    this.tree.reveal();
    this.properties.show(hit, item);
    this.measurePart(item);
    this.tools.allowPicked(hit !== null);
    if (item) announce(hit ? `${item.label}, ${hit.kind}, at ${pointText(hit.point)}` : item.label);
    // The rendered picture does not show what is selected.
    this.glanceUntil = performance.now() + GLANCE;
    setTimeout(() => this.invalidate(), GLANCE);
    this.settingsChanged();
  }

  /**
   * Shows area and volume of the part that an item is in, once the server has them.
   * @param {Item | null} item
   */
  async measurePart(item) {
    const found = await this.picker.measures(item);
    if (found) this.properties.add(found.part, found.measures);
  }

  /** @param {import("./gl/edge_lines.js").PlacedEdge} placed */
  selectEdge({ copy, edge }) {
    if (!this.model) return;
    this.select(null, null);
    this.edge = { copy, edge };
    const { firstLeaf } = this.model.edgeCopies[copy];
    const shapes = new Set(this.model.edges[edge].shapes);
    const faces = [...shapes].map((shape) => this.parts?.shape(firstLeaf + shape)?.label ?? "");
    const rows = edgeRows(edgeDimensions(this.model, this.edge), faces);
    this.properties.showRows(rows);
    this.properties.shown = Object.fromEntries(rows);
    announce(rows.map((row) => row.join(" ")).join(", "));
    this.invalidate();
  }

  /**
   * A click: the next end of a distance while measuring, else what is to be selected. Edges come before the surfaces beside them.
   * @param {number} x
   * @param {number} y
   */
  async click(x, y) {
    const number = ++this.selections;
    const edge = await this.picker.edge(x, y);
    const hit = edge ? edge.hit : await this.picker.surface(x, y);
    if (this.measure.active) {
      const point = edge?.place.point ?? hit?.point;
      if (point) this.measure.add({ point, normal: hit?.normal ?? null });
      this.invalidate();
      return;
    }
    if (number !== this.selections) return;
    if (edge) {
      this.selectEdge(edge.place);
      return;
    }
    if (!hit) announce("No surface here");
    this.select(hit ? (this.parts?.shape(hit.leaf) ?? null) : null, hit);
    this.second?.addDifference(hit, x, y);
  }

  /** Shows again what is under the pointer, which rests, after what is shown there has changed. */
  updateHover() {
    if (this.hovering) this.hover(this.hovering);
  }

  /** @param {{ x: number, y: number } | null} place */
  async hover(place) {
    const number = ++this.hovers;
    this.hovering = place;
    const pickers = [this.picker, ...(this.second ? [this.second.picker] : [])];
    const hits =
      place && this.model ? await Promise.all(pickers.map((picker) => picker.surface(place.x, place.y))) : [];
    // The pointer may be elsewhere by now, or another scene below it.
    if (number !== this.hovers) return;
    const readings = hits.map((hit) => hit?.lux ?? null);
    const [only = null] = readings;
    const text = this.second ? luxTexts(only, readings[1] ?? null) : only ? luxText(only) : "";
    this.status.point(hits[0]?.point ?? hits[1]?.point ?? null, this.settings.maps ? text : "");
  }
}

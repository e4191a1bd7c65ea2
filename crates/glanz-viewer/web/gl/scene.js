/**
 * A model on the graphics card, and how it is drawn.
 *
 * @module
 */

import { dot } from "../linear.js";
import { AlgebraicSurfaces } from "./algebraic.js";
import { EdgeLines } from "./edge_lines.js";
import { boxesOfSurfaces, isCut } from "./surface_boxes.js";
import { FRAME_FLOATS, Frame, PLACE, SEAM, WALLS } from "./frame.js";
import { Lights } from "./lights.js";
import { Meshes } from "./meshes.js";
import { ControlNets } from "./control_nets.js";
import { Patches } from "./patches.js";
import { FRAME_BINDING, UNITS } from "./programs.js";
import { SceneTables } from "./scene_tables.js";
import { Shadows } from "./shadows.js";
import { DataTexture } from "./data_texture.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./shading_modes.js").ShadingMode} ShadingMode */
/** @typedef {import("./patches.js").FrameStatistics} FrameStatistics */
/** @typedef {import("./programs.js").Programs} Programs */
/** @typedef {import("./renderer.js").View} View */

/** Distance of surfaces that fill seams behind those that are drawn as they are, pixels. */
const SEAM_DEPTH = 3;

export class Scene {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Programs} programs
   * @param {Model} model
   */
  constructor(gl, programs, model) {
    this.gl = gl;
    this.programs = programs;
    this.model = model;
    this.tables = new SceneTables(gl, model);
    this.places = new DataTexture(gl, "RGBA32F");
    this.rows = new Float32Array(model.objects.length * PLACE);
    this.positions = new Float64Array(model.objects.length * 12);
    this.patches = new Patches(gl, model, this.tables.maps);
    this.meshes = new Meshes(gl, model);
    this.algebraic = new AlgebraicSurfaces(gl, model);
    this.nets = new ControlNets(gl, model);
    this.edges = new EdgeLines(gl, model);
    this.lights = new Lights(model);
    this.shadows = new Shadows(gl, model, this.lights.main);
    this.boxes = boxesOfSurfaces(model);
    this.block = new Float32Array(FRAME_FLOATS);
    this.uniforms = gl.createBuffer();
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.uniforms);
    gl.bufferData(gl.UNIFORM_BUFFER, this.block.byteLength, gl.DYNAMIC_DRAW);
  }

  /** Indices of the visible objects, split into opaque and transparent ones. @param {View} view */
  shownObjects(view) {
    const { objects, materials, maps } = this.model;
    /** @type {{ opaque: number[], clear: number[] }} */
    const shown = { opaque: [], clear: [] };
    objects.forEach((object, i) => {
      if (view.hidden.has(object.leaf)) return;
      // Receivers that light passes show illuminances as if they were opaque.
      const isLux = view.maps && object.map !== null && maps[object.map].channels === 1;
      const list = materials[object.material].opacity < 1 && !isLux ? shown.clear : shown.opaque;
      list.push(i);
    });
    return shown;
  }

  /**
   * Draws the view into the target that is bound and cleared.
   * @param {View} view
   * @param {ShadingMode} mode
   * @param {boolean} wait for programs that are being compiled
   * @returns {FrameStatistics}
   */
  draw(view, mode, wait) {
    const { gl } = this;
    const statistics = { patches: 0, quads: 0, triangles: 0, draws: 0 };
    const { opaque, clear } = this.shownObjects(view);
    const blended = mode === "material" ? clear : [];
    const solid = mode === "material" ? opaque : [...opaque, ...clear];
    const frame = new Frame(view.camera, view.width, view.height);
    this.markCut(view);
    this.place(frame);
    // For the depths of the clipping planes alone: what is blended is found again, one object at a time.
    if (blended.length > 0) this.cull(frame, blended);
    this.cull(frame, solid);
    frame.write(this.block);
    this.writeShading(frame, view);
    this.shadows.write(this.block, frame);
    this.lights.write(this.block, frame, this.shadows.known);
    this.upload();
    gl.enable(gl.DEPTH_TEST);
    if (mode !== "read") gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    this.drawSurfaces(mode, wait, statistics);
    if (view.seams && mode !== "read") this.fillSeams(mode, wait, statistics);
    if (view.edges && mode !== "read") this.edges.draw(this.programs, frame, view.hidden, view.edge, wait);
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    if (view.net && mode !== "read") this.drawNets(view, wait, statistics);
    this.drawBlended(frame, blended, wait, statistics);
    return statistics;
  }

  /**
   * Draws faces that share edges again, up to 0.9 pixels larger, past the sides of their patches, too, and some pixels farther away, so that they are seen
   * only where the samples of a pixel on an edge are covered by neither of its faces.
   * @param {ShadingMode} mode @param {boolean} wait @param {FrameStatistics} statistics
   */
  fillSeams(mode, wait, statistics) {
    this.block[SEAM] = SEAM_DEPTH;
    this.upload();
    this.patches.draw(this.programs, mode, wait, statistics, true);
    this.block[SEAM] = 0;
    this.upload();
  }

  /**
   * Draws the edges that no opaque surface hides, and nothing else, into the target that is bound; its depths are cleared.
   * @param {View} view
   * @param {() => void} behind draws what is behind them
   */
  drawEdges(view, behind) {
    const { gl } = this;
    const frame = new Frame(view.camera, view.width, view.height);
    const { opaque, clear } = this.shownObjects(view);
    this.place(frame);
    // For the depths of the clipping planes alone: objects that let light through have edges, too.
    if (clear.length > 0) this.cull(frame, clear);
    this.cull(frame, opaque);
    frame.write(this.block);
    this.writeShading(frame, view);
    this.upload();
    gl.enable(gl.DEPTH_TEST);
    gl.colorMask(false, false, false, false);
    this.drawSurfaces("depth", true, { patches: 0, quads: 0, triangles: 0, draws: 0 });
    gl.colorMask(true, true, true, true);
    behind();
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    this.edges.draw(this.programs, frame, view.hidden, view.edge, true);
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
  }

  /** @param {View} view @param {boolean} wait @param {FrameStatistics} statistics */
  drawNets(view, wait, statistics) {
    const { opaque, clear } = this.shownObjects(view);
    const { objects } = this.model;
    const chosen = [...opaque, ...clear].filter((i) => view.selected === null || objects[i].leaf === view.selected);
    this.nets.draw(this.programs, chosen, wait, statistics);
  }

  /**
   * Draws objects that let light through over what is there, far ones first.
   * @param {Frame} frame
   * @param {number[]} objects
   * @param {boolean} wait
   * @param {FrameStatistics} statistics
   */
  drawBlended(frame, objects, wait, statistics) {
    if (objects.length === 0) return;
    const { gl } = this;
    const depth = (/** @type {number} */ i) => this.positions[12 * i + 11];
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    for (const number of [...objects].sort((a, b) => depth(b) - depth(a))) {
      this.cull(frame, [number]);
      this.drawSurfaces("material", wait, statistics);
    }
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  /** Draws what `cull` found. @param {ShadingMode} mode @param {boolean} wait @param {FrameStatistics} statistics */
  drawSurfaces(mode, wait, statistics) {
    this.patches.draw(this.programs, mode, wait, statistics);
    this.meshes.draw(this.programs, mode, wait, statistics);
    this.algebraic.draw(this.programs, mode, wait, statistics, this.positions);
  }

  /** Begins to compile the programs of a view. @param {View} view @param {boolean} shadows */
  prepare({ shading, edges }, shadows) {
    for (const mode of /** @type {ShadingMode[]} */ (shadows && this.shadows.light ? [shading, "depth"] : [shading])) {
      for (const surfaces of [this.patches, this.meshes, this.algebraic]) surfaces.prepare(this.programs, mode);
    }
    if (edges && !this.edges.isEmpty) this.edges.program(this.programs, false);
  }

  /** Puts the places of objects, as seen from a frame's camera, on the graphics card. @param {Frame} frame */
  place(frame) {
    frame.place(this.model.objects, this.rows, this.positions);
    this.places.write(this.rows);
  }

  /** Marks the objects that the section plane cuts, in a number of their rows that is free. @param {View} view */
  markCut({ section }) {
    this.model.objects.forEach(({ surface, toWorld }, i) => {
      this.rows[PLACE * i + 3] = section !== null && isCut(this.boxes[surface], toWorld, section) ? 1 : 0;
    });
  }

  /** Finds what a frame shows of these objects. @param {Frame} frame @param {number[]} objects */
  cull(frame, objects) {
    this.patches.cull(frame, this.positions, objects);
    this.meshes.cull(frame, this.positions, objects);
    this.algebraic.cull(frame, this.positions, objects);
  }

  /** Makes the shadow map if it is not that of what is to be seen. @param {View} view @param {boolean} wait */
  updateShadows(view, wait) {
    const key = JSON.stringify([[...view.hidden].sort((a, b) => a - b), view.section]);
    const { objects, materials } = this.model;
    const isCaster = (/** @type {number} */ i) => !objects[i].light && materials[objects[i].material].opacity >= 1;
    const casters = this.shownObjects(view).opaque.filter(isCaster);
    this.shadows.update(key, (frame) => {
      this.place(frame);
      this.cull(frame, casters);
      frame.write(this.block);
      this.writeSection(frame, view);
      this.upload();
      this.gl.enable(this.gl.DEPTH_TEST);
      const before = this.programs.pending;
      const statistics = { patches: 0, quads: 0, triangles: 0, draws: 0 };
      this.drawSurfaces("depth", wait, statistics);
      return this.programs.pending === before;
    });
  }

  /** @param {Frame} frame @param {View} view */
  writeSection(frame, view) {
    const { section } = view;
    if (!section) {
      this.block.fill(0, 12, 16);
      return;
    }
    const offset = section.offset - dot(section.normal, frame.camera.position);
    this.block.set([...frame.turn(section.normal), offset], 12);
  }

  /** @param {Frame} frame @param {View} view */
  writeShading(frame, view) {
    this.writeSection(frame, view);
    this.block.set([2 ** view.exposure, view.selected ?? -1], 10);
    this.block[WALLS] = view.seeThrough ? 1 : 0;
    this.patches.lux = view.lux;
    this.block.set([...frame.turn(this.model.up), view.stripes], 16);
    // Borders of patches and trimming curves, where the model does not tell which of them are edges.
    this.block.set(
      [view.edges && this.edges.isEmpty ? 1 : 0, view.isocurves, view.maps ? 1 : 0, view.curvature || 1],
      20,
    );
  }

  /** Sends the shared block, and binds all textures. */
  upload() {
    const { gl } = this;
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.uniforms);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, this.block);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, FRAME_BINDING, this.uniforms);
    this.tables.bind();
    this.places.bind(UNITS.objectPlaces);
    this.shadows.map.bind(UNITS.shadowMap);
  }

  delete() {
    this.tables.delete();
    this.places.delete();
    this.patches.delete();
    this.meshes.delete();
    this.algebraic.delete();
    this.nets.delete();
    this.edges.delete();
    this.shadows.delete();
    this.gl.deleteBuffer(this.uniforms);
  }
}

/**
 * Draws a model on a canvas with WebGL2: the door of this folder.
 *
 * @module
 */

import { prepareForCad } from "./patches.js";
import { Programs } from "./programs.js";
import { Scene } from "./scene.js";
import { MultisampledTarget, FloatTarget } from "./render_targets.js";
import { RenderedImageTexture } from "./rendered_image_texture.js";

/** @typedef {import("../linear.js").Vector} Vector */
/** @typedef {import("../model.js").Camera} Camera */
/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./patches.js").FrameStatistics} FrameStatistics */
/** @typedef {import("./rendered_image_texture.js").RenderedImage} RenderedImage */

/** How illuminances are shown; `levels`: of isolux lines, lx. @typedef {{ scale: import("../lux_scale.js").LuxScale, levels: number[] }} LuxDisplay */

/**
 * The view to draw and its shading (docs/viewer.md). `shadows`: true if it is not given.
 * @typedef {{ camera: Camera, width: number, height: number, hidden: Set<number>, selected: number | null, exposure: number,
 *   shading: "material" | "zebra" | "gaussian" | "mean" | "maximum" | "normals", stripes: number, curvature: number,
 *   edges: boolean, isocurves: number, net: boolean, section: { normal: Vector, offset: number } | null, maps: boolean,
 *   lux: LuxDisplay | null, seeThrough: boolean, seams: boolean, shadows?: boolean, edge: import("./edge_lines.js").PlacedEdge | null, background: Vector }} View
 */

/** Resources that are recreated after the graphics context was lost. */
class Context {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.programs = new Programs(gl);
    this.target = new MultisampledTarget(gl);
    this.renderedImage = new RenderedImageTexture(gl);
    /** @type {Scene | null} */
    this.scene = null;
  }
}

export class Renderer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @throws {Error} that says what the browser lacks
   */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", {
      antialias: false,
      alpha: true,
      depth: false,
      powerPreference: "high-performance",
    });
    if (!gl) throw new Error("This browser offers no WebGL2. Switch on graphics acceleration, or use a newer browser.");
    this.canvas = canvas;
    this.gl = gl;
    /** @type {Model | null} */
    this.model = null;
    /** Called when there is reason to draw again: the graphics context has come back. */
    this.onRestored = () => {};
    this.context = this.begin();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.context = this.begin();
      if (this.model) this.setModel(this.model);
      this.onRestored();
    });
  }

  begin() {
    if (!this.gl.getExtension("EXT_color_buffer_float")) {
      throw new Error("This graphics card cannot render to float textures (EXT_color_buffer_float).");
    }
    return new Context(this.gl);
  }

  /** @param {Model} model @throws {Error} if it is too large for the graphics card */
  setModel(model) {
    const { context } = this;
    this.model = model;
    context.scene?.delete();
    context.scene = null;
    if (!this.gl.isContextLost()) context.scene = new Scene(this.gl, context.programs, model);
  }

  /** Begins to compile what most models of CAD files need. @param {View["shading"]} shading */
  prepareForCad(shading) {
    if (!this.gl.isContextLost()) prepareForCad(this.context.programs, shading);
  }

  /**
   * Draws the view; nothing while programs of its surfaces are being compiled: parts of it would delay the whole. `pending` counts programs: draw again soon if it is not 0.
   * @param {View} view
   * @returns {FrameStatistics & { pending: number }}
   */
  draw(view) {
    return this.drawView(view, false);
  }

  /** Like `draw`, but waits for programs. @param {View} view */
  drawWhole(view) {
    return this.drawView(view, true);
  }

  /** @param {View} view @param {boolean} wait */
  drawView(view, wait) {
    const { gl } = this;
    const { programs, target, scene } = this.context;
    const nothing = { patches: 0, quads: 0, triangles: 0, draws: 0, pending: 0 };
    if (gl.isContextLost()) return nothing;
    programs.clearPending();
    const shadows = view.shading === "material" && view.shadows !== false;
    if (!wait) scene?.prepare(view, shadows);
    if (programs.pending > 0) return { ...nothing, pending: programs.pending };
    this.fit(view);
    if (shadows) scene?.updateShadows(view, wait);
    target.begin(view.width, view.height);
    gl.clearColor(...view.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const statistics = scene?.draw(view, view.shading, wait) ?? nothing;
    target.resolve();
    return { ...statistics, pending: programs.pending };
  }

  /**
   * Draws the rendered picture over what is drawn, enlarged or reduced to the view's size, and the model's edges over it. Takes over what has changed in it.
   * What is drawn is the same view, unless the picture covers it.
   * @param {RenderedImage} image
   * @param {View} view
   */
  drawRenderedImage(image, view) {
    if (this.gl.isContextLost()) return;
    const { renderedImage: texture, programs, scene, target } = this.context;
    this.fit(view);
    texture.update(image);
    const draw = () => texture.draw(programs, view.width, view.height, 2 ** view.exposure);
    if (!view.edges || !scene || scene.edges.isEmpty) {
      this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, null);
      draw();
      return;
    }
    target.begin(view.width, view.height);
    // Where the picture has holes, the target shows the scene that was drawn last.
    this.gl.clear((image.covered ? this.gl.COLOR_BUFFER_BIT : 0) | this.gl.DEPTH_BUFFER_BIT);
    scene.drawEdges(view, draw);
    target.resolve();
  }

  /**
   * What is at the middle of every pixel: normal (world, towards the viewer) and number of the object + 1, or 0 for nothing; rows from the top.
   * @param {View} view
   * @returns {{ width: number, height: number, data: Float32Array }}
   */
  readNormals(view) {
    const { gl } = this;
    const { width, height } = view;
    const { scene } = this.context;
    if (gl.isContextLost() || !scene) return { width, height, data: new Float32Array(width * height * 4) };
    const numbers = new FloatTarget(gl, width, height);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    scene.draw(view, "read", true);
    const data = numbers.read();
    numbers.delete();
    return { width, height, data };
  }

  /** Frees the graphics card. */
  delete() {
    this.context.scene?.delete();
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  /** Gives the canvas the view's size. @param {View} view */
  fit({ width, height }) {
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
  }
}

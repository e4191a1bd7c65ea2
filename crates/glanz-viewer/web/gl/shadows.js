/**
 * The shadows of the main light: a map of depths seen from it, made anew only when the scene changes.
 *
 * @module
 */

import { add, cross, length, normalize, scale, subtract } from "../linear.js";
import { Frame } from "./frame.js";
import { DepthTarget } from "./render_targets.js";

/** @typedef {import("../linear.js").Vector} Vector */
/** @typedef {import("../model.js").Camera} Camera */
/** @typedef {import("../model.js").Light} Light */
/** @typedef {import("../model.js").Model} Model */

/** Texels of the map across, for light from far away, and of each of the six faces around a lamp. */
const DISTANT_TEXELS = 2048;
const FACE_TEXELS = 1024;

/** Objects nearer to a light than this fraction of its distance to the farthest corner cast no shadow. */
const NEAREST = 2e-3;

/** The axes of the world, as the six faces see them: along the axis, beside it the two that follow. */
const AXES = /** @type {Vector[]} */ ([
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
]);

export class Shadows {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Model} model
   * @param {Light | null} light
   */
  constructor(gl, model, light) {
    this.gl = gl;
    this.light = light;
    this.bounds = model.bounds;
    this.distant = light?.kind === "distant";
    const [width, height] = this.distant ? [DISTANT_TEXELS, DISTANT_TEXELS] : [3 * FACE_TEXELS, 2 * FACE_TEXELS];
    this.map = light ? new DepthTarget(gl, width, height) : new DepthTarget(gl, 1, 1);
    /** Key of the content of the map; empty if there is none. */
    this.key = "";
    this.across = 0;
    this.slope = 0;
    this.offset = 0;
  }

  /** @returns {boolean} whether there is a map to be read */
  get known() {
    return this.light !== null && this.key !== "";
  }

  /**
   * Makes the map if the scene differs from the last one.
   * @param {string} key says what is drawn
   * @param {(frame: Frame) => boolean} drawDepths draws depths; false if programs are still being compiled
   */
  update(key, drawDepths) {
    if (!this.light || key === this.key) return;
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.map.framebuffer);
    gl.viewport(0, 0, this.map.width, this.map.height);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    // Depths grow with the slope of what is drawn: the map lies a little behind it.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1.5, 2);
    const complete = this.distant ? this.drawDistant(drawDepths) : this.drawFaces(drawDepths);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.key = complete ? key : "";
  }

  /** @param {(frame: Frame) => boolean} drawDepths */
  drawDistant(drawDepths) {
    const camera = this.distantCamera();
    const frame = new Frame(camera, DISTANT_TEXELS, DISTANT_TEXELS);
    frame.fixDepths(-camera.height, camera.height);
    this.remember(frame);
    this.across = camera.height;
    this.gl.viewport(0, 0, DISTANT_TEXELS, DISTANT_TEXELS);
    return drawDepths(frame);
  }

  /** @param {(frame: Frame) => boolean} drawDepths */
  drawFaces(drawDepths) {
    const reach = this.reach();
    let complete = true;
    for (let face = 0; face < 6; face++) {
      const axis = face % 3;
      const frame = new Frame(this.faceCamera(axis, face < 3 ? 1 : -1), FACE_TEXELS, FACE_TEXELS);
      frame.fixDepths(NEAREST * reach, reach);
      this.remember(frame);
      this.gl.viewport(axis * FACE_TEXELS, face < 3 ? 0 : FACE_TEXELS, FACE_TEXELS, FACE_TEXELS);
      complete = drawDepths(frame) && complete;
    }
    return complete;
  }

  /** @param {Frame} frame */
  remember(frame) {
    const { slope, offset } = frame.depths();
    this.slope = slope;
    this.offset = offset;
  }

  /** Distance from the light to the farthest corner of the scene. */
  reach() {
    const [low, high] = this.bounds;
    const { position } = /** @type {Light} */ (this.light);
    const farthest = /** @type {Vector} */ (
      position.map((x, axis) => Math.max(Math.abs(low[axis] - x), Math.abs(high[axis] - x)))
    );
    return length(farthest);
  }

  /** @param {number} axis @param {number} sign @returns {Camera} */
  faceCamera(axis, sign) {
    const { position } = /** @type {Light} */ (this.light);
    const [right, up, forward] = [AXES[(axis + 1) % 3], AXES[(axis + 2) % 3], scale(AXES[axis], sign)];
    return { kind: "perspective", position, right, up, forward, fieldOfView: Math.PI / 2, height: 0, distance: 1 };
  }

  /** @returns {Camera} */
  distantCamera() {
    const [low, high] = this.bounds;
    const position = scale(add(low, high), 0.5);
    const height = 1.02 * length(subtract(high, low));
    const forward = normalize(/** @type {Light} */ (this.light).direction);
    const beside = Math.abs(forward[2]) < 0.9 ? AXES[2] : AXES[0];
    const right = normalize(cross(forward, beside));
    const up = cross(right, forward);
    return { kind: "orthographic", position, right, up, forward, fieldOfView: 0, height, distance: height };
  }

  /**
   * Writes how a camera's axes become those of the map.
   * @param {Float32Array} block
   * @param {Frame} frame
   */
  write(block, frame) {
    if (!this.known) {
      block.fill(0, 48, 64);
      return;
    }
    const camera = this.distant ? this.distantCamera() : this.faceCamera(2, 1);
    const eye = subtract(frame.camera.position, camera.position);
    const axes = [camera.right, camera.up, camera.forward];
    axes.forEach((axis, k) => {
      const along = axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2];
      block.set([...frame.turn(axis), along], 48 + 4 * k);
    });
    block.set([this.distant ? 1 : 2, this.across, this.slope, this.offset], 60);
  }

  delete() {
    this.map.delete();
  }
}

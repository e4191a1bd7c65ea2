/**
 * A view as the shaders see it: everything relative to the eye, in the camera's axes (right, up, forward).
 *
 * @module
 */

import { dot, subtract } from "../linear.js";

/** @typedef {import("../linear.js").Vector} Vector */
/** @typedef {import("../model.js").Camera} Camera */
/** @typedef {import("../model.js").SceneObject} SceneObject */

/** Lights that shaders add up; further ones are left out, dimmest first. */
export const MOST_LIGHTS = 32;

/** Floats per row of the texture of object transforms: four texels, of which the last numbers are free. */
export const PLACE = 16;

/** The block of uniforms that all programs share; `FRAME_FLOATS` numbers. */
export const FRAME_TEXT = `
struct Light {
  vec4 position;   // camera's axes; w: 0 distant, 1 point, 2 spot, 3 area
  vec4 direction;  // along which it shines; w: cosine of the inner angle
  vec4 intensity;  // w: cosine of the outer angle
  vec4 reach;      // x: range, or 0; y: 1 if it is the light with shadows
};
layout(std140) uniform Frame {
  vec4 lens;       // half width and half height at w = 1; a, b with w = a z + b
  vec4 depths;     // clip z = x z + y; z: pixels per metre at w = 1; w: pixels by which surfaces that fill seams are behind
  vec4 picture;    // width, height, gain of the exposure, number of the selected leaf or -1
  vec4 section;    // what has dot(xyz, p) > w is cut away
  vec4 upward;     // the world's up; w: number of stripes
  vec4 drawn;      // edges, isocurves per patch, maps, curvature at full colour
  vec4 axisX;      // the world's axes, in the camera's
  vec4 axisY;
  vec4 axisZ;
  vec4 sky;        // radiance of the surroundings, as seen in mirrors; w: number of lights
  vec4 ground;
  vec4 fill;       // share of the surroundings that rough surfaces get
  vec4 shadowX;    // axes of the shadow map in the camera's, and where the eye is along them
  vec4 shadowY;
  vec4 shadowZ;
  vec4 shadow;     // kind (0 none, 1 orthographic, 2 six faces), metres across or 0, depth z' = (z z + w) / (kind == 1 ? 1 : z)
  vec4 walls;      // x: 1 if outer walls are left out where they are seen from outside
  Light lights[${MOST_LIGHTS}];
};
`;

/** Where the block has the distance of surfaces that fill seams: 0 for those that are drawn as they are. */
export const SEAM = 7;

/** Floats before the lights. */
export const FRAME_HEAD = 17 * 4;

/** Where the block says whether outer walls are left out. */
export const WALLS = 16 * 4;

/** Floats of one light. */
export const FRAME_LIGHT = 16;

export const FRAME_FLOATS = FRAME_HEAD + MOST_LIGHTS * FRAME_LIGHT;

/** A camera with the size of its picture, and the places of all objects in it. */
export class Frame {
  /**
   * @param {Camera} camera
   * @param {number} width pixels
   * @param {number} height
   */
  constructor(camera, width, height) {
    const perspective = camera.kind === "perspective";
    const half = perspective ? Math.tan(camera.fieldOfView / 2) : camera.height / 2;
    const short = Math.min(width, height);
    this.camera = camera;
    this.width = width;
    this.height = height;
    this.halfWidth = (half * width) / short;
    this.halfHeight = (half * height) / short;
    /** The clip coordinate w is a z + b. */
    this.a = perspective ? 1 : 0;
    this.b = perspective ? 0 : 1;
    /** Pixels per metre at w = 1. */
    this.scale = short / (2 * half);
    /** Cosines with which distances from the sides of the frustum are measured. */
    this.cosX = perspective ? 1 / Math.hypot(1, this.halfWidth) : 1;
    this.cosY = perspective ? 1 / Math.hypot(1, this.halfHeight) : 1;
    /** Depths of what is drawn; widened by `include`. */
    this.nearest = Infinity;
    this.farthest = -Infinity;
    this.fixed = false;
  }

  /** A point of the world. @param {Vector} p @returns {Vector} */
  toCamera(p) {
    return this.turn(subtract(p, this.camera.position));
  }

  /** A direction of the world. @param {Vector} d @returns {Vector} */
  turn(d) {
    const { right, up, forward } = this.camera;
    return [dot(right, d), dot(up, d), dot(forward, d)];
  }

  /**
   * Writes the maps from objects to the camera, composed in double precision: for the shaders `PLACE` single numbers each, and twelve double ones to count with.
   * @param {SceneObject[]} objects
   * @param {Float32Array} rows
   * @param {Float64Array} places
   */
  place(objects, rows, places) {
    const { right, up, forward, position } = this.camera;
    const axes = [right, up, forward];
    for (let i = 0; i < objects.length; i++) {
      const map = objects[i].toWorld;
      for (let column = 0; column < 4; column++) {
        const at = 3 * column;
        const last = column === 3;
        const x = map[at] - (last ? position[0] : 0);
        const y = map[at + 1] - (last ? position[1] : 0);
        const z = map[at + 2] - (last ? position[2] : 0);
        for (let row = 0; row < 3; row++) {
          const value = axes[row][0] * x + axes[row][1] * y + axes[row][2] * z;
          places[12 * i + at + row] = value;
          rows[PLACE * i + 4 * column + row] = value;
        }
      }
    }
  }

  /**
   * Whether a sphere in the camera's axes may be in sight.
   * @param {number} x
   * @param {number} y
   * @param {number} z
   * @param {number} radius
   */
  sees(x, y, z, radius) {
    if (this.a === 1 && z < -radius) return false;
    const w = this.a * z + this.b;
    return (
      (Math.abs(x) - this.halfWidth * w) * this.cosX <= radius &&
      (Math.abs(y) - this.halfHeight * w) * this.cosY <= radius
    );
  }

  /** Whether a sphere is in sight as a whole. @param {number} x @param {number} y @param {number} z @param {number} radius */
  contains(x, y, z, radius) {
    const w = this.a * z + this.b;
    return (
      (Math.abs(x) - this.halfWidth * w) * this.cosX <= -radius &&
      (Math.abs(y) - this.halfHeight * w) * this.cosY <= -radius
    );
  }

  /** Pixels per metre at a depth. @param {number} z metres, above 0 in perspective */
  pixelsPerMetre(z) {
    return this.scale / (this.a * z + this.b);
  }

  /** Fixes the depths of the clipping planes. @param {number} near @param {number} far */
  fixDepths(near, far) {
    this.nearest = near;
    this.farthest = far;
    this.fixed = true;
  }

  /** @param {number} near depth of what is drawn @param {number} far */
  include(near, far) {
    if (this.fixed) return;
    this.nearest = Math.min(this.nearest, near);
    this.farthest = Math.max(this.farthest, far);
  }

  /**
   * Depths of the clipping planes, and clip z = `slope` z + `offset`. In perspective the near one is never nearer than a share of the far one, so that 24 bits of depth
   * tell surfaces apart, nor farther than a share of the distance of what is looked at.
   * @returns {{ near: number, far: number, slope: number, offset: number }}
   */
  depths() {
    let near = this.nearest < this.farthest ? this.nearest : 0.5;
    let far = this.nearest < this.farthest ? this.farthest : 2;
    const margin = this.fixed ? 0 : 1e-3 * (far - near) + 1e-6 * Math.abs(far);
    near -= margin;
    far += margin;
    if (this.a === 0) return { near, far, slope: 2 / (far - near), offset: -(far + near) / (far - near) };
    if (!this.fixed) near = Math.max(near, Math.min(1e-4 * far, 0.02 * this.camera.distance));
    far = Math.max(far, 2 * near);
    return { near, far, slope: (far + near) / (far - near), offset: (-2 * far * near) / (far - near) };
  }

  /**
   * Writes what depends on the camera alone into the numbers of the shared block.
   * @param {Float32Array} block
   */
  write(block) {
    const { slope, offset } = this.depths();
    const { right, up, forward } = this.camera;
    block.set([this.halfWidth, this.halfHeight, this.a, this.b], 0);
    block.set([slope, offset, this.scale, 0], SEAM - 3);
    block.set([this.width, this.height], 8);
    for (let axis = 0; axis < 3; axis++) block.set([right[axis], up[axis], forward[axis], 0], 24 + 4 * axis);
  }
}

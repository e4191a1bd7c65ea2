/**
 * The camera in use, the centre of its orbit, and transitions from one camera to another.
 *
 * @module
 */

import * as cameras from "./camera.js";
import { between } from "./transition.js";
import { add, dot, length, scale, subtract } from "./linear.js";

/** @typedef {import("./linear.js").Vector} Vector */
/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Size} Size */
/** @typedef {import("./camera.js").Bounds} Bounds */
/** @typedef {import("./camera.js").StandardView} StandardView */

/** Milliseconds of a transition. */
const TRANSITION = 300;

/** Of the scene's size: how near and how far one can go. */
const NEAREST = 1e-7;
const FARTHEST = 1e3;

/** @type {Camera} */
const BEFORE_THE_FIRST_SCENE = {
  kind: "perspective",
  position: [0, -1, 0],
  right: [1, 0, 0],
  up: [0, 0, 1],
  forward: [0, 1, 0],
  fieldOfView: 0.7,
  height: 1,
  distance: 1,
};

export class Viewpoint {
  /** @param {() => void} changed called after every move */
  constructor(changed) {
    this.changed = changed;
    this.camera = BEFORE_THE_FIRST_SCENE;
    /** Centre of the orbit. @type {Vector} */
    this.center = [0, 0, 0];
    /** @type {Vector} */
    this.up = [0, 0, 1];
    /** @type {Bounds} */
    this.bounds = [
      [-1, -1, -1],
      [1, 1, 1],
    ];
    /** As the scene has it, for a picture of its own shape. */
    this.told = this.camera;
    /** Width over height of that picture. */
    this.aspect = 1;
    /** CSS pixels of the canvas. @type {Size} */
    this.size = { width: 1, height: 1 };
    /** @type {number | null} */
    this.frame = null;
  }

  /**
   * Takes over a scene. The camera stays where it is if `keep`.
   * @param {{ camera: Parameters<typeof cameras.withDefaults>[0], aspect?: number, up: Vector, bounds: Bounds }} model
   * @param {boolean} keep
   */
  enter(model, keep) {
    this.up = model.up;
    this.bounds = model.bounds;
    this.told = cameras.withDefaults(model.camera);
    this.aspect = model.aspect || 1;
    if (!keep) {
      this.center = cameras.focus(this.home);
      this.set(this.home);
    }
  }

  /** The scene's camera, with all that it sees. */
  get home() {
    return cameras.framed(this.told, this.aspect, this.size);
  }

  /** Diagonal of the scene, metres. */
  get extent() {
    return length(subtract(this.bounds[1], this.bounds[0])) || 1;
  }

  /** @param {Camera} camera used from now on, without transition */
  set(camera) {
    this.halt();
    this.camera = camera;
    this.changed();
  }

  halt() {
    if (this.frame !== null) {
      cancelAnimationFrame(this.frame);
      this.frame = null;
    }
  }

  get isMoving() {
    return this.frame !== null;
  }

  /** @param {Camera} target */
  go(target) {
    this.halt();
    const from = this.camera;
    const alike = from.kind === target.kind && cameras.handedness(from) === cameras.handedness(target);
    if (!alike || matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.set(target);
      return;
    }
    const start = performance.now();
    const step = () => {
      const share = Math.min(1, (performance.now() - start) / TRANSITION);
      // Begins and ends at rest.
      this.camera = between(from, target, share * share * (3 - 2 * share));
      this.frame = share < 1 ? requestAnimationFrame(step) : null;
      this.changed();
    };
    this.frame = requestAnimationFrame(step);
  }

  /** Metres along the camera's direction to what it turns about; what is behind the camera counts as near. */
  get depth() {
    const depth = dot(subtract(this.center, this.camera.position), this.camera.forward);
    return Math.max(depth, this.extent * NEAREST);
  }

  /** @param {Vector} point what the camera turns about from now on */
  turnAbout(point) {
    this.center = point;
    this.camera = { ...this.camera, distance: this.depth };
  }

  /** Makes sure that what the camera turns about is before it, also after it went past that. */
  orbitAboutFocus() {
    if (dot(subtract(this.center, this.camera.position), this.camera.forward) < this.extent * NEAREST) {
      this.center = cameras.focus(this.camera);
    }
  }

  /**
   * Turns with the hand; a way as long as the canvas' shorter side is half a turn.
   * @param {number} dx
   * @param {number} dy
   */
  orbit(dx, dy) {
    const angle = Math.PI / Math.min(this.size.width, this.size.height);
    this.set(this.ready(cameras.orbited(this.camera, this.up, this.center, dx * angle, dy * angle)));
  }

  /**
   * Moves the scene with the hand.
   * @param {number} dx
   * @param {number} dy
   */
  pan(dx, dy) {
    const moved = cameras.panned(this.camera, this.size, this.depth, dx, dy);
    this.center = add(this.center, subtract(moved.position, this.camera.position));
    this.set(moved);
  }

  /**
   * Zooms to a place in the picture.
   * @param {number} factor below 1: nearer
   * @param {number} x
   * @param {number} y
   * @param {Vector | null} point what is there, if that is known
   */
  zoom(factor, x = this.size.width / 2, y = this.size.height / 2, point = null) {
    if (point) {
      this.turnAbout(point);
    }
    const reach = this.camera.kind === "perspective" ? this.camera.distance : this.camera.height;
    const bounded = Math.min(Math.max(reach * factor, this.extent * NEAREST), this.extent * FARTHEST) / reach;
    const target = point ?? cameras.pointAt(this.camera, this.size, x, y, this.depth);
    this.set(this.ready(cameras.zoomed(this.camera, target, bounded)));
  }

  /** @param {Bounds} bounds */
  fit(bounds = this.bounds) {
    const fitted = this.ready(cameras.fitted(this.camera, this.size, bounds));
    this.center = scale(add(bounds[0], bounds[1]), 0.5);
    this.go(fitted);
  }

  /** @param {StandardView} view */
  look(view) {
    this.go(this.ready(cameras.standard(this.camera, this.up, this.center, view)));
  }

  switchProjection() {
    this.set(this.ready(cameras.otherProjection(this.camera, this.center)));
  }

  reset() {
    this.center = cameras.focus(this.home);
    this.go(this.home);
  }

  /** @param {Camera} camera */
  ready(camera) {
    return cameras.movedBehind(camera, this.bounds);
  }
}

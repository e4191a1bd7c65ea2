/**
 * Navigation by mouse, pen and touch.
 *
 * @module
 */

/** @typedef {import("../viewpoint.js").Viewpoint} Viewpoint */
/** @typedef {import("../linear.js").Vector} Vector */

/**
 * `pick`: the surface point at a canvas position in CSS pixels. `clicked`: a click or tap there. `hover`: the pointer rests there, `null` when it left.
 * @typedef {{ pick(x: number, y: number): Promise<Vector | null>, clicked(x: number, y: number): void,
 *   hover(place: { x: number, y: number } | null): void, released(): void }} PointerListener
 */

/** CSS pixels that a pointer may move between going down and up in a click. */
const CLICK_SLACK = 4;

/** Milliseconds between turns of the wheel that belong together. */
const WHEEL_PAUSE = 250;

/** Milliseconds that a pointer rests before it counts as hovering. */
export const HOVER_PAUSE = 120;

/** CSS pixels of a wheel's turn that zoom by a factor e. */
const WHEEL_SCALE = 600;

/** CSS pixels of a line and of a page, the other units of a wheel's turn. */
const WHEEL_UNITS = [1, 16, 400];

/** @typedef {{ x: number, y: number }} Place */

export class PointerControls {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Viewpoint} viewpoint
   * @param {PointerListener} listener
   */
  constructor(canvas, viewpoint, listener) {
    this.canvas = canvas;
    this.viewpoint = viewpoint;
    this.listener = listener;
    /** Pointers that are down, by their number. @type {Map<number, Place>} */
    this.pointers = new Map();
    this.panning = false;
    /** Position of a press that may still become a click. @type {Place | null} */
    this.click = null;
    /** Counts drags and zooms, so that a late answer about another one's point is left alone. */
    this.gesture = 0;
    /** @type {{ at: number, place: Place, point: Vector | null }} */
    this.wheel = { at: -Infinity, place: { x: 0, y: 0 }, point: null };
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.hoverTimer = undefined;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => this.up(event));
    canvas.addEventListener("pointerleave", () => this.rest(null));
    canvas.addEventListener("wheel", (event) => this.turnWheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get isDragging() {
    return this.pointers.size > 0;
  }

  /** @param {MouseEvent} event @returns {Place} */
  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  /** @param {PointerEvent} event */
  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    const place = this.place(event);
    this.pointers.set(event.pointerId, place);
    this.panning = event.button === 1 || event.button === 2 || event.shiftKey;
    this.click = this.pointers.size === 1 && event.button === 0 ? place : null;
    this.viewpoint.halt();
    this.rest(null);
    if (this.pointers.size === 1) {
      this.orbitAbout(place);
    }
    // The middle button would begin to scroll.
    if (event.button === 1) event.preventDefault();
  }

  /** @param {Place} place */
  async orbitAbout(place) {
    this.gesture += 1;
    const gesture = this.gesture;
    this.viewpoint.orbitAboutFocus();
    const point = await this.listener.pick(place.x, place.y);
    if (point && gesture === this.gesture) this.viewpoint.turnAbout(point);
  }

  /** @param {PointerEvent} event */
  move(event) {
    const place = this.place(event);
    const before = this.pointers.get(event.pointerId);
    if (!before) {
      this.rest(place);
      return;
    }
    if (this.click && Math.hypot(place.x - this.click.x, place.y - this.click.y) <= CLICK_SLACK) return;
    this.click = null;
    this.pointers.set(event.pointerId, place);
    const [dx, dy] = [place.x - before.x, place.y - before.y];
    if (this.pointers.size === 2) this.pinch(event.pointerId, before, place);
    else if (this.pointers.size === 1 && this.panning) this.viewpoint.pan(dx, dy);
    else if (this.pointers.size === 1) this.viewpoint.orbit(dx, dy);
  }

  /**
   * Two fingers: their middle moves the scene, their distance zooms it.
   * @param {number} moved the finger that moved
   * @param {Place} before
   * @param {Place} after
   */
  pinch(moved, before, after) {
    const other = [...this.pointers].find(([id]) => id !== moved)?.[1];
    if (!other) return;
    this.viewpoint.pan((after.x - before.x) / 2, (after.y - before.y) / 2);
    const factor = distance(before, other) / Math.max(distance(after, other), 1);
    if (factor > 0) this.viewpoint.zoom(factor, (after.x + other.x) / 2, (after.y + other.y) / 2);
  }

  /** @param {PointerEvent} event */
  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    if (this.click && event.type === "pointerup") this.listener.clicked(this.click.x, this.click.y);
    this.click = null;
    this.panning = false;
    if (this.pointers.size > 0) return;
    // A finger that is lifted is nowhere.
    if (event.type === "pointerup" && event.pointerType !== "touch") this.rest(this.place(event));
    this.listener.released();
  }

  /** @param {WheelEvent} event */
  turnWheel(event) {
    event.preventDefault();
    const place = this.place(event);
    const now = performance.now();
    const same = now - this.wheel.at < WHEEL_PAUSE && distance(place, this.wheel.place) <= CLICK_SLACK;
    this.wheel.at = now;
    if (!same) this.beginZoom(place);
    // A pinch on a touchpad comes as a wheel with Ctrl and small steps.
    const step = event.deltaY * (WHEEL_UNITS[event.deltaMode] ?? 1) * (event.ctrlKey ? 5 : 1);
    const factor = Math.exp(Math.max(-1, Math.min(1, step / WHEEL_SCALE)));
    this.viewpoint.zoom(factor, place.x, place.y, this.wheel.point);
    this.rest(place);
  }

  /** @param {Place} place */
  async beginZoom(place) {
    this.gesture += 1;
    const gesture = this.gesture;
    this.wheel.place = place;
    this.wheel.point = null;
    this.viewpoint.orbitAboutFocus();
    const point = await this.listener.pick(place.x, place.y);
    if (gesture === this.gesture) this.wheel.point = point;
  }

  /** @param {Place | null} place where the pointer is now, with nothing pressed */
  rest(place) {
    clearTimeout(this.hoverTimer);
    if (place) this.hoverTimer = setTimeout(() => this.listener.hover(place), HOVER_PAUSE);
    else this.listener.hover(null);
  }
}

/**
 * @param {Place} a
 * @param {Place} b
 */
function distance(a, b) {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

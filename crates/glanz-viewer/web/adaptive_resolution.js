/**
 * Adaptive resolution: on slow graphics fewer pixels are drawn while the camera moves. At rest every pixel is drawn.
 *
 * @module
 */

/** Milliseconds from drawing until the browser is two frames on: above the first too slow, below the second with room for more. */
const TOO_LONG = 120;
const SHORT = 45;

/** The coarsest picture, as a share of the canvas' sides. */
const COARSEST = 1 / 8;

/** Milliseconds without a move after which everything counts as at rest. */
const REST = 150;

export class AdaptiveResolution {
  constructor() {
    /** Share of the canvas' sides that is drawn while moving. */
    this.share = 1;
    this.movedAt = -Infinity;
  }

  /** @param {number} now milliseconds */
  moved(now) {
    this.movedAt = now;
  }

  /**
   * Milliseconds until all is at rest, 0 if it is.
   * @param {number} now
   */
  untilRest(now) {
    return Math.max(0, this.movedAt + REST - now);
  }

  /**
   * The share of the canvas' sides to draw now.
   * @param {number} now
   */
  shareAt(now) {
    return this.untilRest(now) > 0 ? this.share : 1;
  }

  /**
   * Records the time of a frame.
   * @param {number} share that of the picture
   * @param {number} milliseconds
   */
  record(share, milliseconds) {
    if (milliseconds > TOO_LONG && share <= this.share) this.share = Math.max(COARSEST, share / 2);
    else if (milliseconds < SHORT && share >= this.share) this.share = Math.min(1, share * 2);
  }
}

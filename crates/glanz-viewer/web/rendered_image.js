/**
 * The rendered image: requested when the camera rests, assembled from tiles, dropped when it moves.
 *
 * @module
 */

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Size} Size */
/** @typedef {import("./session.js").Session} Session */
/** @typedef {import("./session.js").Tile} Tile */
/** @typedef {import("./session.js").Progress} Progress */

/** @typedef {[x: number, y: number, width: number, height: number]} Rectangle */
/** @typedef {"path" | "guided"} Integrator */
/** @typedef {{ camera: Camera, size: Size, hidden: ReturnType<typeof import("./scene_parts.js").ranges>, integrator: Integrator, denoise: boolean }} RenderRequest */

/**
 * `queued`: behind the images of other pages. `denoised`: samples of the image that is shown, if its noise is removed.
 * @typedef {{ samples: number, noise: number | null, seconds: number, done: boolean, covered: boolean, queued: boolean,
 *   denoised: number | null, error: string | null }} RenderStatus
 */

/** 1 as a half float. */
const HALF_ONE = 0x3c00;

/** Milliseconds that the camera rests before rendering begins. */
const REST = 250;

/** Milliseconds after which a hidden page gives the memory of its image on the server to others. */
const ABANDON = 60000;

/** Longest side of a picture that the server renders. */
const LARGEST_SIDE = 4096;

/**
 * An image of half floats, RGBA, rows from the top. A is 0 where no pixel has arrived. The consumer reads the rectangles of `changed` and empties the list.
 */
export class TileImage {
  /** @param {Size} size */
  constructor(size) {
    this.width = size.width;
    this.height = size.height;
    this.data = new Uint16Array(4 * size.width * size.height);
    /** @type {Rectangle[]} */
    this.changed = [];
    this.missing = size.width * size.height;
  }

  /** True if all pixels have arrived. */
  get covered() {
    return this.missing === 0;
  }

  /** True if no pixel has arrived. */
  get empty() {
    return this.missing === this.width * this.height;
  }

  /**
   * Takes over the pixels of a tile; what lies outside of the picture is left out.
   * @param {Tile} tile
   */
  put(tile) {
    const width = Math.min(tile.width, this.width - tile.x);
    const height = Math.min(tile.height, this.height - tile.y);
    if (width <= 0 || height <= 0) {
      return;
    }
    for (let row = 0; row < height; row++) {
      let from = 3 * row * tile.width;
      let to = 4 * ((tile.y + row) * this.width + tile.x);
      for (let column = 0; column < width; column++, from += 3, to += 4) {
        this.data[to] = tile.pixels[from];
        this.data[to + 1] = tile.pixels[from + 1];
        this.data[to + 2] = tile.pixels[from + 2];
        this.missing -= this.data[to + 3] === 0 ? 1 : 0;
        this.data[to + 3] = HALF_ONE;
      }
    }
    this.changed.push([tile.x, tile.y, width, height]);
  }
}

/**
 * The size to render at: that of the canvas, or as large as the server goes at the same ratio.
 * @param {Size} canvas
 * @returns {Size}
 */
export function renderSize(canvas) {
  const shrink = Math.min(1, LARGEST_SIDE / Math.max(canvas.width, canvas.height));
  return {
    width: Math.max(1, Math.round(canvas.width * shrink)),
    height: Math.max(1, Math.round(canvas.height * shrink)),
  };
}

/** The rendered image of this page, and its request. */
export class RenderedImage {
  /**
   * @param {Session} session
   * @param {() => void} changed called when there is something new to show or to say
   */
  constructor(session, changed) {
    this.session = session;
    this.notify = changed;
    /** @type {TileImage | null} */
    this.picture = null;
    /** @type {RenderStatus | null} */
    this.status = null;
    /** The request that is being rendered. @type {number | null} */
    this.id = null;
    /** Milliseconds from the last stop until the server had stopped. @type {number | null} */
    this.latency = null;
    /** @type {{ id: number, at: number } | null} */
    this.stopping = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    /** Whether nobody sees the page. */
    this.isHidden = false;
    /** Whether the image was given up, or not begun, while the page was hidden. */
    this.isAbandoned = false;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.abandonTimer = undefined;
  }

  /**
   * Pauses rendering while the page is hidden. Returns true if the image has to be requested again, because the page was hidden for long or the image failed.
   * @param {boolean} isHidden
   */
  hide(isHidden) {
    this.isHidden = isHidden;
    clearTimeout(this.abandonTimer);
    if (this.id !== null) this.session.send({ type: isHidden ? "pause" : "resume", id: this.id });
    const isAbandoned = this.isAbandoned;
    this.isAbandoned = false;
    if (isHidden) {
      this.abandonTimer = setTimeout(() => {
        // A finished image takes no memory of the server.
        if (this.id === null || this.status?.done) return;
        this.isAbandoned = true;
        this.stop();
      }, ABANDON);
    }
    // The server ends views that are paused for too long.
    return isAbandoned || (!isHidden && (this.status?.error ?? null) !== null);
  }

  /**
   * Drops the image and cancels its rendering. After a rest, `ask` returns the next request.
   * @param {(() => RenderRequest | null) | null} ask
   */
  restart(ask) {
    this.stop();
    clearTimeout(this.timer);
    if (ask) {
      this.timer = setTimeout(() => this.begin(ask()), REST);
    }
  }

  /** @param {RenderRequest | null} asked */
  begin(asked) {
    if (!asked || !this.session.isOnline) {
      return;
    }
    if (this.isHidden) {
      // The scene may have changed while nobody looks.
      this.isAbandoned = true;
      return;
    }
    const { camera, hidden, integrator, denoise } = asked;
    const size = renderSize(asked.size);
    this.id = this.session.nextId();
    this.picture = new TileImage(size);
    this.status = {
      ...{ samples: 0, noise: null, seconds: 0, done: false, covered: false, queued: false },
      ...{ denoised: null, error: null },
    };
    const sides = [size.width, size.height];
    this.session.send({ type: "view", id: this.id, camera, size: sides, hidden, integrator, denoise });
    this.notify();
  }

  stop() {
    if (this.id !== null) {
      this.stopping = { id: this.id, at: performance.now() };
      this.session.send({ type: "stop", id: this.id });
      this.id = null;
    }
    this.picture = null;
    this.status = null;
  }

  /** The connection was lost, and the request with it. */
  lost() {
    this.id = null;
    this.stopping = null;
  }

  /** @param {number} id */
  stopped(id) {
    if (this.stopping?.id === id) {
      this.latency = performance.now() - this.stopping.at;
      this.stopping = null;
    }
  }

  /** @param {number} id */
  queued(id) {
    if (id === this.id && this.status) {
      this.status.queued = true;
      this.notify();
    }
  }

  /** @param {Tile} tile */
  tile(tile) {
    if (tile.id === this.id && this.picture && this.status) {
      this.picture.put(tile);
      this.status.covered = this.picture.covered;
      this.status.denoised = tile.denoised ? tile.samples : null;
      this.notify();
    }
  }

  /** @param {Progress} progress */
  progress(progress) {
    if (progress.id === this.id && this.status) {
      const { samples, noise, seconds, done } = progress;
      Object.assign(this.status, { samples, noise, seconds, done, queued: false });
      this.notify();
    }
  }

  /**
   * Records an error of the current request. Returns false if it belongs to another one.
   * @param {number | null} id
   * @param {string} message
   */
  failed(id, message) {
    if (id === null || id !== this.id || !this.status) {
      return false;
    }
    this.status.error = message;
    this.notify();
    return true;
  }
}

/**
 * The WebSocket to the server: requests, replies, reconnection.
 *
 * @module
 */

/** @typedef {import("./linear.js").Vector} Vector */

/**
 * A hit on the exact surface; lengths in metres, curvatures in 1/m, in world space.
 * @typedef {{ minimum: number, maximum: number, gaussian: number, mean: number, radius: number | null }} Curvature
 * @typedef {{ radius: number | null, majorRadius: number | null, minorRadius: number | null, halfAngle: number | null }} Dimensions
 * @typedef {{ faces: number, area: number | null, volume: number | null }} Measures
 * Illuminances, lx. @typedef {{ receiver: string, cell: [number, number], lux: number, relativeError: number | null, minimum: number, mean: number,
 *   maximum: number }} LuxReading
 * @typedef {{ leaf: number, object: number, kind: string, name: string, material: string, degree: [number, number] | null,
 *   area: number | null, dimensions: Dimensions | null, entity: string | null, uv: [number, number], face: number, point: Vector, normal: Vector, distance: number,
 *   lux: LuxReading | null, curvature: Curvature | null }} Hit
 */

/**
 * `label`: what tells it from the other one of two designs. `compared`: whether the page shows it beside the other one of two designs. `denoiser`: missing if the server offers none; `error`: why it cannot be used.
 * `lost`: whether the process of a scene that the page has opened has ended.
 * @typedef {{ type: "scene", model: string | null, name: string, label: string, error: string | null, lost?: boolean, compared?: boolean, session?: string, integrator?: "path" | "guided",
 *   denoiser?: { error: string | null } }} SceneMessage
 */
/** @typedef {{ type: "progress", id: number, samples: number, noise: number | null, seconds: number, done: boolean }} Progress */

/**
 * Part of the rendered picture: half floats, three a pixel, rows from the top.
 * @typedef {{ id: number, x: number, y: number, width: number, height: number, samples: number, denoised: boolean, pixels: Uint16Array }} Tile
 */

/**
 * Callbacks for messages that the server sends without a request. `offline`: milliseconds until the next attempt.
 * @typedef {{ online(): void, offline(pause: number): void, scene(message: SceneMessage): void, progress(message: Progress): void, waiting(id: number): void,
 *   tile(tile: Tile): void, stopped(id: number): void, failed(id: number | null, message: string): void }} Listener
 */

/** @typedef {{ resolve(answer: any): void, reject(error: Error): void }} PendingRequest */

const TILE = 1;
const FILE = 2;

/** Bytes before the pixels of a tile and before a file. */
const TILE_HEADER = 20;
const FILE_HEADER = 8;

/** Milliseconds before the first attempt to connect again, and the longest pause. */
const FIRST_PAUSE = 500;
const LONGEST_PAUSE = 15000;

/**
 * A tile from its bytes; `null` if they are not those of one.
 * @param {ArrayBuffer} bytes
 * @returns {Tile | null}
 */
export function tileFromBytes(bytes) {
  if (bytes.byteLength < TILE_HEADER) {
    return null;
  }
  const header = new DataView(bytes);
  const [width, height] = [header.getUint16(12, true), header.getUint16(14, true)];
  if (header.getUint8(0) !== TILE || bytes.byteLength !== TILE_HEADER + width * height * 6) {
    return null;
  }
  return {
    id: header.getUint32(4, true),
    x: header.getUint16(8, true),
    y: header.getUint16(10, true),
    width,
    height,
    samples: header.getUint32(16, true),
    denoised: header.getUint8(1) === 1,
    pixels: new Uint16Array(bytes, TILE_HEADER),
  };
}

/** Connection of the page; it reconnects for the lifetime of the page. */
export class Session {
  /**
   * @param {URL} url
   * @param {Listener} listener
   */
  constructor(url, listener) {
    this.url = url;
    this.listener = listener;
    /** @type {WebSocket | null} */
    this.socket = null;
    this.isClosed = false;
    this.lastId = 0;
    this.pause = FIRST_PAUSE;
    /** @type {Map<number, PendingRequest>} */
    this.waiting = new Map();
    this.connect();
  }

  get isOnline() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  connect() {
    // It may have been closed during the pause.
    if (this.isClosed) return;
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.pause = FIRST_PAUSE;
      this.listener.online();
    };
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = () => {
      this.abandon("the connection to the server was lost");
      if (this.isClosed) return;
      this.listener.offline(this.pause);
      setTimeout(() => this.connect(), this.pause);
      this.pause = Math.min(2 * this.pause, LONGEST_PAUSE);
    };
  }

  /** Ends the connection for good. */
  close() {
    this.isClosed = true;
    this.socket?.close();
  }

  /** A number for a request that no other has. */
  nextId() {
    this.lastId += 1;
    return this.lastId;
  }

  /**
   * Sends a message; while there is no connection it is lost.
   * @param {Record<string, unknown>} message
   */
  send(message) {
    if (this.isOnline) {
      this.socket?.send(JSON.stringify(message));
    }
  }

  /**
   * Sends a request and returns the reply: a message, or the bytes of a file.
   * @param {Record<string, unknown>} message
   * @returns {Promise<any>} rejected with the server's error, or when the connection is lost or the scene changes
   */
  request(message) {
    if (!this.isOnline) {
      return Promise.reject(new Error("there is no connection to the server"));
    }
    const id = this.nextId();
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.send({ ...message, id });
    });
  }

  /** @param {string | ArrayBuffer} data */
  receive(data) {
    if (typeof data === "string") {
      this.receiveText(JSON.parse(data));
      return;
    }
    const tile = tileFromBytes(data);
    if (tile) {
      this.listener.tile(tile);
    } else if (data.byteLength >= FILE_HEADER && new Uint8Array(data)[0] === FILE) {
      this.settle(new DataView(data).getUint32(4, true))?.resolve(data.slice(FILE_HEADER));
    }
  }

  /** @param {any} message */
  receiveText(message) {
    switch (message.type) {
      case "scene":
        // What was asked about the scene before is not answered any more.
        if (message.model !== null || message.lost) this.abandon("the scene has changed");
        return this.listener.scene(message);
      case "progress":
        return this.listener.progress(message);
      case "waiting":
        return this.listener.waiting(message.id);
      case "stopped":
        return this.listener.stopped(message.id);
      case "failed": {
        const asked = this.settle(message.id);
        return asked ? asked.reject(new Error(message.message)) : this.listener.failed(message.id, message.message);
      }
      default:
        return this.settle(message.id)?.resolve(message);
    }
  }

  /**
   * Rejects all pending requests.
   * @param {string} reason
   */
  abandon(reason) {
    const pending = [...this.waiting.values()];
    this.waiting.clear();
    pending.forEach(({ reject }) => reject(new Error(reason)));
  }

  /**
   * Removes and returns the pending request of this id.
   * @param {number} id
   */
  settle(id) {
    const waiting = this.waiting.get(id);
    this.waiting.delete(id);
    return waiting;
  }
}

/**
 * Compiled programs, by name; made when first asked for.
 *
 * @module
 */

/** Texture units, the same in all programs. */
export const UNITS = {
  points: 0,
  patches: 1,
  objectFacts: 2,
  objectPlaces: 3,
  materials: 4,
  regionCells: 5,
  regionEntries: 6,
  regionSteps: 7,
  regionParts: 8,
  regionPoints: 9,
  shadowMap: 10,
  mapValues: 11,
  picture: 12,
};

/** Number of the block of uniforms that all programs share. */
export const FRAME_BINDING = 0;

/** A linked program with the places of its uniforms. */
export class Program {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {WebGLProgram} handle
   */
  constructor(gl, handle) {
    this.gl = gl;
    this.handle = handle;
    /** @type {Map<string, WebGLUniformLocation | null>} */
    this.places = new Map();
    const block = gl.getUniformBlockIndex(handle, "Frame");
    if (block !== gl.INVALID_INDEX) gl.uniformBlockBinding(handle, block, FRAME_BINDING);
    gl.useProgram(handle);
    for (const [name, unit] of Object.entries(UNITS)) gl.uniform1i(this.place(name), unit);
  }

  /** @param {string} name */
  place(name) {
    let place = this.places.get(name);
    if (place === undefined) {
      place = this.gl.getUniformLocation(this.handle, name);
      this.places.set(name, place);
    }
    return place;
  }

  use() {
    this.gl.useProgram(this.handle);
  }
}

/**
 * @typedef {{ handle: WebGLProgram, shaders: WebGLShader[], program: Program | null }} Entry
 */

/** All programs of a context. */
export class Programs {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.parallel = gl.getExtension("KHR_parallel_shader_compile");
    /** @type {Map<string, Entry>} */
    this.entries = new Map();
    /** Programs that were asked for since the last `clearPending` and are still being compiled. */
    this.pending = 0;
  }

  clearPending() {
    this.pending = 0;
  }

  /**
   * The program of a name, or null while the driver is compiling it.
   * @param {string} name
   * @param {() => { vertex: string, fragment: string }} text
   * @param {boolean} wait rather than null
   * @returns {Program | null}
   * @throws {Error} with the driver's words if it does not compile
   */
  get(name, text, wait) {
    let entry = this.entries.get(name);
    if (!entry) {
      entry = this.begin(text());
      this.entries.set(name, entry);
    }
    if (entry.program) return entry.program;
    const done =
      wait || !this.parallel || this.gl.getProgramParameter(entry.handle, this.parallel.COMPLETION_STATUS_KHR);
    if (!done) {
      this.pending += 1;
      return null;
    }
    entry.program = this.finish(name, entry);
    return entry.program;
  }

  /** @param {{ vertex: string, fragment: string }} text @returns {Entry} */
  begin({ vertex, fragment }) {
    const { gl } = this;
    const handle = gl.createProgram();
    const shaders = [
      /** @type {const} */ ([gl.VERTEX_SHADER, vertex]),
      /** @type {const} */ ([gl.FRAGMENT_SHADER, fragment]),
    ].map(([type, source]) => {
      const shader = gl.createShader(type);
      // Null only when the context is lost: everything is made anew then.
      if (!shader) throw new Error("The graphics context is lost.");
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(handle, shader);
      return shader;
    });
    gl.linkProgram(handle);
    return { handle, shaders, program: null };
  }

  /** @param {string} name @param {Entry} entry */
  finish(name, entry) {
    const { gl } = this;
    if (!gl.getProgramParameter(entry.handle, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = entry.shaders.map((shader) => gl.getShaderInfoLog(shader) ?? "");
      throw new Error(`Program "${name}" does not compile: ${gl.getProgramInfoLog(entry.handle)} ${logs.join(" ")}`);
    }
    for (const shader of entry.shaders) gl.deleteShader(shader);
    return new Program(gl, entry.handle);
  }
}

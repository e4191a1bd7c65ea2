/**
 * Tables of numbers as textures, `WIDTH` texels a row.
 *
 * @module
 */

export const WIDTH = 2048;

/** The unit on which textures are written; no program reads it. */
export const SCRATCH_UNIT = 15;

/**
 * A table of numbers on the graphics card.
 */
export class DataTexture {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {"RGBA32F" | "RG32F" | "RGBA32UI"} format
   */
  constructor(gl, format) {
    this.gl = gl;
    this.format = format;
    this.channels = format === "RG32F" ? 2 : 4;
    this.texture = gl.createTexture();
    this.rows = 0;
    gl.activeTexture(gl.TEXTURE0 + SCRATCH_UNIT);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    }
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
  }

  /**
   * Replaces the contents.
   * @param {Float32Array | Uint32Array} data whole texels
   * @throws {Error} if there are more than the graphics card allows
   */
  write(data) {
    const { gl } = this;
    const texels = data.length / this.channels;
    const rows = Math.max(1, Math.ceil(texels / WIDTH));
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (rows > most) {
      throw new Error(`The scene needs a table of ${rows} rows; this graphics card allows ${most}.`);
    }
    gl.activeTexture(gl.TEXTURE0 + SCRATCH_UNIT);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    const [format, type] =
      this.format === "RGBA32UI"
        ? [gl.RGBA_INTEGER, gl.UNSIGNED_INT]
        : [this.channels === 2 ? gl.RG : gl.RGBA, gl.FLOAT];
    if (rows !== this.rows) {
      gl.texImage2D(gl.TEXTURE_2D, 0, gl[this.format], WIDTH, rows, 0, format, type, null);
      this.rows = rows;
    }
    const whole = Math.floor(texels / WIDTH);
    if (whole > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDTH, whole, format, type, data);
    const rest = texels - whole * WIDTH;
    if (rest > 0) {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, whole, rest, 1, format, type, data, whole * WIDTH * this.channels);
    }
  }

  /** @param {number} unit */
  bind(unit) {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
  }

  delete() {
    this.gl.deleteTexture(this.texture);
  }
}

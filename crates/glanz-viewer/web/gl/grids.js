/**
 * Grids of 2^a x 2^b cells, and where the programs of patches find them.
 *
 * @module
 */

import { INSTANCE_WORDS } from "./patch_shader.js";

/** @typedef {{ array: WebGLVertexArrayObject, buffers: WebGLBuffer[], indices: number }} Grid */

export class Grids {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    /** Instances, `INSTANCE_WORDS` each. */
    this.instances = gl.createBuffer();
    /** @type {Map<number, Grid>} */
    this.grids = new Map();
  }

  /** @param {Uint32Array} words @param {number} count words that count */
  write(words, count) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.instances);
    gl.bufferData(gl.ARRAY_BUFFER, words.subarray(0, count), gl.DYNAMIC_DRAW);
  }

  /**
   * Draws grids with the program in use.
   * @param {number} levelU
   * @param {number} levelV
   * @param {number} first number of the first instance
   * @param {number} count
   */
  draw(levelU, levelV, first, count) {
    const { gl } = this;
    const key = levelU * 16 + levelV;
    let grid = this.grids.get(key);
    if (!grid) {
      grid = this.make(levelU, levelV);
      this.grids.set(key, grid);
    }
    gl.bindVertexArray(grid.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.instances);
    gl.vertexAttribIPointer(1, INSTANCE_WORDS, gl.UNSIGNED_INT, 0, first * INSTANCE_WORDS * 4);
    gl.drawElementsInstanced(gl.TRIANGLES, grid.indices, gl.UNSIGNED_SHORT, 0, count);
    gl.bindVertexArray(null);
  }

  /** @param {number} levelU @param {number} levelV @returns {Grid} */
  make(levelU, levelV) {
    const { gl } = this;
    const { corners, triangles } = gridOf(levelU, levelV);
    const array = gl.createVertexArray();
    const buffers = [gl.createBuffer(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.UNSIGNED_BYTE, false, 4, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers[1]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribDivisor(1, 1);
    gl.bindVertexArray(null);
    return { array, buffers, indices: triangles.length };
  }

  delete() {
    const { gl } = this;
    gl.deleteBuffer(this.instances);
    for (const { array, buffers } of this.grids.values()) {
      gl.deleteVertexArray(array);
      for (const buffer of buffers) gl.deleteBuffer(buffer);
    }
  }
}

/**
 * Corners of the cells (x, y and two bytes that are not used) and two triangles a cell.
 * @param {number} levelU at most 7, so that a byte holds 2^level and 16 bits hold the number of a corner
 * @param {number} levelV
 */
export function gridOf(levelU, levelV) {
  const [columns, rows] = [2 ** levelU, 2 ** levelV];
  const corners = new Uint8Array((columns + 1) * (rows + 1) * 4);
  for (let y = 0; y <= rows; y++) {
    for (let x = 0; x <= columns; x++) corners.set([x, y], (y * (columns + 1) + x) * 4);
  }
  const triangles = new Uint16Array(columns * rows * 6);
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      const a = y * (columns + 1) + x;
      const c = a + columns + 1;
      triangles.set([a, a + 1, c, a + 1, c + 1, c], (y * columns + x) * 6);
    }
  }
  return { corners, triangles };
}

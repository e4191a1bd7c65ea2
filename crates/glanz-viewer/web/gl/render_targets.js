/**
 * Render targets: multisampled colour, shadow map, float values.
 *
 * @module
 */

import { SCRATCH_UNIT } from "./data_texture.js";

/** Samples of a pixel, where the graphics card has as many. */
const SAMPLES = 4;

/** A picture with several samples a pixel, which is then brought to the canvas. */
export class MultisampledTarget {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.framebuffer = gl.createFramebuffer();
    this.colour = gl.createRenderbuffer();
    this.depth = gl.createRenderbuffer();
    this.width = 0;
    this.height = 0;
  }

  /** Makes it the target. @param {number} width @param {number} height */
  begin(width, height) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    if (width !== this.width || height !== this.height) {
      const samples = Math.min(SAMPLES, gl.getParameter(gl.MAX_SAMPLES));
      attach(gl, this.colour, gl.COLOR_ATTACHMENT0, gl.RGBA8, width, height, samples);
      attach(gl, this.depth, gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24, width, height, samples);
      this.width = width;
      this.height = height;
    }
    gl.viewport(0, 0, width, height);
  }

  /** Brings the picture to the canvas, opaque: coverage was written to alpha. */
  resolve() {
    const { gl, width, height } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.clearColor(0, 0, 0, 1);
    // Chromium clears a canvas that was shown before what it counts as drawing next, and a copy does not count: the clear of alpha below would be
    // that, and take the picture with it, where nothing was drawn.
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.framebuffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.colorMask(false, false, false, true);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.colorMask(true, true, true, true);
  }

  delete() {
    this.gl.deleteFramebuffer(this.framebuffer);
    this.gl.deleteRenderbuffer(this.colour);
    this.gl.deleteRenderbuffer(this.depth);
  }
}

/** A picture of four floats a pixel, to be read. */
export class FloatTarget {
  /** @param {WebGL2RenderingContext} gl @param {number} width @param {number} height */
  constructor(gl, width, height) {
    this.gl = gl;
    this.width = width;
    this.height = height;
    this.framebuffer = gl.createFramebuffer();
    this.colour = gl.createRenderbuffer();
    this.depth = gl.createRenderbuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    attach(gl, this.colour, gl.COLOR_ATTACHMENT0, gl.RGBA32F, width, height, 0);
    attach(gl, this.depth, gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24, width, height, 0);
    gl.viewport(0, 0, width, height);
  }

  /** The numbers, rows from the top. */
  read() {
    const { gl, width, height } = this;
    const fromBottom = new Float32Array(width * height * 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, fromBottom);
    const data = new Float32Array(fromBottom.length);
    const row = width * 4;
    for (let y = 0; y < height; y++) data.set(fromBottom.subarray(y * row, (y + 1) * row), (height - 1 - y) * row);
    return data;
  }

  delete() {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(this.framebuffer);
    gl.deleteRenderbuffer(this.colour);
    gl.deleteRenderbuffer(this.depth);
  }
}

/** A depth map that is compared with when read. */
export class DepthTarget {
  /** @param {WebGL2RenderingContext} gl @param {number} width @param {number} height */
  constructor(gl, width, height) {
    this.gl = gl;
    this.width = width;
    this.height = height;
    this.texture = gl.createTexture();
    this.framebuffer = gl.createFramebuffer();
    gl.activeTexture(gl.TEXTURE0 + SCRATCH_UNIT);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, width, height);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_FUNC, gl.LEQUAL);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** @param {number} unit */
  bind(unit) {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
  }

  delete() {
    this.gl.deleteTexture(this.texture);
    this.gl.deleteFramebuffer(this.framebuffer);
  }
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {WebGLRenderbuffer} buffer
 * @param {number} attachment
 * @param {number} format
 * @param {number} width
 * @param {number} height
 * @param {number} samples
 */
function attach(gl, buffer, attachment, format, width, height, samples) {
  gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
  gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
}

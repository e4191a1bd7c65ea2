/**
 * The rendered picture, streamed in, as a texture under exposure and tone curve.
 *
 * @module
 */

import { PRECISION_TEXT } from "./shading_modes.js";
import { UNITS } from "./programs.js";
import { TONE_TEXT } from "./shading.js";
import { SCRATCH_UNIT } from "./data_texture.js";

/** @typedef {import("./programs.js").Programs} Programs */

/**
 * The image so far: four half floats per pixel, rows from the top; the fourth is 0 where no sample has arrived. `covered`: all have. `changed`: rectangles that differ
 * since the last draw.
 * @typedef {{ width: number, height: number, data: Uint16Array, covered: boolean, changed: [x: number, y: number, width: number, height: number][] }} RenderedImage
 */

const VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
`;

const FRAGMENT = `${PRECISION_TEXT}${TONE_TEXT}
uniform sampler2D picture;
uniform vec3 shown;    // width and height of the canvas, gain
layout(location = 0) out vec4 colour;
void main() {
  vec2 at = vec2(gl_FragCoord.x, shown.y - gl_FragCoord.y) / shown.xy;
  ivec2 size = textureSize(picture, 0);
  ivec2 texel = clamp(ivec2(at * vec2(size)), ivec2(0), size - 1);
  vec4 light = texelFetch(picture, texel, 0);
  if (light.w == 0.0) discard;
  colour = vec4(display(light.xyz, shown.z), 1.0);
}
`;

export class RenderedImageTexture {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.texture = gl.createTexture();
    this.array = gl.createVertexArray();
    this.width = 0;
    this.height = 0;
    /** @type {Uint16Array | null} */
    this.data = null;
  }

  /** Uploads the changed rectangles and clears their list. @param {RenderedImage} image */
  update(image) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + SCRATCH_UNIT);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    if (image.data !== this.data || image.width !== this.width || image.height !== this.height) {
      const { width, height, data } = image;
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, width, height, 0, gl.RGBA, gl.HALF_FLOAT, data);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      }
      Object.assign(this, { width, height, data });
    } else {
      gl.pixelStorei(gl.UNPACK_ROW_LENGTH, image.width);
      for (const [x, y, width, height] of image.changed) {
        gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, x);
        gl.pixelStorei(gl.UNPACK_SKIP_ROWS, y);
        gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, width, height, gl.RGBA, gl.HALF_FLOAT, image.data);
      }
      for (const name of [gl.UNPACK_ROW_LENGTH, gl.UNPACK_SKIP_PIXELS, gl.UNPACK_SKIP_ROWS]) gl.pixelStorei(name, 0);
    }
    image.changed.length = 0;
  }

  /** Draws the received pixels over the target that is bound. @param {Programs} programs @param {number} width @param {number} height @param {number} gain */
  draw(programs, width, height, gain) {
    const { gl } = this;
    const program = programs.get("rendered image", () => ({ vertex: VERTEX, fragment: FRAGMENT }), true);
    if (!program) return;
    program.use();
    gl.uniform3f(program.place("shown"), width, height, gain);
    gl.activeTexture(gl.TEXTURE0 + UNITS.picture);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.array);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
  }

  delete() {
    this.gl.deleteTexture(this.texture);
    this.gl.deleteVertexArray(this.array);
  }
}

/**
 * Control nets: the control points of patches and the lines between them, a few pixels wide, in front of what is near them.
 *
 * @module
 */

import { patchHeader } from "../model.js";
import { FRAME_TEXT } from "./frame.js";
import { OBJECT_TEXT, PRECISION_TEXT } from "./shading_modes.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./patches.js").FrameStatistics} FrameStatistics */
/** @typedef {import("./programs.js").Programs} Programs */

/**
 * One instance is a patch, whose lines along u, lines along v and points are drawn as rectangles of six vertices.
 */
const VERTEX = `${PRECISION_TEXT}${FRAME_TEXT}${OBJECT_TEXT}
uniform sampler2D points;
uniform uvec2 degree;
layout(location = 0) in uvec2 instance;    // first point, object
flat out float isPoint;
out vec3 eyePoint;
vec3 pointAt(uvec2 at) {
  uint k = instance.x + at.x * (degree.y + 1u) + at.y;
  vec4 h = texelFetch(points, ivec2(k & 2047u, k >> 11u), 0);
  return placeOf(instance.y) * vec4(h.xyz / h.w, 1.0);
}
vec4 clip(vec3 p) { return vec4(p.xy / lens.xy, depths.x * p.z + depths.y, lens.z * p.z + lens.w); }
void main() {
  uint figure = uint(gl_VertexID) / 6u, corner = uint(gl_VertexID) % 6u;
  uvec2 count = degree + 1u;
  uint alongU = degree.x * count.y, alongV = count.x * degree.y;
  uvec2 from, to;
  if (figure < alongU) {
    from = uvec2(figure / count.y, figure % count.y);
    to = from + uvec2(1u, 0u);
  } else if (figure < alongU + alongV) {
    figure -= alongU;
    from = uvec2(figure / degree.y, figure % degree.y);
    to = from + uvec2(0u, 1u);
  } else {
    figure -= alongU + alongV;
    from = to = uvec2(figure / count.y, figure % count.y);
  }
  isPoint = from == to ? 1.0 : 0.0;
  vec3 a = pointAt(from), b = pointAt(to);
  // What lies behind the eye is drawn up to a little before it.
  float least = lens.z > 0.0 ? -0.999 * depths.y / (depths.x + 1.0) : -1e30;
  if (a.z < least && b.z > least) a = mix(a, b, (least - a.z) / (b.z - a.z));
  if (b.z < least && a.z > least) b = mix(b, a, (least - b.z) / (a.z - b.z));
  vec4 ca = clip(a), cb = clip(b);
  vec2 half2 = 0.5 * picture.xy;
  vec2 along = isPoint > 0.0 ? vec2(1.0, 0.0) : (cb.xy / cb.w - ca.xy / ca.w) * half2;
  along = dot(along, along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  bool atEnd = corner == 1u || corner == 2u || corner == 4u, left = corner == 2u || corner == 4u || corner == 5u;
  vec4 at = atEnd ? cb : ca;
  eyePoint = atEnd ? b : a;
  float width = isPoint > 0.0 ? 3.0 : 0.75;
  vec2 offset = across * (left ? width : -width);
  if (isPoint > 0.0) offset += along * (atEnd ? width : -width);
  at.xy += offset / half2 * at.w;
  // Slightly nearer than it is, so that a net on its surface is not half hidden by it.
  at.z -= 2e-4 * at.w;
  gl_Position = at;
}
`;

const FRAGMENT = `${PRECISION_TEXT}${FRAME_TEXT}
flat in float isPoint;
in vec3 eyePoint;
layout(location = 0) out vec4 colour;
void main() {
  if (section.xyz != vec3(0.0) && dot(section.xyz, eyePoint) > section.w) discard;
  colour = vec4(isPoint > 0.0 ? vec3(0.95, 0.35, 0.10) : vec3(0.20, 0.55, 0.95), 1.0);
}
`;

export class ControlNets {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Model} model
   */
  constructor(gl, model) {
    this.gl = gl;
    this.model = model;
    this.array = gl.createVertexArray();
    this.buffer = gl.createBuffer();
    gl.bindVertexArray(this.array);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribDivisor(0, 1);
    gl.bindVertexArray(null);
    /** The objects whose nets the buffer holds. */
    this.key = "";
    /** Patches of the same degrees, one after the other in the buffer. @type {{ degreeU: number, degreeV: number, first: number, count: number }[]} */
    this.runs = [];
  }

  /** @param {number[]} objects */
  choose(objects) {
    const key = objects.join(" ");
    if (key === this.key) return;
    this.key = key;
    /** @type {Map<number, number[]>} */
    const byDegree = new Map();
    for (const number of objects) {
      const surface = this.model.surfaces[this.model.objects[number].surface];
      if (surface.kind !== "patches") continue;
      for (let patch = surface.first; patch < surface.first + surface.count; patch++) {
        const { degreeU, degreeV, firstPoint } = patchHeader(this.model, patch);
        const degrees = degreeU * 256 + degreeV;
        const words = byDegree.get(degrees) ?? [];
        byDegree.set(degrees, words);
        words.push(firstPoint, number);
      }
    }
    this.runs = [];
    let first = 0;
    for (const [degrees, words] of byDegree) {
      const count = words.length / 2;
      this.runs.push({ degreeU: degrees >> 8, degreeV: degrees & 255, first, count });
      first += count;
    }
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, Uint32Array.from([...byDegree.values()].flat()), gl.STATIC_DRAW);
  }

  /**
   * @param {Programs} programs
   * @param {number[]} objects whose nets are shown
   * @param {boolean} wait
   * @param {FrameStatistics} statistics
   */
  draw(programs, objects, wait, statistics) {
    this.choose(objects);
    const { gl } = this;
    const program = programs.get("net", () => ({ vertex: VERTEX, fragment: FRAGMENT }), wait);
    if (!program || this.runs.length === 0) return;
    program.use();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    for (const { degreeU, degreeV, first, count } of this.runs) {
      gl.vertexAttribIPointer(0, 2, gl.UNSIGNED_INT, 0, first * 8);
      gl.uniform2ui(program.place("degree"), degreeU, degreeV);
      const figures = degreeU * (degreeV + 1) + (degreeU + 1) * degreeV + (degreeU + 1) * (degreeV + 1);
      gl.drawArraysInstanced(gl.TRIANGLES, 0, 6 * figures, count);
      statistics.draws += 1;
    }
    gl.bindVertexArray(null);
  }

  delete() {
    this.gl.deleteVertexArray(this.array);
    this.gl.deleteBuffer(this.buffer);
  }
}

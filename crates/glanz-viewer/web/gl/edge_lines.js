/**
 * Feature edges as lines of constant width in pixels, a little in front of the faces beside them.
 *
 * @module
 */

import { FRAME_TEXT } from "./frame.js";
import { PRECISION_TEXT } from "./shading_modes.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./frame.js").Frame} Frame */
/** @typedef {import("./programs.js").Programs} Programs */

/** An edge of a copy of a group. @typedef {{ copy: number, edge: number }} PlacedEdge */

/** Half width of lines, pixels; of the one that is selected. */
const HALF_WIDTH = 0.7;
const CHOSEN_HALF_WIDTH = 1.8;

/** Floats of a point: coordinates, and the number of its edge. */
const POINT = 4;

/** One instance is the segment from a point to the next one, a rectangle of four vertices; none where an edge ends. */
const VERTEX = `${PRECISION_TEXT}${FRAME_TEXT}
layout(location = 0) in vec4 from;
layout(location = 1) in vec4 to;
uniform mat4x3 place;
uniform float halfWidth;
out vec3 eyePoint;
out float across;
vec4 clip(vec3 p) {
  // Nearer by some pixels than it is, so that the faces beside it, whose grids are near them, do not hide half of it; wide lines before others.
  float w = lens.z * p.z + lens.w, before = p.z - (1.3 + halfWidth) * w / depths.z;
  return vec4(p.xy / lens.xy, (depths.x * before + depths.y) * w / (lens.z * before + lens.w), w);
}
void main() {
  vec3 a = place * vec4(from.xyz, 1.0), b = place * vec4(to.xyz, 1.0);
  // What lies behind the eye is drawn up to a little before it.
  float least = lens.z > 0.0 ? -0.999 * depths.y / (depths.x + 1.0) : -1e30;
  bool hidden = from.w != to.w || max(a.z, b.z) <= least;
  if (a.z < least && b.z > least) a = mix(a, b, (least - a.z) / (b.z - a.z));
  if (b.z < least && a.z > least) b = mix(b, a, (least - b.z) / (a.z - b.z));
  vec4 ca = clip(a), cb = clip(b);
  vec2 half2 = 0.5 * picture.xy;
  vec2 along = (cb.xy / cb.w - ca.xy / ca.w) * half2;
  along = dot(along, along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  bool atEnd = gl_VertexID > 1;
  float reach = halfWidth + 1.0;
  across = (gl_VertexID & 1) == 0 ? -reach : reach;
  vec4 at = atEnd ? cb : ca;
  eyePoint = atEnd ? b : a;
  // Segments overlap by half a pixel, so that nothing is left between them.
  at.xy += (vec2(-along.y, along.x) * across + along * (atEnd ? 0.5 : -0.5)) / half2 * at.w;
  // Pixels across are interpolated in the picture, not in space: gl_FragCoord.w divides by what is multiplied here.
  across *= at.w;
  gl_Position = hidden ? vec4(2.0, 2.0, 2.0, 1.0) : at;
}
`;

const FRAGMENT = `${PRECISION_TEXT}${FRAME_TEXT}
uniform float halfWidth;
uniform vec3 ink;
in vec3 eyePoint;
in float across;
layout(location = 0) out vec4 colour;
void main() {
  if (section.xyz != vec3(0.0) && dot(section.xyz, eyePoint) > section.w) discard;
  float coverage = clamp(halfWidth + 0.5 - abs(across * gl_FragCoord.w), 0.0, 1.0);
  if (coverage <= 0.0) discard;
  colour = vec4(ink, coverage);
}
`;

export class EdgeLines {
  /** @param {WebGL2RenderingContext} gl @param {Model} model */
  constructor(gl, model) {
    this.gl = gl;
    this.model = model;
    this.buffer = gl.createBuffer();
    this.array = gl.createVertexArray();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, pointRows(model), gl.STATIC_DRAW);
    gl.bindVertexArray(this.array);
    for (const location of [0, 1]) {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribDivisor(location, 1);
    }
    gl.bindVertexArray(null);
  }

  get isEmpty() {
    return this.model.edges.length === 0;
  }

  /** @param {Programs} programs @param {boolean} wait for it */
  program(programs, wait) {
    return programs.get("edge lines", () => ({ vertex: VERTEX, fragment: FRAGMENT }), wait);
  }

  /**
   * @param {Programs} programs
   * @param {Frame} frame
   * @param {Set<number>} hidden leaves
   * @param {PlacedEdge | null} chosen
   * @param {boolean} wait for the program
   */
  draw(programs, frame, hidden, chosen, wait) {
    if (this.isEmpty) return;
    const { gl, model } = this;
    const program = this.program(programs, wait);
    if (!program) return;
    program.use();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    model.edgeCopies.forEach((copy, number) => {
      gl.uniformMatrix4x3fv(program.place("place"), false, placed(frame, copy.toWorld));
      gl.uniform1f(program.place("halfWidth"), HALF_WIDTH);
      gl.uniform3f(program.place("ink"), 0.04, 0.04, 0.04);
      for (const [first, end] of shownRuns(model, copy, hidden)) this.drawRun(first, end);
      if (chosen?.copy !== number) return;
      gl.uniform1f(program.place("halfWidth"), CHOSEN_HALF_WIDTH);
      gl.uniform3f(program.place("ink"), 1, 0.45, 0);
      this.drawRun(chosen.edge, chosen.edge + 1);
    });
    gl.bindVertexArray(null);
  }

  /** Draws consecutive edges. @param {number} firstEdge @param {number} endEdge */
  drawRun(firstEdge, endEdge) {
    const { gl, model } = this;
    const { first } = model.edges[firstEdge];
    const last = model.edges[endEdge - 1];
    const segments = last.first + last.count - first - 1;
    if (segments <= 0) return;
    for (const location of [0, 1]) {
      gl.vertexAttribPointer(location, 4, gl.FLOAT, false, 4 * POINT, 4 * POINT * (first + location));
    }
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, segments);
  }

  delete() {
    this.gl.deleteBuffer(this.buffer);
    this.gl.deleteVertexArray(this.array);
  }
}

/** The points with the numbers of their edges. @param {Model} model */
function pointRows({ edges, blocks: { edgePoints } }) {
  const rows = new Float32Array((edgePoints.length / 3) * POINT);
  edges.forEach(({ first, count }, edge) => {
    for (let k = first; k < first + count; k++) {
      rows.set([edgePoints[3 * k], edgePoints[3 * k + 1], edgePoints[3 * k + 2], edge], POINT * k);
    }
  });
  return rows;
}

/** The map from a copy's points to the camera, by columns. @param {Frame} frame @param {number[]} map */
function placed(frame, map) {
  const column = (/** @type {number} */ k) =>
    /** @type {import("../linear.js").Vector} */ ([map[3 * k], map[3 * k + 1], map[3 * k + 2]]);
  return new Float32Array([0, 1, 2].flatMap((k) => frame.turn(column(k))).concat(frame.toCamera(column(3))));
}

/**
 * Whether a shape that meets in an edge of a copy is shown.
 * @param {import("../model.js").Edge} edge
 * @param {import("../model.js").EdgeCopy} copy
 * @param {Set<number>} hidden
 */
export function isEdgeShown(edge, copy, hidden) {
  return hidden.size === 0 || edge.shapes.some((shape) => !hidden.has(copy.firstLeaf + shape));
}

/**
 * Runs of consecutive edges that are shown, as first and end.
 * @param {Model} model
 * @param {import("../model.js").EdgeCopy} copy
 * @param {Set<number>} hidden
 */
export function shownRuns(model, copy, hidden) {
  /** @type {[number, number][]} */
  const runs = [];
  for (let edge = copy.first; edge < copy.first + copy.count; edge++) {
    if (!isEdgeShown(model.edges[edge], copy, hidden)) continue;
    const run = runs.at(-1);
    if (run && run[1] === edge) run[1] = edge + 1;
    else runs.push([edge, edge + 1]);
  }
  return runs;
}

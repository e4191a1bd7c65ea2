/**
 * Meshes of triangles.
 *
 * @module
 */

import { largestStretch } from "../linear.js";
import { boxOfMesh } from "./surface_boxes.js";
import { FRAME_TEXT } from "./frame.js";
import { OBJECT_TEXT, PRECISION_TEXT, shadingModeText } from "./shading_modes.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("../model.js").MeshSurface} MeshSurface */
/** @typedef {import("./surface_boxes.js").Box} Box */
/** @typedef {import("./frame.js").Frame} Frame */
/** @typedef {import("./shading_modes.js").ShadingMode} ShadingMode */
/** @typedef {import("./patches.js").FrameStatistics} FrameStatistics */
/** @typedef {import("./programs.js").Programs} Programs */

const VERTEX = `${PRECISION_TEXT}${FRAME_TEXT}${OBJECT_TEXT}
uniform uint object;
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 cornerNormal;
out vec3 eyePoint;
out vec3 eyeNormal;
void main() {
  mat4x3 place = placeOf(object);
  mat3 m = mat3(place);
  eyePoint = m * corner + place[3];
  // The inverse transposed but for a positive factor: a map that mirrors leaves the outside outside.
  float side = determinant(m) < 0.0 ? -1.0 : 1.0;
  eyeNormal = side * (cornerNormal.x * cross(m[1], m[2]) + cornerNormal.y * cross(m[2], m[0]) + cornerNormal.z * cross(m[0], m[1]));
  gl_Position = vec4(eyePoint.xy / lens.xy, depths.x * eyePoint.z + depths.y, lens.z * eyePoint.z + lens.w);
}
`;

/** @param {ShadingMode} mode */
function fragmentText(mode) {
  if (mode === "depth") {
    return `${PRECISION_TEXT}${shadingModeText(mode)}
in vec3 eyePoint;
void main() {
  if (section.xyz != vec3(0.0) && dot(section.xyz, eyePoint) > section.w) discard;
}
`;
  }
  return `${PRECISION_TEXT}${shadingModeText(mode)}
uniform uint object;
in vec3 eyePoint;
in vec3 eyeNormal;
layout(location = 0) out vec4 colour;
void main() {
  Facts facts = factsOf(object);
  Point point;
  point.object = object;
  point.position = eyePoint;
  vec3 sight = toEyeFrom(eyePoint);
  // Which side is seen is said by the triangle: vertex normals lean over its horizon.
  vec3 triangle = cross(dFdx(eyePoint), dFdy(eyePoint));
  if (dot(triangle, sight) < 0.0) triangle = -triangle;
  vec3 n = normalize(eyeNormal);
  point.front = dot(n, triangle) >= 0.0;
  point.normal = point.front ? n : -n;
  if ((facts.bits & REVERSED) != 0u) point.front = !point.front;
  point.normalX = dFdx(point.normal);
  point.normalY = dFdy(point.normal);
  point.principal = vec2(0.0);
  point.coverage = 1.0;
  point.line = 0.0;
  float over = dot(section.xyz, eyePoint) - section.w;
  float slope = length(vec2(dFdx(over), dFdy(over)));
  if (section.xyz != vec3(0.0)) point.coverage = clamp(0.5 - over / max(slope, 1e-20), 0.0, 1.0);
  // After the derivatives, which are undefined beside fragments that are discarded.
  if (point.coverage <= 0.0 || isLeftOut(facts, point.front)) discard;
${mode === "material" ? "  mapPlace = vec2(-1.0);" : ""}
  colour = shade(point, facts);
}
`;
}

/** @typedef {{ array: WebGLVertexArrayObject, box: Box }} Drawable */

export class Meshes {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Model} model
   */
  constructor(gl, model) {
    this.gl = gl;
    this.model = model;
    const { positions, normals, indices } = model.blocks;
    this.buffers = [positions, normals, indices].map((data, k) => {
      const buffer = gl.createBuffer();
      const target = k === 2 ? gl.ELEMENT_ARRAY_BUFFER : gl.ARRAY_BUFFER;
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, data, gl.STATIC_DRAW);
      return buffer;
    });
    /** By number of the surface. @type {(Drawable | null)[]} */
    this.drawables = model.surfaces.map((surface) => (surface.kind === "mesh" ? this.make(surface) : null));
    this.stretch = model.objects.map((object) => largestStretch(object.toWorld));
    /** Objects in sight. @type {number[]} */
    this.inSight = [];
  }

  /** @param {MeshSurface} surface @returns {Drawable} */
  make(surface) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const location of [0, 1]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[location]);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 12, surface.firstVertex * 12);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers[2]);
    gl.bindVertexArray(null);
    return { array, box: boxOfMesh(this.model.blocks.positions, surface) };
  }

  /** @param {Frame} frame @param {Float64Array} places @param {number[]} objects */
  cull(frame, places, objects) {
    this.inSight.length = 0;
    for (const number of objects) {
      const drawable = this.drawables[this.model.objects[number].surface];
      if (!drawable) continue;
      const { middle, half } = drawable.box;
      const [x, y, z] = middle;
      const at = 12 * number;
      const c = [0, 1, 2].map(
        (row) => places[at + row] * x + places[at + 3 + row] * y + places[at + 6 + row] * z + places[at + 9 + row],
      );
      const radius = Math.hypot(...half) * this.stretch[number];
      if (!frame.sees(c[0], c[1], c[2], radius)) continue;
      frame.include(c[2] - radius, c[2] + radius);
      this.inSight.push(number);
    }
  }

  /** Begins to compile the program of a mode. @param {Programs} programs @param {ShadingMode} mode */
  prepare(programs, mode) {
    if (this.drawables.some((drawable) => drawable !== null)) this.program(programs, mode, false);
  }

  /** @param {Programs} programs @param {ShadingMode} mode @param {boolean} wait */
  program(programs, mode, wait) {
    return programs.get(`mesh ${mode}`, () => ({ vertex: VERTEX, fragment: fragmentText(mode) }), wait);
  }

  /** @param {Programs} programs @param {ShadingMode} mode @param {boolean} wait @param {FrameStatistics} statistics */
  draw(programs, mode, wait, statistics) {
    if (this.inSight.length === 0) return;
    const { gl } = this;
    const program = this.program(programs, mode, wait);
    if (!program) return;
    program.use();
    for (const number of this.inSight) {
      const surface = /** @type {MeshSurface} */ (this.model.surfaces[this.model.objects[number].surface]);
      const drawable = /** @type {Drawable} */ (this.drawables[this.model.objects[number].surface]);
      gl.uniform1ui(program.place("object"), number);
      gl.bindVertexArray(drawable.array);
      gl.drawElements(gl.TRIANGLES, surface.indices, gl.UNSIGNED_INT, surface.firstIndex * 4);
      statistics.triangles += surface.indices / 3;
      statistics.draws += 1;
    }
    gl.bindVertexArray(null);
  }

  delete() {
    for (const buffer of this.buffers) this.gl.deleteBuffer(buffer);
    for (const drawable of this.drawables) if (drawable) this.gl.deleteVertexArray(drawable.array);
  }
}

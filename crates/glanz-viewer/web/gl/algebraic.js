/**
 * Algebraic surfaces: the ray of every pixel against the polynomial, within its box.
 *
 * @module
 */

import { inverseRows, largestStretch } from "../linear.js";
import { FRAME_TEXT } from "./frame.js";
import { CURVATURE_TEXT, OBJECT_TEXT, PRECISION_TEXT, shadingModeText, needsCurvature } from "./shading_modes.js";

/** @typedef {import("../linear.js").Vector} Vector */
/** @typedef {import("../model.js").AlgebraicSurface} AlgebraicSurface */
/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./frame.js").Frame} Frame */
/** @typedef {import("./shading_modes.js").ShadingMode} ShadingMode */
/** @typedef {import("./patches.js").FrameStatistics} FrameStatistics */
/** @typedef {import("./programs.js").Programs} Programs */

/** Terms of a polynomial of degree 4 in three variables. */
const MOST_TERMS = 35;

/** The faces of the box away from the eye, which are seen from within too. */
const VERTEX = `${PRECISION_TEXT}${FRAME_TEXT}${OBJECT_TEXT}
uniform uint object;
uniform vec3 low, high;
out vec3 eyePoint;
const uint FACES[36] = uint[36](0u, 2u, 1u, 1u, 2u, 3u, 4u, 5u, 6u, 5u, 7u, 6u, 0u, 1u, 4u, 1u, 5u, 4u,
  2u, 6u, 3u, 3u, 6u, 7u, 0u, 4u, 2u, 2u, 4u, 6u, 1u, 3u, 5u, 3u, 7u, 5u);
void main() {
  uint k = FACES[gl_VertexID];
  mat4x3 place = placeOf(object);
  eyePoint = place * vec4(mix(low, high, vec3(k & 1u, (k >> 1u) & 1u, k >> 2u)), 1.0);
  gl_Position = vec4(eyePoint.xy / lens.xy, depths.x * eyePoint.z + depths.y, lens.z * eyePoint.z + lens.w);
}
`;

/** Roots of a polynomial of degree up to 4, ascending, from those of its derivatives: between two of them it is monotone. */
const ROOTS = `
float quartic(float c[5], float t) { return (((c[4] * t + c[3]) * t + c[2]) * t + c[1]) * t + c[0]; }
// The zero of c in [low, high], where it is monotone and changes its sign.
float zeroBetween(float c[5], float d[5], float low, float high) {
  bool rises = quartic(c, high) > quartic(c, low);
  float t = 0.5 * (low + high);
  for (int k = 0; k < 32; k++) {
    float f = quartic(c, t);
    if ((f < 0.0) == rises) low = t; else high = t;
    float next = t - f / quartic(d, t);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (abs(next - t) <= 1e-7 * abs(t)) break;
    t = next;
  }
  return t;
}
// Between the ends and the roots of the derivative d; the number of roots.
int rootsOf(float c[5], float d[5], float from[4], int count, float low, float high, out float roots[4]) {
  int found = 0;
  float begin = low, fBegin = quartic(c, low);
  for (int k = 0; k <= 4; k++) {
    if (k > count) break;
    float end = high;
    if (k < count) end = from[min(k, 3)];
    float fEnd = quartic(c, end);
    if ((fBegin < 0.0) != (fEnd < 0.0) && found < 4) roots[found++] = zeroBetween(c, d, begin, end);
    begin = end;
    fBegin = fEnd;
  }
  return found;
}
int allRoots(float c[5], float low, float high, out float roots[4]) {
  float d1[5] = float[5](c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4], 0.0);
  float d2[5] = float[5](d1[1], 2.0 * d1[2], 3.0 * d1[3], 0.0, 0.0);
  float d3[5] = float[5](d2[1], 2.0 * d2[2], 0.0, 0.0, 0.0);
  float d4[5] = float[5](d3[1], 0.0, 0.0, 0.0, 0.0);
  float r0[4], r1[4], r2[4];
  int n = rootsOf(d3, d4, r0, 0, low, high, r1);
  n = rootsOf(d2, d3, r1, n, low, high, r2);
  n = rootsOf(d1, d2, r2, n, low, high, r1);
  return rootsOf(c, d1, r1, n, low, high, roots);
}
`;

/** The polynomial along a ray and at a point. */
const POLYNOMIAL = `
uniform vec4 terms[${MOST_TERMS}];    // powers of x, y, z; coefficient
uniform int termCount;
void timesLinear(inout float c[5], float constant, float slope) {
  for (int k = 4; k > 0; k--) c[k] = c[k] * constant + c[k - 1] * slope;
  c[0] *= constant;
}
void alongRay(vec3 o, vec3 d, out float c[5]) {
  c = float[5](0.0, 0.0, 0.0, 0.0, 0.0);
  for (int k = 0; k < termCount; k++) {
    float t[5] = float[5](terms[k].w, 0.0, 0.0, 0.0, 0.0);
    for (int axis = 0; axis < 3; axis++) for (int n = 0; n < int(terms[k][axis]); n++) timesLinear(t, o[axis], d[axis]);
    for (int n = 0; n < 5; n++) c[n] += t[n];
  }
}
float power(float x, float n) {
  float value = 1.0;
  for (int k = 0; k < int(n); k++) value *= x;
  return value;
}
// d/dx of x^n, and of that again: 0 where the power is used up.
vec3 powers(float x, float n) {
  return vec3(power(x, n), n * power(x, max(n - 1.0, 0.0)), n * (n - 1.0) * power(x, max(n - 2.0, 0.0)));
}
void derivatives(vec3 p, out vec3 gradient, out mat3 hessian) {
  gradient = vec3(0.0);
  hessian = mat3(0.0);
  for (int k = 0; k < termCount; k++) {
    vec3 x = powers(p.x, terms[k].x), y = powers(p.y, terms[k].y), z = powers(p.z, terms[k].z);
    float c = terms[k].w;
    gradient += c * vec3(x.y * y.x * z.x, x.x * y.y * z.x, x.x * y.x * z.y);
    float xy = c * x.y * y.y * z.x, xz = c * x.y * y.x * z.y, yz = c * x.x * y.y * z.y;
    hessian += mat3(c * x.z * y.x * z.x, xy, xz, xy, c * x.x * y.z * z.x, yz, xz, yz, c * x.x * y.x * z.z);
  }
}
`;

/** Finds the first root on the ray, in the box and not cut away, as a place in the surface's frame; discards where there is none. */
const INTERSECT = `
uniform uint object;
uniform vec3 low, high;
uniform mat3 fromEye;    // the inverse of the object's matrix
in vec3 eyePoint;
vec3 intersect(out vec3 position) {
  mat4x3 place = placeOf(object);
  vec2 ray = pixelRay(gl_FragCoord.xy);
  vec3 origin = lens.z > 0.0 ? vec3(0.0) : vec3(ray, 0.0);
  vec3 direction = lens.z > 0.0 ? vec3(ray, 1.0) : vec3(0.0, 0.0, 1.0);
  vec3 o = fromEye * (origin - place[3]), d = fromEye * direction;
  vec3 a = (low - o) / d, b = (high - o) / d;
  vec3 enter = min(a, b), leave = max(a, b);
  float begin = max(enter.x, max(enter.y, enter.z)), end = min(leave.x, min(leave.y, leave.z));
  if (lens.z > 0.0) begin = max(begin, 0.0);
  // The section plane ends the ray, or is where it begins.
  float slope = dot(section.xyz, direction), over = section.w - dot(section.xyz, origin);
  if (slope > 0.0) end = min(end, over / slope);
  if (slope < 0.0) begin = max(begin, over / slope);
  if (!(begin < end)) discard;
  // Counted from where the ray comes in, in units of its way through the box, so that powers of t stay small.
  vec3 from = o + begin * d, through = (end - begin) * d;
  float c[5], roots[4];
  alongRay(from, through, c);
  if (allRoots(c, 0.0, 1.0, roots) == 0) discard;
  position = origin + (begin + (end - begin) * roots[0]) * direction;
  gl_FragDepth = 0.5 + 0.5 * (depths.x * position.z + depths.y) / (lens.z * position.z + lens.w);
  return from + through * roots[0];
}
`;

/** Curvature from gradient and second derivatives, in two tangents that follow the picture's axes. */
const CURVATURE = `
  mat3 second = transpose(fromEye) * hessian * fromEye;
  float steep = length(gradient) * (dot(normal, point.normal) < 0.0 ? -1.0 : 1.0);
  vec2 sightSlope = vec2(dot(point.normal, vec3(1, 0, 0)), dot(point.normal, vec3(0, 1, 0)));
  vec3 along = lens.z > 0.0 ? point.position / point.position.z : vec3(0.0, 0.0, 1.0);
  float facing = dot(point.normal, along);
  facing = abs(facing) < 1e-4 ? -1e-4 : facing;
  // Moving one metre in the picture's plane, and along the sight back to the surface.
  vec3 su = vec3(1, 0, 0) - along * (sightSlope.x / facing), sv = vec3(0, 1, 0) - along * (sightSlope.y / facing);
  // n . d2p = - d p (second derivatives) d p / |gradient| on the surface.
  vec3 n = point.normal / steep;
  float metre = (lens.z * point.position.z + lens.w) / depths.z;
  bend(point, su, sv, -dot(su, second * su) * n, -dot(su, second * sv) * n, -dot(sv, second * sv) * n, mat2(metre, 0.0, 0.0, metre));
`;

/** @param {ShadingMode} mode */
function fragmentText(mode) {
  const beginning = `${PRECISION_TEXT}${shadingModeText(mode)}${ROOTS}${POLYNOMIAL}${INTERSECT}`;
  if (mode === "depth") return `${beginning}void main() { vec3 position; intersect(position); }\n`;
  return `${beginning}${needsCurvature(mode) ? CURVATURE_TEXT : ""}
layout(location = 0) out vec4 colour;
void main() {
  Facts facts = factsOf(object);
  Point point;
  point.object = object;
  vec3 inside = intersect(point.position);
  vec3 gradient;
  mat3 hessian;
  derivatives(inside, gradient, hessian);
  gradient = gradient * fromEye;
  vec3 normal = normalize(gradient) * ((facts.bits & REVERSED) != 0u ? -1.0 : 1.0);
  point.front = dot(normal, toEyeFrom(point.position)) >= 0.0;
  point.normal = point.front ? normal : -normal;
  point.normalX = point.normalY = vec3(0.0);
  point.principal = vec2(0.0);
  point.coverage = 1.0;
  point.line = 0.0;
${needsCurvature(mode) ? CURVATURE : ""}
${mode === "material" ? "  mapPlace = vec2(-1.0);" : ""}
  colour = shade(point, facts);
}
`;
}

export class AlgebraicSurfaces {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Model} model
   */
  constructor(gl, model) {
    this.gl = gl;
    this.model = model;
    this.array = gl.createVertexArray();
    this.stretch = model.objects.map((object) => largestStretch(object.toWorld));
    /** The terms as the programs want them. @type {(Float32Array | null)[]} */
    this.terms = model.surfaces.map((surface) => {
      if (surface.kind !== "algebraic") return null;
      return Float32Array.from(surface.terms.slice(0, MOST_TERMS).flat());
    });
    /** Objects in sight. @type {number[]} */
    this.inSight = [];
    this.matrix = new Float32Array(9);
  }

  /** @param {Frame} frame @param {Float64Array} places @param {number[]} objects */
  cull(frame, places, objects) {
    this.inSight.length = 0;
    for (const number of objects) {
      const surface = this.model.surfaces[this.model.objects[number].surface];
      if (surface.kind !== "algebraic") continue;
      const middle = surface.min.map((x, axis) => (x + surface.max[axis]) / 2);
      const at = 12 * number;
      const c = [0, 1, 2].map(
        (row) =>
          places[at + row] * middle[0] +
          places[at + 3 + row] * middle[1] +
          places[at + 6 + row] * middle[2] +
          places[at + 9 + row],
      );
      const half = Math.hypot(...surface.min.map((x, axis) => (surface.max[axis] - x) / 2));
      const radius = half * this.stretch[number];
      if (!frame.sees(c[0], c[1], c[2], radius)) continue;
      frame.include(c[2] - radius, c[2] + radius);
      this.inSight.push(number);
    }
  }

  /** Begins to compile the program of a mode. @param {Programs} programs @param {ShadingMode} mode */
  prepare(programs, mode) {
    if (this.terms.some((terms) => terms !== null)) this.program(programs, mode, false);
  }

  /** @param {Programs} programs @param {ShadingMode} mode @param {boolean} wait */
  program(programs, mode, wait) {
    return programs.get(`algebraic ${mode}`, () => ({ vertex: VERTEX, fragment: fragmentText(mode) }), wait);
  }

  /**
   * @param {Programs} programs
   * @param {ShadingMode} mode
   * @param {boolean} wait
   * @param {FrameStatistics} statistics
   * @param {Float64Array} places
   */
  draw(programs, mode, wait, statistics, places) {
    if (this.inSight.length === 0) return;
    const { gl } = this;
    const program = this.program(programs, mode, wait);
    if (!program) return;
    program.use();
    gl.bindVertexArray(this.array);
    gl.enable(gl.CULL_FACE);
    for (const number of this.inSight) {
      const index = this.model.objects[number].surface;
      const surface = /** @type {AlgebraicSurface} */ (this.model.surfaces[index]);
      const terms = /** @type {Float32Array} */ (this.terms[index]);
      const place = places.subarray(12 * number, 12 * number + 12);
      const inverse = inverseRows(place);
      if (!inverse) continue;
      // By columns, as uniforms are.
      inverse.forEach((row, i) => row.forEach((x, j) => (this.matrix[3 * j + i] = x)));
      gl.cullFace(isMirrored(place) ? gl.BACK : gl.FRONT);
      gl.uniform1ui(program.place("object"), number);
      gl.uniform3fv(program.place("low"), surface.min);
      gl.uniform3fv(program.place("high"), surface.max);
      gl.uniformMatrix3fv(program.place("fromEye"), false, this.matrix);
      gl.uniform4fv(program.place("terms"), terms);
      gl.uniform1i(program.place("termCount"), terms.length / 4);
      gl.drawArrays(gl.TRIANGLES, 0, 36);
      statistics.triangles += 12;
      statistics.draws += 1;
    }
    gl.disable(gl.CULL_FACE);
    gl.bindVertexArray(null);
  }

  delete() {
    this.gl.deleteVertexArray(this.array);
  }
}

/** True if the camera's axes, seen from the object, have the opposite handedness of (right, up, forward). @param {Float64Array} m */
function isMirrored(m) {
  const x = m[1] * m[5] - m[2] * m[4];
  const y = m[2] * m[3] - m[0] * m[5];
  const z = m[0] * m[4] - m[1] * m[3];
  return x * m[6] + y * m[7] + z * m[8] > 0;
}

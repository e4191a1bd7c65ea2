/**
 * The program that draws patches of one shape: a grid near the surface, then the surface itself at every pixel.
 *
 * @module
 */

import { jetText, positionText } from "./evaluation.js";
import { FRAME_TEXT } from "./frame.js";
import { CURVATURE_TEXT, OBJECT_TEXT, PRECISION_TEXT, shadingModeText, needsCurvature } from "./shading_modes.js";
import { MAPPING_TEXT, TRIMMING_TEXT } from "./trimming.js";

/** @typedef {import("./evaluation.js").Shape} Shape */
/** @typedef {import("./shading_modes.js").ShadingMode} ShadingMode */

/** Largest distance of the grid from the surface, pixels. The surface is solved for at every pixel, so this matters at silhouettes only. */
export const TOLERANCE = 0.25;

/** Words of a grid to be drawn: patch, object, first cell (x + 65536 y), levels of the grid (u, v) and of the four sides (4 bits each). */
export const INSTANCE_WORDS = 4;

/** How far grids go on past the sides of their patches where seams are filled: pixels in the picture, but at most pixels along the surface, and cells. */
const PAST_SIDES = `const float BEYOND = 1.0, FARTHEST = 4.0, MOST = 2.0;
`;

/** @param {Shape} shape */
export function patchVertexText(shape) {
  return `${PRECISION_TEXT}
${FRAME_TEXT}${OBJECT_TEXT}${positionText(shape)}
uniform usampler2D patches;
layout(location = 0) in vec2 cell;
layout(location = 1) in uvec4 instance;
centroid out vec2 parameters;
flat out uvec4 which;    // first point, object, patch, borders
flat out vec2 cellSize;
flat out vec4 sides;     // least and largest parameters
out vec3 eyePoint;

// The number of a point along a side, moved to a point of the side's own, coarser grid.
uint snapped(uint at, uint level, uint side) {
  uint shift = level - min(side, level);
  return (at >> shift) << shift;
}

${PAST_SIDES}
// Moves p by what the grid may be within the surface, along the normal, and on sides of the patch straight on past them; 'outward': -1 or 1 along u and v on
// a side, else 0.
void extend(uint first, mat4x3 place, vec2 outward, float facing, inout vec3 p) {
  vec3 on = p, tangents[2];
  vec2 from = parameters;
  float w = lens.z * on.z + lens.w;
  for (int axis = 0; axis < 2; axis++) {
    vec2 inner = from;
    float quarter = 0.25 * (outward[axis] == 0.0 ? 1.0 : outward[axis]) * cellSize[axis];
    inner[axis] -= quarter;
    // In pixels.
    vec3 step = (on - mat3(place) * position(first, inner) - place[3]) * depths.z / w;
    tangents[axis] = step * sign(quarter);
    float across = length(step.xy - on.xy * (lens.z * step.z / w));
    // Not at a silhouette: longer triangles would be farther within it.
    if (outward[axis] == 0.0 || !(across * FARTHEST > length(step))) continue;
    float quarters = min(BEYOND / across, 4.0 * MOST);
    p += step * (quarters * w / depths.z);
    parameters[axis] += quarters * quarter;
  }
  vec3 n = cross(tangents[0], tangents[1]);
  float size = length(n);
  if (size > 0.0) p += n * (facing * ${TOLERANCE} / size * w / depths.z);
}

void main() {
  uvec2 at = uvec2(instance.z & 65535u, instance.z >> 16u) + uvec2(cell);
  uint levels = instance.w;
  uint levelU = levels & 15u, levelV = (levels >> 4u) & 15u;
  uvec2 count = uvec2(1u << levelU, 1u << levelV);
  uvec2 moved = at;
  if (at.y == 0u) moved.x = snapped(at.x, levelU, (levels >> 8u) & 15u);
  if (at.y == count.y) moved.x = snapped(at.x, levelU, (levels >> 12u) & 15u);
  if (at.x == 0u) moved.y = snapped(at.y, levelV, (levels >> 16u) & 15u);
  if (at.x == count.x) moved.y = snapped(at.y, levelV, (levels >> 20u) & 15u);
  parameters = vec2(moved) / vec2(count);
  uint row = instance.x * 4u;
  uvec4 facts = texelFetch(patches, ivec2(row & 2047u, row >> 11u), 0);
  which = uvec4(facts.y, instance.y, instance.x, facts.w);
  cellSize = 1.0 / vec2(count);
  // Beside a chord of a side lies a part of the neighbour, which goes on smoothly if it is of the same surface. A side that is a point has no other side.
  bvec4 isPoint = equal((uvec4(levels) >> uvec4(16u, 8u, 20u, 12u)) & 15u, uvec4(15u));
  sides = vec4(0.0, 0.0, 1.0, 1.0) + 0.1 * mix(vec4(-cellSize, cellSize), vec4(0.0), isPoint);
  mat4x3 place = placeOf(instance.y);
  vec3 p = mat3(place) * position(facts.y, parameters) + place[3];
  if (depths.w > 0.0) {
    float facing = sign(determinant(mat3(place))) * ((factsOf(instance.y).bits & REVERSED) != 0u ? -1.0 : 1.0);
    extend(facts.y, place, vec2(equal(at, count)) - vec2(equal(at, uvec2(0u))), facing, p);
  }
  eyePoint = p;
  float w = lens.z * p.z + lens.w, behind = p.z + depths.w * w / depths.z;
  gl_Position = vec4(p.xy / lens.xy, (depths.x * behind + depths.y) * w / (lens.z * behind + lens.w), w);
}
`;
}

const INPUTS = `
uniform usampler2D patches;
// Of slivers beside a border that cover a sample, but not the middle of the pixel, not to be extrapolated.
centroid in vec2 parameters;
flat in uvec4 which;
flat in vec2 cellSize;
flat in vec4 sides;
`;

/**
 * Convergence of the pixel's Newton iteration, pixels and cells (the rest is corrected to first order; over a cell, normals may turn by more than a right angle), and
 * the distance from which the grid's parameters are no start value, pixels.
 */
const NEAR = `const float NEAR = 0.005, SETTLED = 0.005;
const float LOST = 16.0;
`;

/** Newton's method towards the ray of the pixel, which leaves p.xy = ray (a p.z + b). */
const NEWTON = `
// Columns: change of the place in the plane across the ray, in metres.
mat2 acrossRay(vec3 su, vec3 sv, vec2 ray) {
  return mat2(su.xy - ray * (lens.z * su.z), sv.xy - ray * (lens.z * sv.z));
}
// A step of one cell along which the place hardly changes in the picture, towards the eye.
vec2 stepOverFold(vec3 su, vec3 sv, vec2 ray) {
  mat2 j = acrossRay(su, sv, ray);
  float a = dot(j[0], j[0]), b = dot(j[1], j[1]), c = dot(j[0], j[1]);
  vec2 along = a > b ? vec2(-c, a) : vec2(b, -c);
  along *= dot(along, vec2(su.z, sv.z)) > 0.0 ? -1.0 : 1.0;
  return along / max(max(abs(along.x) / cellSize.x, abs(along.y) / cellSize.y), 1e-30);
}
// The step is kept within 'reach': at a silhouette the ray may miss the surface.
vec2 newtonStep(vec3 s, vec3 su, vec3 sv, vec2 ray, vec2 reach) {
  mat2 j = acrossRay(su, sv, ray);
  vec2 off = ray * (lens.z * s.z + lens.w) - s.xy;
  float det = determinant(j);
  vec2 delta = vec2(off.x * j[1].y - off.y * j[1].x, j[0].x * off.y - j[0].y * off.x);
  // Compared before dividing: det may be 0.
  if (!(abs(delta.x) < reach.x * abs(det) && abs(delta.y) < reach.y * abs(det))) {
    float excess = max(abs(delta.x) / reach.x, abs(delta.y) / reach.y);
    return excess > 0.0 ? delta * (det < 0.0 ? -1.0 : 1.0) / excess : vec2(0.0);
  }
  return delta / det;
}
`;

/** Lines of a pixel's width: borders of faces, curves of equal parameters. */
const LINES = `
// A line where x = 0; 'gradient': change of x from pixel to pixel. It fades where many would fall into a pixel.
float lineAt(float x, vec2 gradient, float spacing) {
  float slope = length(gradient);
  return clamp(1.2 - abs(x) / max(slope, 1e-20), 0.0, 1.0) * clamp(1.5 - 5.0 * slope / spacing, 0.0, 1.0);
}
float borderLines(vec2 w, mat2 toParameters, uint borders) {
  vec2 gu = vec2(toParameters[0].x, toParameters[1].x), gv = vec2(toParameters[0].y, toParameters[1].y);
  float line = 0.0;
  if ((borders & 1u) != 0u) line = max(line, lineAt(w.y, gv, 1.0));
  if ((borders & 2u) != 0u) line = max(line, lineAt(1.0 - w.y, gv, 1.0));
  if ((borders & 4u) != 0u) line = max(line, lineAt(w.x, gu, 1.0));
  if ((borders & 8u) != 0u) line = max(line, lineAt(1.0 - w.x, gu, 1.0));
  return line;
}
float isocurveLines(vec2 share, mat2 toShare, float count) {
  vec2 off = (fract(share * count + 0.5) - 0.5) / count;
  float u = lineAt(off.x, vec2(toShare[0].x, toShare[1].x), 1.0 / count);
  float v = lineAt(off.y, vec2(toShare[0].y, toShare[1].y), 1.0 / count);
  return max(u, v);
}
`;

/** Statements that define `point` at the parameters `w`. */
const LOCATE = `
  uint first = which.x;
  mat4x3 place = placeOf(which.y);
  mat3 turn = mat3(place);
  vec2 ray = pixelRay(gl_FragCoord.xy);
  vec2 w = clamp(parameters, 0.0, 1.0), rest = vec2(0.0);
  vec3 s, su, sv;
  Jet jet;
  vec2 reach = 2.0 * cellSize;
  int most = 6;
  // One step is usual. At a silhouette, where the ray may miss the surface, there are as many as there may be.
  for (int k = 0; k <= most; k++) {
    w = clamp(w + rest, sides.xy, sides.zw);
    jet = evaluate(first, w);
    s = turn * jet.s + place[3];
    su = turn * jet.su;
    sv = turn * jet.sv;
    float miss = length(s.xy - ray * (lens.z * s.z + lens.w)) * depths.z / (lens.z * s.z + lens.w);
    if (k == 0 && miss > LOST) {
      // A sliver of the grid says little about parameters: they are looked for in all of the patch, off its sides, which may be points.
      reach = vec2(0.5);
      most = 9;
      rest = 0.02 * (0.5 - w);
      continue;
    }
    float facing = determinant(acrossRay(su, sv, ray));
    if (k == 0 && (facing > 0.0) != gl_FrontFacing && abs(facing) < 0.5 * length(cross(su, sv))) {
      // Beyond the silhouette that goes through this triangle.
      rest = stepOverFold(su, sv, ray);
      continue;
    }
    rest = newtonStep(s, su, sv, ray, reach);
    if (miss < NEAR && all(lessThan(abs(rest), SETTLED * cellSize))) break;
  }
  vec2 slack = 0.1 * cellSize;
  if (depths.w > 0.0) {
    // Where seams are filled, the surface goes straight on past the sides of the patch, as far as the grid does.
    bvec2 past = bvec2((w.x == sides.x && rest.x < 0.0) || (w.x == sides.z && rest.x > 0.0), (w.y == sides.y && rest.y < 0.0) || (w.y == sides.w && rest.y > 0.0));
    float pixel = (lens.z * s.z + lens.w) / depths.z;
    vec2 most = FARTHEST * pixel / max(vec2(length(su), length(sv)), 1e-20);
    slack = max(slack, vec2(past) * min(most, MOST * cellSize));
  }
  rest = clamp(rest, -slack, slack);
  Point point;
  point.object = which.y;
  point.position = s + su * rest.x + sv * rest.y;
  vec3 n = cross(su, sv);
  // At a pole the tangents give no normal: the one beside it is taken.
  float longest = max(dot(su, su), dot(sv, sv));
  if (!(dot(n, n) > 1e-7 * longest * longest)) {
    Jet beside = evaluate(first, mix(w, vec2(0.5), 4e-3));
    n = cross(turn * beside.su, turn * beside.sv);
  }
  // The inverse transposed but for a positive factor, as meshes have it.
  n = normalize(n) * sign(determinant(turn)) * ((facts.bits & REVERSED) != 0u ? -1.0 : 1.0);
  point.front = dot(n, toEyeFrom(point.position)) >= 0.0;
  if (isLeftOut(facts, point.front)) discard;
  point.normal = point.front ? n : -n;
  point.normalX = point.normalY = vec3(0.0);
  point.principal = vec2(0.0);
  point.coverage = 1.0;
  point.line = 0.0;
  w += rest;
  // Change of the place in the picture with the parameters, and the other way round.
  float enlarged = depths.z / (lens.z * point.position.z + lens.w);
  mat2 toPixels = enlarged * acrossRay(su, sv, ray);
  float size = max(dot(toPixels[0], toPixels[0]), dot(toPixels[1], toPixels[1]));
  float area = determinant(toPixels);
  if (abs(area) < 1e-6 * size) area = area < 0.0 ? -1e-6 * size : 1e-6 * size;
  mat2 toParameters = mat2(toPixels[1].y, -toPixels[0].y, -toPixels[1].x, toPixels[0].x) / area;
`;

/** Statements that leave out what is cut away. */
const SECTION = `
  if (section.xyz != vec3(0.0)) {
    float over = dot(section.xyz, point.position) - section.w;
    vec2 slope = vec2(dot(section.xyz, su), dot(section.xyz, sv)) * toParameters;
    point.coverage *= clamp(0.5 - over / max(length(slope), 1e-20), 0.0, 1.0);
  }
`;

/** Statements that end soon where a seam is filled, but is not near. */
const FAR_FROM_SEAMS = `
  if (depths.w > 0.0) {
    mat2 unused;
    // Not clamped: beyond a side of the patch, clamped parameters would not change from pixel to pixel.
    vec2 near = surfaceParameters(which.z, (facts.bits & REVOLUTION) != 0u, parameters, unused);
    vec2 pixels = 4.0 * (abs(dFdx(near)) + abs(dFdy(near)));
    if ((facts.bits & SHARED) == 0u || !isNearCurve(facts.firstCell, facts.cells, near, pixels)) discard;
  }
`;

const TRIM = `
  mat2 toSurface;
  vec2 at = surfaceParameters(which.z, (facts.bits & REVOLUTION) != 0u, w, toSurface);
  mat2 back = toPixels * inverse(toSurface);
  vec2 border = trimmingDistance(facts.firstCell, facts.cells, at, back, true);
  // Of two faces that meet in a pixel, both cover the same samples first: where they fill their seam, each covers all if one may be on it, that is less
  // than 0.4 pixels from the middle.
  point.coverage *= clamp(depths.w > 0.0 ? 2.0 * border.x + 1.8 : border.x + 0.5, 0.0, 1.0);
  point.line = drawn.x * clamp(1.2 - border.y, 0.0, 1.0);
`;

const SHARES = `
  if (drawn.y > 0.0) {
    mat2 toShare = toParameters;
    vec2 share = w;
    if ((facts.bits & REVOLUTION) != 0u) {
      vec4 angles = patchWords(which.z, 2u);
      vec2 x = parameterShare(w.x, angles.x, 0.0), y = parameterShare(w.y, angles.y, angles.z);
      share = vec2(x.x, y.x);
      toShare = mat2(x.y, 0.0, 0.0, y.y) * toParameters;
    }
    point.line = max(point.line, 0.6 * isocurveLines(share, toShare, drawn.y));
  }
`;

/**
 * @param {Shape} shape
 * @param {boolean} trimmed
 * @param {ShadingMode} mode
 */
export function patchFragmentText(shape, trimmed, mode) {
  if (mode === "depth") return depthText(trimmed);
  const second = needsCurvature(mode);
  const lines = mode !== "read" && mode !== "normals";
  return `${PRECISION_TEXT}${shadingModeText(mode)}${INPUTS}${jetText(shape, second)}${trimmed ? TRIMMING_TEXT : MAPPING_TEXT}
${second ? CURVATURE_TEXT : ""}${NEAR}${PAST_SIDES}${NEWTON}${LINES}
layout(location = 0) out vec4 colour;
void main() {
  Facts facts = factsOf(which.y);
${trimmed ? FAR_FROM_SEAMS : ""}${LOCATE}${trimmed ? TRIM : ""}${SECTION}
  if (point.coverage <= 0.0) discard;
${lines ? `  if (drawn.x > 0.0) point.line = max(point.line, borderLines(w, toParameters, which.w));\n${SHARES}` : ""}
${second ? "  bend(point, su, sv, turn * jet.suu, turn * jet.suv, turn * jet.svv, toParameters);" : ""}
${mode === "material" ? MAP_PLACE : ""}
  colour = shade(point, facts);
}
`;
}

const MAP_PLACE = `
  vec4 mapRectangle = patchWords(which.z, 3u);
  // Parameters may lie past the sides of the patch, where the map has values of other patches.
  mapPlace = mapRectangle.z > 0.0 ? mapRectangle.xy + clamp(w, 0.0, 1.0) * mapRectangle.zw : vec2(-1.0);
  mapChange = mat2(mapRectangle.zw * toParameters[0], mapRectangle.zw * toParameters[1]);
  if (!point.front) mapPlace.y += mapScale.z;
  vec2 mapSize = vec2(textureSize(mapValues, 0));
  mapFirst = floor(mapRectangle.xy * mapSize);
  if (!point.front) mapFirst.y += round(mapScale.z * mapSize.y);
  mapLast = mapFirst + round(mapRectangle.zw * mapSize);
`;

/** For shadow maps: the grid's own parameters are near enough. @param {boolean} trimmed */
function depthText(trimmed) {
  const trim = `
  Facts facts = factsOf(which.y);
  mat2 toSurface;
  vec2 at = surfaceParameters(which.z, (facts.bits & REVOLUTION) != 0u, parameters, toSurface);
  if (trimmingDistance(facts.firstCell, facts.cells, at, mat2(1.0), false).x < 0.0) discard;
`;
  return `${PRECISION_TEXT}${shadingModeText("depth")}${INPUTS}${trimmed ? TRIMMING_TEXT : ""}
in vec3 eyePoint;
void main() {
  if (section.xyz != vec3(0.0) && dot(section.xyz, eyePoint) > section.w) discard;
${trimmed ? trim : ""}}
`;
}

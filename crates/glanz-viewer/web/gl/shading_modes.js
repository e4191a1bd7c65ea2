/**
 * Shader text of the shading modes: light, zebra stripes, colours of curvature, normals.
 *
 * @module
 */

import { DIVERGING, shaderArray, VIRIDIS } from "../colours.js";
import { MOST_LEVELS } from "../lux_scale.js";
import { FRAME_TEXT } from "./frame.js";
import { SHADING_TEXT, TONE_TEXT } from "./shading.js";

/**
 * Output of a program. `read`: normals and object numbers; `depth`: depth alone.
 * @typedef {"material" | "zebra" | "gaussian" | "mean" | "maximum" | "normals" | "read" | "depth"} ShadingMode
 */

/** True if a shading mode needs second derivatives. @param {ShadingMode} mode */
export function needsCurvature(mode) {
  return mode === "zebra" || mode === "gaussian" || mode === "mean" || mode === "maximum";
}

/** The beginning of all shaders. */
export const PRECISION_TEXT = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
`;

/** Data of an object in all surface shaders: two texels of \`objectFacts\`. */
export const OBJECT_TEXT = `
uniform usampler2D objectFacts;
uniform sampler2D objectPlaces;
struct Facts { uint material, firstCell; ivec2 cells; uint leaf, bits; };
const uint REVERSED = 1u, REVOLUTION = 2u, MAPPED = 4u, SHARED = 8u, OUTSIDE_FRONT = 16u, OUTSIDE_BACK = 32u;
Facts factsOf(uint number) {
  uint at = number * 2u;
  ivec2 place = ivec2(at & 2047u, at >> 11u);
  uvec4 a = texelFetch(objectFacts, place, 0), b = texelFetch(objectFacts, place + ivec2(1, 0), 0);
  return Facts(a.x, a.y, ivec2(a.z & 65535u, a.z >> 16u), b.x, b.y);
}
// Whether the section plane goes through it.
bool isCut(uint number) {
  uint at = number * 4u;
  return texelFetch(objectPlaces, ivec2(at & 2047u, at >> 11u), 0).w > 0.0;
}
// Whether it is an outer wall, seen from outside.
bool isLeftOut(Facts facts, bool front) {
  return walls.x > 0.0 && (facts.bits & (front ? OUTSIDE_FRONT : OUTSIDE_BACK)) != 0u;
}
mat4x3 placeOf(uint number) {
  uint at = number * 4u;
  ivec2 place = ivec2(at & 2047u, at >> 11u);
  mat4x3 m;
  for (int k = 0; k < 4; k++) m[k] = texelFetch(objectPlaces, place + ivec2(k, 0), 0).xyz;
  return m;
}
`;

/** The visible point that the shading modes take. */
const POINT = `
struct Point {
  vec3 position, normal;    // camera's axes; the normal towards the eye
  vec3 normalX, normalY;    // change of the normal from pixel to pixel
  vec2 principal;           // curvatures, 1/m: the larger one and the smaller one, above 0 where it is convex to the eye
  bool front;               // seen from the side of the surface's own normal
  float coverage;           // share of the pixel
  float line;               // darkness of lines, 0 to 1
  uint object;
};
vec3 toEyeFrom(vec3 p) { return lens.z > 0.0 ? normalize(-p) : vec3(0.0, 0.0, -1.0); }
vec3 toWorldAxes(vec3 v) { return vec3(dot(axisX.xyz, v), dot(axisY.xyz, v), dot(axisZ.xyz, v)); }
// Where the ray of a pixel passes w = 1.
vec2 pixelRay(vec2 at) { return (2.0 * at / picture.xy - 1.0) * lens.xy; }
`;

const NORMALS = `
vec4 shade(Point point, Facts facts) {
  return vec4(0.5 + 0.5 * toWorldAxes(point.normal), point.coverage);
}
`;

const READ = `
vec4 shade(Point point, Facts facts) {
  if (point.coverage < 0.5) discard;
  return vec4(toWorldAxes(point.normal), float(point.object + 1u));
}
`;

/** Flat colour with stripes for what is seen from within once a section plane has cut it open, and a tint for what is selected. */
const MARKS = `
vec3 marked(vec3 colour, Point point, Facts facts) {
  if (!point.front && isCut(point.object)) {
    float stripe = fract((gl_FragCoord.x + gl_FragCoord.y) / 10.0);
    float hatch = clamp(min(stripe, 1.0 - stripe) * 10.0 - 1.0, 0.0, 1.0);
    colour = mix(vec3(0.62, 0.30, 0.22), vec3(0.80, 0.50, 0.38), hatch);
  }
  if (float(facts.leaf) == picture.w) {
    float rim = 1.0 - abs(dot(point.normal, toEyeFrom(point.position)));
    colour = mix(colour, vec3(1.0, 0.62, 0.10), 0.18 + 0.7 * rim * rim * rim);
  }
  return mix(colour, vec3(0.04), point.line);
}
`;

const MATERIAL = `
vec4 shade(Point point, Facts facts) {
  Material material = materialOf(facts.material);
  vec4 light = reflected(material, point.position, point.normal, toEyeFrom(point.position), point.front);
  vec3 colour = display(light.xyz, picture.z);
  if (drawn.z > 0.0 && (facts.bits & MAPPED) != 0u && mapPlace.x >= 0.0) {
    colour = mapColour();
    if (mapScale.y > 0.0) {
      // Surfaces that light passes show illuminances, too, and so do backs that a section plane lays open; the tint of what is selected would change what the
      // colours say.
      light.w = 1.0;
      facts.leaf = ~0u;
      point.front = true;
    }
  }
  colour = marked(colour, point, facts);
  return vec4(colour, max(light.w, point.line) * point.coverage);
}
`;

/** Stripes of equal angle between the mirrored line of sight and the world's up, their borders as wide as a pixel. */
const ZEBRA = `
vec4 shade(Point point, Facts facts) {
  vec3 n = point.normal, sight = -toEyeFrom(point.position);
  vec3 mirrored = reflect(sight, n);
  float cosine = clamp(dot(mirrored, upward.xyz), -1.0, 1.0);
  // The mirrored direction is d - 2 (d n) n; the line of sight itself changes by one pixel's angle, along the picture.
  float turn = lens.z > 0.0 ? 1.0 / (depths.z * length(point.position / point.position.z)) : 0.0;
  vec2 change;
  for (int k = 0; k < 2; k++) {
    vec3 dn = k == 0 ? point.normalX : point.normalY, ds = turn * (k == 0 ? vec3(1, 0, 0) : vec3(0, 1, 0));
    vec3 dr = ds - 2.0 * (dot(ds, n) + dot(sight, dn)) * n - 2.0 * dot(sight, n) * dn;
    change[k] = dot(dr, upward.xyz);
  }
  float stripes = upward.w / PI;
  float phase = acos(cosine) * stripes;
  float width = length(change) * stripes / sqrt(max(1.0 - cosine * cosine, 1e-6));
  // A wave of triangles, 0.5 within the bright stripes' middle and -0.5 within the dark ones', cut at its borders over one pixel.
  float wave = abs(fract(phase * 0.5) * 2.0 - 1.0) - 0.5;
  float bright = mix(0.5, clamp(0.5 + wave / max(width, 1e-6), 0.0, 1.0), clamp(2.0 - 2.0 * width, 0.0, 1.0));
  float shade = 0.85 + 0.15 * dot(n, -sight);
  return vec4(marked(mix(vec3(0.05), vec3(0.96), bright) * shade, point, facts), point.coverage);
}
`;

/** Blue, grey, red. */
const CURVATURE = `
vec4 shade(Point point, Facts facts) {
  float k1 = point.principal.x, k2 = point.principal.y;
#if defined(MODE_GAUSSIAN)
  float value = sign(k1 * k2) * sqrt(abs(k1 * k2));
#elif defined(MODE_MEAN)
  float value = 0.5 * (k1 + k2);
#else
  float value = abs(k1) > abs(k2) ? k1 : k2;
#endif
  float x = clamp(value / drawn.w, -1.0, 1.0);
  const vec3 ENDS[3] = ${shaderArray(DIVERGING)};
  vec3 colour = mix(ENDS[1], x < 0.0 ? ENDS[0] : ENDS[2], abs(x)) / 255.0;
  colour *= 0.8 + 0.2 * dot(point.normal, toEyeFrom(point.position));
  return vec4(marked(colour, point, facts), point.coverage);
}
`;

/** Light maps and lux maps of the scene, as radiance or in false colours with isolux lines. */
export const MAP_TEXT = `
uniform sampler2D mapValues;
uniform vec3 mapScale;    // factor of light; 1 for false colours, 0 for light; offset of the values of the back along y
uniform vec3 luxScale;    // illuminances, or their logarithms, with the first and the last colour; 1 for logarithms
uniform int isoluxCount;
uniform float isoluxLevels[${MOST_LEVELS}];
const vec3 VIRIDIS[9] = ${shaderArray(VIRIDIS)};
vec2 mapPlace;
vec2 mapFirst, mapLast;   // first and last texel of the patch
mat2 mapChange;           // change of the place from pixel to pixel
vec3 falseColour(float lux) {
  float value = luxScale.z > 0.0 ? log(max(lux, 1e-30)) : lux;
  float x = clamp((value - luxScale.x) / (luxScale.y - luxScale.x), 0.0, 1.0) * 8.0;
  int k = min(int(x), 7);
  return mix(VIRIDIS[k], VIRIDIS[k + 1], x - float(k)) / 255.0;
}
vec3 mapColour() {
  if (mapScale.y == 0.0) return display(texture(mapValues, mapPlace).xyz * mapScale.x, picture.z);
  // Not filtered by the texture unit: single floats cannot be filtered everywhere, and the gradient is needed.
  vec2 size = vec2(textureSize(mapValues, 0)), at = clamp(mapPlace * size - 0.5, mapFirst, mapLast);
  // At the last texel, the gradient is that towards the one before, not towards one of another patch.
  vec2 low = max(min(floor(at), mapLast - 1.0), mapFirst), part = at - low;
  ivec2 first = ivec2(low), last = first + 1;
  float a = texelFetch(mapValues, first, 0).x, b = texelFetch(mapValues, ivec2(last.x, first.y), 0).x;
  float c = texelFetch(mapValues, ivec2(first.x, last.y), 0).x, d = texelFetch(mapValues, last, 0).x;
  float lux = mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
  vec3 colour = falseColour(lux);
  // Illuminance from pixel to pixel: lines are as wide wherever they are.
  float slope = length((vec2(mix(b - a, d - c, part.y), mix(c - a, d - b, part.x)) * size) * mapChange);
  float line = 0.0;
  for (int k = 0; k < isoluxCount; k++) {
    float level = isoluxLevels[k];
    // Where all is alike there is no line, and where lines run together they are fainter.
    if (!(slope > 1e-7 * level)) continue;
    float gap = isoluxCount == 1 ? level : isoluxLevels[min(k + 1, isoluxCount - 1)] - isoluxLevels[min(k, isoluxCount - 2)];
    line = max(line, clamp(1.25 - abs(lux - level) / slope, 0.0, 1.0) * clamp(0.5 * gap / slope - 0.5, 0.35, 1.0));
  }
  float brightness = dot(colour, vec3(0.299, 0.587, 0.114));
  return mix(colour, vec3(brightness < 0.45 ? 1.0 : 0.0), 0.9 * line);
}
`;

/** Principal curvatures and the change of the normal from the two fundamental forms. */
export const CURVATURE_TEXT = `
// n: unit normal; columns of toParameters: change of (u, v) from pixel to pixel.
void bend(inout Point point, vec3 su, vec3 sv, vec3 suu, vec3 suv, vec3 svv, mat2 toParameters) {
  vec3 n = point.normal;
  float e = dot(su, su), f = dot(su, sv), g = dot(sv, sv);
  float l = dot(suu, n), m = dot(suv, n), o = dot(svv, n);
  float det = max(e * g - f * f, 1e-30);
  float gaussian = (l * o - m * m) / det;
  // Above 0 where it is convex to the eye, so that a ball has curvatures above 0.
  float mean = -0.5 * (e * o - 2.0 * f * m + g * l) / det;
  float root = sqrt(max(mean * mean - gaussian, 0.0));
  point.principal = vec2(mean + root, mean - root);
  // Weingarten's equations (@docarmo1976).
  vec3 nu = ((m * f - l * g) * su + (l * f - m * e) * sv) / det;
  vec3 nv = ((o * f - m * g) * su + (m * f - o * e) * sv) / det;
  point.normalX = nu * toParameters[0].x + nv * toParameters[0].y;
  point.normalY = nu * toParameters[1].x + nv * toParameters[1].y;
}
`;

/**
 * The part of a fragment shader that all kinds of surfaces share: `Point`, and `vec4 shade(Point, Facts)`.
 * @param {ShadingMode} mode
 */
export function shadingModeText(mode) {
  const common = FRAME_TEXT + OBJECT_TEXT + POINT;
  if (mode === "material") return common + SHADING_TEXT + MAP_TEXT + MARKS + MATERIAL;
  if (mode === "zebra") return `${common}const float PI = 3.14159265358979;\n${MARKS}${ZEBRA}`;
  if (mode === "normals") return common + TONE_TEXT + MARKS + NORMALS;
  if (mode === "read") return common + READ;
  if (mode === "depth") return common;
  return `#define MODE_${mode.toUpperCase()}\n${common}${MARKS}${CURVATURE}`;
}

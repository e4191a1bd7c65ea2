/**
 * Shader text that decides whether a point of a surface is there, from the surface's trimming curves.
 *
 * @module
 */

/** Parameters of the region for those of a patch, with derivatives. Needs `patches`. */
const MAPPING = `
vec4 patchWords(uint number, uint texel) {
  uint at = number * 4u + texel;
  return uintBitsToFloat(texelFetch(patches, ivec2(at & 2047u, at >> 11u), 0));
}

// Share of the parameter's range at x, and its derivative, for half the angle of an arc (above 0) or of a hyperbola (below 0), else for a parabola's bend.
vec2 parameterShare(float x, float halfAngle, float bend) {
  if (halfAngle == 0.0) return vec2(x + bend * x * (x - 1.0), 1.0 + bend * (2.0 * x - 1.0));
  float a = abs(halfAngle), y = 1.0 - x;
  bool arc = halfAngle > 0.0;
  float s = arc ? sin(a) : sinh(a), c = arc ? cos(a) : cosh(a);
  float p = (x - y) * s, q = (x * x + y * y) * c + 2.0 * x * y;
  float dp = 2.0 * s, dq = 2.0 * (x - y) * (c - 1.0);
  float angle = arc ? atan(p, q) : atanh(p / q);
  float square = arc ? p * p + q * q : q * q - p * p;
  return vec2(0.5 + 0.5 * angle / a, 0.5 * (dp * q - p * dq) / (square * a));
}

// Parameters of the surface at w; columns of d: derivatives along w.x and w.y.
vec2 surfaceParameters(uint patchNumber, bool revolution, vec2 w, out mat2 d) {
  vec4 low = patchWords(patchNumber, 1u), high = patchWords(patchNumber, 2u);
  if (revolution) {
    vec2 x = parameterShare(w.x, high.x, 0.0), y = parameterShare(w.y, high.y, high.z);
    vec2 size = low.yw - low.xz;
    d = mat2(size.x * x.y, 0.0, 0.0, size.y * y.y);
    return low.xz + size * vec2(x.x, y.x);
  }
  vec2 bottom = mix(low.xy, low.zw, w.x), top = mix(high.xy, high.zw, w.x);
  d = mat2(mix(low.zw - low.xy, high.zw - high.xy, w.y), top - bottom);
  return mix(bottom, top, w.y);
}
`;

/** Winding numbers, and the distance from the nearest curve. */
const WINDING = `
uniform usampler2D regionCells;
uniform sampler2D regionEntries;
uniform sampler2D regionSteps;
uniform sampler2D regionParts;
uniform sampler2D regionPoints;

vec4 fetchAt(sampler2D data, uint at) {
  return texelFetch(data, ivec2(at & 2047u, at >> 11u), 0);
}

// The rational curve of a part at t: value (w u, w v, w), and its derivative.
void partAt(uint first, int degree, float t, out vec3 h, out vec3 dh) {
  // Horner's scheme on the Bernstein form, for the two halves of de Casteljau's last step.
  float s = 1.0 - t, power = 1.0, choose = 1.0;
  vec3 low = fetchAt(regionPoints, first).xyz, high = fetchAt(regionPoints, first + 1u).xyz, next = high;
  int n = degree - 1;
  for (int k = 1; k <= n; k++) {
    power *= t;
    choose *= float(n + 1 - k) / float(k);
    low = low * s + power * choose * next;
    next = fetchAt(regionPoints, first + uint(k) + 1u).xyz;
    high = high * s + power * choose * next;
  }
  h = s * low + t * high;
  dh = float(degree) * (high - low);
}

// Whether the part, which is monotone, is right of p at its height. Newton's method, kept within what is left of [0, 1].
bool isRightOf(uint first, int degree, bool ascends, vec2 p) {
  float low = 0.0, high = 1.0, t = 0.5;
  vec3 h, dh;
  for (int k = 0; k < 24; k++) {
    partAt(first, degree, t, h, dh);
    float f = h.y - p.y * h.z;
    if ((f < 0.0) == ascends) low = t; else high = t;
    float slope = dh.y - p.y * dh.z;
    float next = t - f / slope;
    // Also where the slope is zero and next is no number.
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (abs(next - t) < 2e-7) break;
    t = next;
  }
  return h.x > p.x * h.z;
}

// Distance of p from the part, and the width of its border there, in pixels; 'toPixels' takes differences of p to pixels.
vec2 partDistance(uint first, int degree, vec2 width, vec2 p, mat2 toPixels) {
  vec3 h = fetchAt(regionPoints, first).xyz, dh;
  vec3 e = fetchAt(regionPoints, first + uint(degree)).xyz;
  vec2 begin = toPixels * (h.xy / h.z - p), chord = toPixels * (e.xy / e.z - p) - begin;
  float t = clamp(-dot(begin, chord) / max(dot(chord, chord), 1e-30), 0.0, 1.0);
  vec2 off = begin, along = vec2(1.0, 0.0);
  for (int k = 0; k < 5; k++) {
    partAt(first, degree, t, h, dh);
    vec2 c = h.xy / h.z;
    off = toPixels * (c - p);
    along = (dh.xy - c * dh.z) / h.z;
    vec2 tangent = toPixels * along;
    float next = clamp(t - dot(off, tangent) / max(dot(tangent, tangent), 1e-30), 0.0, 1.0);
    if (abs(next - t) < 1e-7) break;
    t = next;
  }
  // The border ends beside the curve, across it on the surface; what counts is how far that is from the curve in the picture.
  vec2 stretched = along * width.yx;
  vec2 side = toPixels * (width * vec2(-stretched.y, stretched.x) * inversesqrt(max(dot(stretched, stretched), 1e-36)));
  vec2 tangent = toPixels * along;
  float across = abs(side.x * tangent.y - side.y * tangent.x) * inversesqrt(max(dot(tangent, tangent), 1e-36));
  return vec2(length(off), across);
}

// Cells of a region: that of a point and others within a distance of it, about MOST_CELLS along each side, not all if there are more.
const int MOST_CELLS = 4;
struct Cells { ivec2 low, high, step; };
ivec2 cellAt(ivec2 cells, vec2 p) {
  return clamp(ivec2(clamp(p, 0.0, 1.0) * vec2(cells)), ivec2(0), cells - 1);
}
Cells cellsAround(ivec2 cells, vec2 p, vec2 near) {
  ivec2 low = cellAt(cells, p - near), own = cellAt(cells, p), high = cellAt(cells, p + near);
  ivec2 step = max((high - low + MOST_CELLS - 2) / (MOST_CELLS - 1), 1);
  return Cells(own - (own - low) / step * step, high, step);
}
uvec4 regionCell(uint firstCell, ivec2 cells, ivec2 cell) {
  uint number = firstCell + uint(cell.y * cells.x + cell.x);
  return texelFetch(regionCells, ivec2(number & 2047u, number >> 11u), 0);
}

// Whether a curve may be this near to p, along both axes.
bool isNearCurve(uint firstCell, ivec2 cells, vec2 p, vec2 near) {
  Cells around = cellsAround(cells, p, near);
  if (any(greaterThan(around.step, ivec2(1)))) return true;
  for (int y = around.low.y; y <= around.high.y; y += around.step.y) {
    for (int x = around.low.x; x <= around.high.x; x += around.step.x) {
      uvec4 facts = regionCell(firstCell, cells, ivec2(x, y));
      for (uint k = 0u; k < facts.y; k++) {
        uint part = uint(fetchAt(regionEntries, facts.x + k).x);
        vec4 box = fetchAt(regionParts, 2u * part);
        vec2 reach = fetchAt(regionParts, 2u * part + 1u).zw + near;
        if (all(lessThanEqual(box.xy - reach, p)) && all(lessThanEqual(p, box.zw + reach))) return true;
      }
    }
  }
  return false;
}

int windingNumber(uvec4 facts, vec2 p) {
  int winding = int(facts.w >> 16u) - 128;
  uint steps = facts.w & 65535u;
  for (uint k = 0u; k < steps; k++) {
    vec2 step = fetchAt(regionSteps, facts.z + k).xy;
    if (step.x > p.y) break;
    winding += int(step.y);
  }
  for (uint k = 0u; k < facts.y; k++) {
    vec4 entry = fetchAt(regionEntries, facts.x + k);
    if (!(entry.y <= p.y && p.y < entry.z)) continue;
    uint part = uint(entry.x);
    vec4 box = fetchAt(regionParts, 2u * part), more = fetchAt(regionParts, 2u * part + 1u);
    if (p.x < box.z && (p.x < box.x || isRightOf(uint(more.x), int(more.y), entry.w > 0.0, p))) winding += int(entry.w);
  }
  return winding;
}

// Distances in pixels from the curves, from their borders on the other side, and on this side, for points inside and outside; up to REACH.
const float REACH = 2.0;
void measure(uvec4 facts, vec2 p, mat2 toPixels, float least, inout float nearest, inout float inside, inout float outside) {
  for (uint k = 0u; k < facts.y; k++) {
    uint part = uint(fetchAt(regionEntries, facts.x + k).x);
    vec4 box = fetchAt(regionParts, 2u * part), more = fetchAt(regionParts, 2u * part + 1u);
    vec2 away = max(max(box.xy - more.zw - p, p - box.zw - more.zw), 0.0);
    if (dot(away, away) * least >= inside * inside) continue;
    vec2 border = partDistance(uint(more.x), int(more.y), more.zw, p, toPixels);
    nearest = min(nearest, border.x);
    inside = min(inside, border.x + border.y);
    outside = min(outside, border.x - border.y);
  }
}

// Distance in pixels from the border of what is kept, above 0 where 'at' is kept, and from the nearest curve; both up to REACH.
vec2 trimmingDistance(uint firstCell, ivec2 cells, vec2 at, mat2 toPixels, bool measured) {
  vec2 p = clamp(at, 0.0, 1.0);
  uvec4 facts = regionCell(firstCell, cells, cellAt(cells, p));
  // Surfaces that fill seams go on beyond their domains, where nothing is kept.
  bool isKept = windingNumber(facts, p) > 0 && (depths.w == 0.0 || p == at);
  if (!measured) return vec2(isKept ? REACH : -REACH, REACH);
  // The least stretch of toPixels: a bound from below on distances in pixels.
  float half2 = 0.5 * (dot(toPixels[0], toPixels[0]) + dot(toPixels[1], toPixels[1]));
  float det = determinant(toPixels);
  float least = max(0.0, half2 - sqrt(max(0.0, half2 * half2 - det * det)));
  float nearest = REACH, inside = REACH, outside = REACH;
  vec2 pixel = vec2(0.0);
  if (depths.w > 0.0) {
    // The cell of a point lists what is near it compared with the cell, which may be less than a pixel.
    mat2 back = inverse(toPixels);
    pixel = vec2(length(vec2(back[0].x, back[1].x)), length(vec2(back[0].y, back[1].y)));
  }
  // One call, since drivers copy functions to where they are called.
  Cells around = cellsAround(cells, at, pixel);
  for (int y = around.low.y; y <= around.high.y; y += around.step.y) {
    for (int x = around.low.x; x <= around.high.x; x += around.step.x) {
      measure(regionCell(firstCell, cells, ivec2(x, y)), at, toPixels, least, nearest, inside, outside);
    }
  }
  return vec2(isKept ? inside : -max(outside, -REACH), nearest);
}
`;

/** `surfaceParameters` alone. */
export const MAPPING_TEXT = MAPPING;

/** `surfaceParameters` and `trimmingDistance`. */
export const TRIMMING_TEXT = MAPPING + WINDING;

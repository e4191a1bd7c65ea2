/**
 * Shader text that evaluates rational Bézier patches of given degrees.
 *
 * Sums run over Bernstein polynomials, whose terms have one sign; derivatives are differences of sums of lower degree, as in de Casteljau's algorithm.
 *
 * @module
 */

/**
 * The degrees of a patch, and whether it is rational.
 * @typedef {{ degreeU: number, degreeV: number, rational: boolean }} Shape
 */

/** Control points, by number within the patch. */
const FETCH = `
uniform sampler2D points;
vec4 controlPoint(uint first, uint k) {
  uint at = first + k;
  return texelFetch(points, ivec2(at & 2047u, at >> 11u), 0);
}
`;

/** @param {number} n @param {number} k */
function binomial(n, k) {
  let value = 1;
  for (let i = 1; i <= k; i++) value = (value * (n + 1 - i)) / i;
  return value;
}

/**
 * Statements that define `${name}0` to `${name}n`: the Bernstein polynomials of a degree at `t`, with `s` = 1 - t.
 * @param {string} name
 * @param {number} degree
 * @param {string} t
 * @param {string} s
 */
function bernstein(name, degree, t, s) {
  const power = (/** @type {string} */ x, /** @type {number} */ n) => Array(n).fill(x).join(" * ");
  return Array.from({ length: degree + 1 }, (_, k) => {
    const factors = [`${binomial(degree, k)}.0`, power(t, k), power(s, degree - k)].filter((text) => text !== "");
    return `  float ${name}${k} = ${factors.join(" * ")};`;
  }).join("\n");
}

/**
 * A sum whose terms pair the first with the last, so that it comes out alike when a curve is read backwards.
 * @param {string[]} terms
 */
function symmetricSum(terms) {
  const pairs = [];
  for (let k = 0; k < terms.length / 2; k++) {
    const last = terms.length - 1 - k;
    pairs.push(k === last ? terms[k] : `(${terms[k]} + ${terms[last]})`);
  }
  return pairs.join(" + ");
}

/**
 * `vec3 position(uint first, vec2 w)`: the point alone, for vertices. Neighbours that share a border get the same point there, up to the rounding of products
 * that a compiler fuses into sums.
 * @param {Shape} shape
 */
export function positionText({ degreeU, degreeV, rational }) {
  const rows = [];
  for (let i = 0; i <= degreeU; i++) {
    const terms = Array.from(
      { length: degreeV + 1 },
      (_, j) => `v${j} * controlPoint(first, ${i * (degreeV + 1) + j}u)`,
    );
    rows.push(`  vec4 row${i} = ${symmetricSum(terms)};`);
  }
  const terms = Array.from({ length: degreeU + 1 }, (_, i) => `u${i} * row${i}`);
  return `${FETCH}
vec3 position(uint first, vec2 w) {
  float su = 1.0 - w.x, sv = 1.0 - w.y;
${bernstein("u", degreeU, "w.x", "su")}
${bernstein("v", degreeV, "w.y", "sv")}
${rows.join("\n")}
  vec4 sum = ${symmetricSum(terms)};
  return sum.xyz${rational ? " / sum.w" : ""};
}
`;
}

/**
 * `Jet evaluate(uint first, vec2 w)`: point and first derivatives `s, su, sv`; with `second` also `suu, suv, svv`.
 * @param {Shape} shape
 * @param {boolean} second
 */
export function jetText({ degreeU, degreeV, rational }, second) {
  const orderU = Math.min(second ? 2 : 1, degreeU);
  const orderV = Math.min(second ? 2 : 1, degreeV);
  const type = rational ? "vec4" : "vec3";
  const lines = [];
  for (let r = 0; r <= orderU; r++) for (let c = 0; c <= orderV; c++) lines.push(`  ${type} n${r}${c} = ${type}(0.0);`);
  for (let i = 0; i <= degreeU; i++) lines.push(rowText(i, degreeU, degreeV, orderU, orderV, rational));
  return `${FETCH}
struct Jet { vec3 s, su, sv${second ? ", suu, suv, svv" : ""}; };
Jet evaluate(uint first, vec2 w) {
  float su = 1.0 - w.x, sv = 1.0 - w.y;
${bernstein("u", degreeU - orderU, "w.x", "su")}
${bernstein("v", degreeV - orderV, "w.y", "sv")}
${lines.join("\n")}
${derivativesText(type, degreeU, degreeV, orderU, orderV, second)}
  Jet jet;
${rational ? quotientText(second) : polynomialText(second)}
  return jet;
}
`;
}

/**
 * Adds a row of control points to the net that is left after all steps of de Casteljau's algorithm but the last `orderU`, `orderV`.
 * @param {number} i
 * @param {number} degreeU
 * @param {number} degreeV
 * @param {number} orderU
 * @param {number} orderV
 * @param {boolean} rational
 */
function rowText(i, degreeU, degreeV, orderU, orderV, rational) {
  const type = rational ? "vec4" : "vec3";
  const lines = [];
  for (let j = 0; j <= degreeV; j++) {
    lines.push(`    ${type} p${j} = controlPoint(first, ${i * (degreeV + 1) + j}u)${rational ? "" : ".xyz"};`);
  }
  for (let c = 0; c <= orderV; c++) {
    const terms = Array.from({ length: degreeV - orderV + 1 }, (_, j) => `v${j} * p${j + c}`);
    lines.push(`    ${type} row${c} = ${terms.join(" + ")};`);
  }
  for (let r = 0; r <= orderU; r++) {
    if (i - r < 0 || i - r > degreeU - orderU) continue;
    for (let c = 0; c <= orderV; c++) lines.push(`    n${r}${c} += u${i - r} * row${c};`);
  }
  return `  {\n${lines.join("\n")}\n  }`;
}

/**
 * From the last net to `h, hu, hv` and, with `second`, `huu, huv, hvv`.
 * @param {string} type
 * @param {number} degreeU
 * @param {number} degreeV
 * @param {number} orderU
 * @param {number} orderV
 * @param {boolean} second
 */
function derivativesText(type, degreeU, degreeV, orderU, orderV, second) {
  const lines = [];
  // Along u for every column: value a, derivative b, second derivative c.
  for (let c = 0; c <= orderV; c++) {
    const [n0, n1, n2] = [`n0${c}`, `n1${c}`, `n2${c}`];
    if (orderU === 1) {
      lines.push(`  ${type} a${c} = su * ${n0} + w.x * ${n1}, b${c} = ${degreeU}.0 * (${n1} - ${n0});`);
      if (second) lines.push(`  ${type} c${c} = ${type}(0.0);`);
    } else {
      lines.push(`  ${type} l${c} = su * ${n0} + w.x * ${n1}, r${c} = su * ${n1} + w.x * ${n2};`);
      lines.push(`  ${type} a${c} = su * l${c} + w.x * r${c}, b${c} = ${degreeU}.0 * (r${c} - l${c});`);
      lines.push(`  ${type} c${c} = ${degreeU * (degreeU - 1)}.0 * ((${n2} - ${n1}) - (${n1} - ${n0}));`);
    }
  }
  const along = (/** @type {string} */ name, /** @type {string} */ value, /** @type {string | null} */ derivative) => {
    if (orderV === 1) {
      lines.push(`  ${type} ${value} = sv * ${name}0 + w.y * ${name}1;`);
      if (derivative) lines.push(`  ${type} ${derivative} = ${degreeV}.0 * (${name}1 - ${name}0);`);
      return;
    }
    lines.push(`  ${type} ${name}l = sv * ${name}0 + w.y * ${name}1, ${name}r = sv * ${name}1 + w.y * ${name}2;`);
    lines.push(`  ${type} ${value} = sv * ${name}l + w.y * ${name}r;`);
    if (derivative) lines.push(`  ${type} ${derivative} = ${degreeV}.0 * (${name}r - ${name}l);`);
  };
  along("a", "h", "hv");
  along("b", "hu", second ? "huv" : null);
  if (second) {
    along("c", "huu", null);
    const bend = orderV === 1 ? `${type}(0.0)` : `${degreeV * (degreeV - 1)}.0 * ((a2 - a1) - (a1 - a0))`;
    lines.push(`  ${type} hvv = ${bend};`);
  }
  return lines.join("\n");
}

/** @param {boolean} second */
function polynomialText(second) {
  const names = second ? ["", "u", "v", "uu", "uv", "vv"] : ["", "u", "v"];
  return names.map((name) => `  jet.s${name} = h${name};`).join("\n");
}

/** The quotient rule. @param {boolean} second */
function quotientText(second) {
  const first = `  jet.s = h.xyz / h.w;
  jet.su = (hu.xyz - hu.w * jet.s) / h.w;
  jet.sv = (hv.xyz - hv.w * jet.s) / h.w;`;
  if (!second) return first;
  return `${first}
  jet.suu = (huu.xyz - 2.0 * hu.w * jet.su - huu.w * jet.s) / h.w;
  jet.suv = (huv.xyz - hu.w * jet.sv - hv.w * jet.su - huv.w * jet.s) / h.w;
  jet.svv = (hvv.xyz - 2.0 * hv.w * jet.sv - hvv.w * jet.s) / h.w;`;
}

/**
 * False colours, for shaders and for legends: sRGB, 0 to 255, at equal steps with straight lines between.
 *
 * @module
 */

/** @typedef {[red: number, green: number, blue: number]} Colour */

/** Blue, grey, red: the ends and the middle of @moreland2009. @type {Colour[]} */
export const DIVERGING = [
  [59, 76, 192],
  [221, 221, 221],
  [180, 4, 38],
];

/** Viridis (@smith2015). @type {Colour[]} */
export const VIRIDIS = [
  [68, 1, 84],
  [72, 40, 120],
  [62, 73, 137],
  [49, 104, 142],
  [38, 130, 142],
  [53, 183, 121],
  [109, 205, 89],
  [180, 222, 44],
  [253, 231, 37],
];

/**
 * A scale of colours as a background, from left to right.
 * @param {Colour[]} colours
 */
export function gradient(colours) {
  return `linear-gradient(to right, ${colours.map((colour) => `rgb(${colour.join(" ")})`).join(", ")})`;
}

/**
 * A scale of colours as an expression of a shader: an array of `vec3`.
 * @param {Colour[]} colours
 */
export function shaderArray(colours) {
  return `vec3[${colours.length}](${colours.map((colour) => `vec3(${colour.join(", ")})`).join(", ")})`;
}

/**
 * Data textures of a model: control points, patches, regions, objects, materials, maps.
 *
 * @module
 */

import { findBorders } from "./patch_bounds.js";
import { UNITS } from "./programs.js";
import { SCRATCH_UNIT, DataTexture } from "./data_texture.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("../model.js").Material} Material */

/** Bits of an object's facts, as in \`OBJECT_TEXT\`. */
const REVERSED = 1;
const REVOLUTION = 2;
const MAPPED = 4;
const SHARED = 8;
const OUTSIDE_FRONT = 16;
const OUTSIDE_BACK = 32;

export class SceneTables {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Model} model
   */
  constructor(gl, model) {
    const { blocks } = model;
    this.gl = gl;
    /** @type {[keyof typeof UNITS, DataTexture][]} */
    this.tables = [];
    /** @param {keyof typeof UNITS} name @param {"RGBA32F" | "RG32F" | "RGBA32UI"} format @param {Float32Array | Uint32Array} data */
    const add = (name, format, data) => {
      const table = new DataTexture(gl, format);
      table.write(data);
      this.tables.push([name, table]);
    };
    add("points", "RGBA32F", blocks.points);
    add("patches", "RGBA32UI", patchRows(model));
    add("objectFacts", "RGBA32UI", objectRows(model));
    add("materials", "RGBA32F", materialRows(model.materials));
    add("regionCells", "RGBA32UI", blocks.regionCells);
    add("regionEntries", "RGBA32F", blocks.regionEntries);
    add("regionSteps", "RG32F", blocks.regionSteps);
    add("regionParts", "RGBA32F", blocks.regionParts);
    add("regionPoints", "RGBA32F", blocks.regionPoints);
    this.maps = model.maps.map((map, i) => mapTexture(gl, map, model.mapValues[i]));
  }

  /** Makes them the textures that programs read. */
  bind() {
    for (const [name, table] of this.tables) table.bind(UNITS[name]);
  }

  delete() {
    for (const [, table] of this.tables) table.delete();
    for (const map of this.maps) this.gl.deleteTexture(map.texture);
  }
}

/** The patches with their borders in the fourth word. @param {Model} model */
function patchRows(model) {
  const rows = model.blocks.patches.slice();
  findBorders(model).forEach((bits, patch) => (rows[patch * 16 + 3] = bits));
  return rows;
}

/** @param {Model} model */
function objectRows(model) {
  const rows = new Uint32Array(model.objects.length * 8);
  model.objects.forEach((object, i) => {
    const surface = model.surfaces[object.surface];
    let bits = object.reversed ? REVERSED : 0;
    if (object.map !== null) bits |= MAPPED;
    if (object.shared) bits |= SHARED;
    if (object.outside) bits |= object.outside === "front" ? OUTSIDE_FRONT : OUTSIDE_BACK;
    rows.set([object.material, 0, 0, 0, object.leaf, bits], i * 8);
    if (surface.kind !== "patches") return;
    if (surface.mapping === "revolution") rows[i * 8 + 5] |= REVOLUTION;
    if (surface.region === null) return;
    const region = model.regions[surface.region];
    rows.set([region.firstCell, region.cells[0] | (region.cells[1] << 16)], i * 8 + 1);
  });
  return rows;
}

/** @param {Material[]} materials */
function materialRows(materials) {
  const rows = new Float32Array(materials.length * 16);
  materials.forEach((material, i) => {
    const { base, metallic, specular, roughness, emission, opacity, exponent, kind } = material;
    const last = [exponent ?? -1, kind === "dielectric" ? 1 : 0, 0, 0];
    rows.set([...base, metallic, ...specular, roughness, ...emission, opacity, ...last], i * 16);
  });
  return rows;
}

/**
 * A map as a texture; `falseColours`: its values are numbers to be read, not light to be seen; `toBack`: offset of the values of the back along y.
 * @typedef {{ texture: WebGLTexture, largest: number, falseColours: boolean, toBack: number }} MapTexture
 */

/**
 * @param {WebGL2RenderingContext} gl
 * @param {import("../model.js").LightMap} map
 * @param {Float32Array} values one a texel, or red, green and blue
 * @returns {MapTexture}
 */
function mapTexture(gl, map, values) {
  const texture = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + SCRATCH_UNIT);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  const falseColours = map.channels === 1;
  if (falseColours) {
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, map.width, map.height, 0, gl.RED, gl.FLOAT, values);
  } else {
    // Shares of the largest value as half floats, because those can be filtered everywhere and would end at 65504.
    const shares = values.map((x) => x / (map.largest || 1));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16F, map.width, map.height, 0, gl.RGB, gl.FLOAT, shares);
  }
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, filter, falseColours ? gl.NEAREST : gl.LINEAR);
  for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
  return { texture, largest: map.largest, falseColours, toBack: map.sides > 1 ? 0.5 : 0 };
}

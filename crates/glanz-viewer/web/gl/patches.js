/**
 * The patches of a model: which are in sight, how fine their grids are, and drawing them.
 *
 * @module
 */

import { largestStretch } from "../linear.js";
import { patchHeader } from "../model.js";
import { Grids } from "./grids.js";
import { LARGEST_GRID, gridLevels, lengthLevel, sideLevel } from "./grid_levels.js";
import { SIDE, SIDES, STRIDE, boundPatches } from "./patch_bounds.js";
import { INSTANCE_WORDS, TOLERANCE, patchFragmentText, patchVertexText } from "./patch_shader.js";
import { Subpatches } from "./subpatches.js";
import { UNITS } from "./programs.js";

/** @typedef {import("../model.js").Model} Model */
/** @typedef {import("./frame.js").Frame} Frame */
/** @typedef {import("./shading_modes.js").ShadingMode} ShadingMode */
/** @typedef {import("./programs.js").Program} Program */
/** @typedef {import("./programs.js").Programs} Programs */
/** @typedef {import("./scene_tables.js").MapTexture} MapTexture */
/** @typedef {import("./evaluation.js").Shape} Shape */

/** A side that is smaller than this share of its patch is a point. */
const POINT = 1e-6;

/** Grids of one kind are drawn from front to back in this many steps of depth. */
const STEPS = 16;

/** Grids of 2^10 cells and more are split into subpatches if the patch is only partly in view. */
const LARGEST_WHOLE = 10;

/** @typedef {{ patches: number, quads: number, triangles: number, draws: number }} FrameStatistics */

/**
 * Name and text of the program that draws patches of a shape.
 * @param {Shape} shape
 * @param {boolean} trimmed
 * @param {ShadingMode} mode
 * @returns {[string, () => { vertex: string, fragment: string }]}
 */
function patchProgram(shape, trimmed, mode) {
  const { degreeU, degreeV, rational } = shape;
  const name = `patch ${degreeU} ${degreeV}${rational ? " rational" : ""}${trimmed ? " trimmed" : ""} ${mode}`;
  return [name, () => ({ vertex: patchVertexText(shape), fragment: patchFragmentText(shape, trimmed, mode) })];
}

/** Shapes of the faces of most CAD files: planes, cylinders and cones, spheres and tori, cubic splines. @type {Shape[]} */
const CAD_SHAPES = [
  { degreeU: 1, degreeV: 1, rational: false },
  { degreeU: 2, degreeV: 1, rational: true },
  { degreeU: 1, degreeV: 2, rational: true },
  { degreeU: 2, degreeV: 2, rational: true },
  { degreeU: 3, degreeV: 3, rational: false },
];

/** Begins to compile the programs for most CAD files. @param {Programs} programs @param {ShadingMode} mode */
export function prepareForCad(programs, mode) {
  // Else each would be waited for.
  if (!programs.parallel) return;
  for (const shape of CAD_SHAPES) programs.get(...patchProgram(shape, true, mode), false);
}

export class Patches {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Model} model
   * @param {MapTexture[]} maps
   */
  constructor(gl, model, maps) {
    this.gl = gl;
    this.model = model;
    this.maps = maps;
    this.grids = new Grids(gl);
    this.patchBounds = boundPatches(model);
    this.subpatches = new Subpatches(model, this.patchBounds);
    /** How illuminances are shown. @type {import("./renderer.js").LuxDisplay | null} */
    this.lux = null;
    /** Classes of patches that share a program and textures. @type {{ shape: Shape, trimmed: boolean, map: number | null }[]} */
    this.classes = [];
    this.classOf = this.classify();
    this.stretch = model.objects.map((object) => largestStretch(object.toWorld));
    /** Number of grids in sight, and of what: `INSTANCE_WORDS` words, class and level, step of depth. */
    this.count = 0;
    this.words = new Uint32Array(1024 * INSTANCE_WORDS);
    this.kinds = new Uint32Array(1024);
    this.depths = new Float32Array(1024);
    this.sorted = new Uint32Array(1024 * INSTANCE_WORDS);
    this.starts = new Uint32Array(this.classes.length * 64 * STEPS + 1);
  }

  /** The class of every patch. Objects that show a map have patches of their own. */
  classify() {
    const { model } = this;
    const classOf = new Uint16Array(model.blocks.patches.length / 16);
    /** @type {Map<string, number>} */
    const numbers = new Map();
    /** @type {Map<number, number>} */
    const mapOf = new Map();
    for (const { surface, map } of model.objects) if (map !== null) mapOf.set(surface, map);
    model.surfaces.forEach((surface, index) => {
      if (surface.kind !== "patches") return;
      const map = mapOf.get(index) ?? null;
      const trimmed = surface.region !== null;
      for (let patch = surface.first; patch < surface.first + surface.count; patch++) {
        const { degreeU, degreeV, rational } = patchHeader(model, patch);
        const key = `${degreeU} ${degreeV} ${rational} ${trimmed} ${map}`;
        let number = numbers.get(key);
        if (number === undefined) {
          number = this.classes.length;
          numbers.set(key, number);
          this.classes.push({ shape: { degreeU, degreeV, rational }, trimmed, map });
        }
        classOf[patch] = number;
      }
    });
    return classOf;
  }

  /**
   * Finds the visible patches and the resolution of their grids.
   * @param {Frame} frame
   * @param {Float64Array} places of objects, twelve numbers each
   * @param {number[]} objects the numbers of those to be drawn
   */
  cull(frame, places, objects) {
    this.count = 0;
    for (const number of objects) {
      const surface = this.model.surfaces[this.model.objects[number].surface];
      if (surface.kind !== "patches") continue;
      for (let patch = surface.first; patch < surface.first + surface.count; patch++) {
        this.cullPatch(frame, places, number, patch);
      }
    }
    this.sort();
    this.grids.write(this.sorted, this.count * INSTANCE_WORDS);
  }

  /** @param {Frame} frame @param {Float64Array} places @param {number} object @param {number} patch */
  cullPatch(frame, places, object, patch) {
    const { patchBounds: measures, subpatches } = this;
    const at = patch * STRIDE;
    const stretch = this.stretch[object];
    const place = 12 * object;
    const radius = measures[at + 3] * stretch;
    const x = measures[at];
    const y = measures[at + 1];
    const z = measures[at + 2];
    const cx = places[place] * x + places[place + 3] * y + places[place + 6] * z + places[place + 9];
    const cy = places[place + 1] * x + places[place + 4] * y + places[place + 7] * z + places[place + 10];
    const cz = places[place + 2] * x + places[place + 5] * y + places[place + 8] * z + places[place + 11];
    if (!frame.sees(cx, cy, cz, radius)) return;
    let near = cz - radius;
    let far = cz + radius;
    let least = near;
    if (frame.a === 1 && near < radius) {
      // So close that parts of the patch differ: the nearest part in sight decides.
      const range = subpatches.depthRange(frame, places, object, stretch, patch);
      if (range === null) return;
      [near, far, least] = range;
    }
    frame.include(near, far);
    const resolution = (frame.pixelsPerMetre(least) * stretch) / TOLERANCE;
    const side0 = this.levelOfSide(frame, places, object, at + SIDES, stretch);
    const side1 = this.levelOfSide(frame, places, object, at + SIDES + SIDE, stretch);
    const side2 = this.levelOfSide(frame, places, object, at + SIDES + 2 * SIDE, stretch);
    const side3 = this.levelOfSide(frame, places, object, at + SIDES + 3 * SIDE, stretch);
    const levels = gridLevels(
      measures[at + 4],
      measures[at + 5],
      measures[at + 6],
      resolution,
      Math.max(side0, side1),
      Math.max(side2, side3),
    );
    const sides =
      (this.packed(at, 0, side0) << 8) |
      (this.packed(at, 1, side1) << 12) |
      (this.packed(at, 2, side2) << 16) |
      (this.packed(at, 3, side3) << 20);
    const levelU = levels & 15;
    const levelV = levels >> 4;
    const small = levelU + levelV < LARGEST_WHOLE || frame.contains(cx, cy, cz, radius);
    if (small && levelU <= LARGEST_GRID && levelV <= LARGEST_GRID) {
      this.add(object, patch, 0, levels | sides, levelU, levelV, near);
    } else {
      this.addSubpatches(frame, places, object, patch, levelU, levelV, sides);
    }
  }

  /**
   * Level of a side, computed from data that its neighbour shares.
   * @param {Frame} frame
   * @param {Float64Array} places
   * @param {number} object
   * @param {number} at where the side's measures begin
   * @param {number} stretch
   */
  levelOfSide(frame, places, object, at, stretch) {
    const { patchBounds: measures } = this;
    const place = 12 * object;
    const radius = measures[at + 3] * stretch;
    const x = measures[at];
    const y = measures[at + 1];
    const z = measures[at + 2];
    const cx = places[place] * x + places[place + 3] * y + places[place + 6] * z + places[place + 9];
    const cy = places[place + 1] * x + places[place + 4] * y + places[place + 7] * z + places[place + 10];
    const cz = places[place + 2] * x + places[place + 5] * y + places[place + 8] * z + places[place + 11];
    if (!frame.sees(cx, cy, cz, radius)) return 0;
    const nearest = frame.a === 1 ? Math.max(cz - radius, 0.05 * radius) : 1;
    const scale = frame.pixelsPerMetre(nearest);
    return Math.max(sideLevel(measures[at + 4], (scale * stretch) / TOLERANCE), lengthLevel(2 * radius * scale));
  }

  /**
   * The level of a side as the grid is told. One that is a point, where it may be passed in any parameter, leaves the grid its own: else triangles there would say
   * nothing about the parameter along it.
   * @param {number} at where the patch's measures begin
   * @param {number} side
   * @param {number} level
   */
  packed(at, side, level) {
    return this.patchBounds[at + SIDES + side * SIDE + 3] > POINT * this.patchBounds[at + 3] ? level : 15;
  }

  /**
   * Draws the visible subpatches of a fine grid; on a coarser grid if there are too many.
   * @param {Frame} frame
   * @param {Float64Array} places
   * @param {number} object
   * @param {number} patch
   * @param {number} levelU
   * @param {number} levelV
   * @param {number} sides
   */
  addSubpatches(frame, places, object, patch, levelU, levelV, sides) {
    const { subpatches } = this;
    while (!subpatches.inSight(frame, places, object, this.stretch[object], patch, levelU, levelV, sides)) {
      if (levelU >= levelV) levelU -= 1;
      else levelV -= 1;
    }
    for (let k = 0; k < subpatches.found; k++) {
      const { [4 * k]: cellU, [4 * k + 1]: cellV, [4 * k + 2]: gridU, [4 * k + 3]: gridV } = subpatches.parts;
      const first = (cellU | (cellV << 16)) >>> 0;
      this.add(object, patch, first, levelU | (levelV << 4) | sides, gridU, gridV, subpatches.depths[k]);
    }
  }

  /**
   * @param {number} object
   * @param {number} patch
   * @param {number} first cell
   * @param {number} levels
   * @param {number} gridU level of what is drawn of the grid
   * @param {number} gridV
   * @param {number} depth
   */
  add(object, patch, first, levels, gridU, gridV, depth) {
    if (this.count === this.kinds.length) this.grow();
    const at = this.count * INSTANCE_WORDS;
    this.words[at] = patch;
    this.words[at + 1] = object;
    this.words[at + 2] = first;
    this.words[at + 3] = levels;
    this.kinds[this.count] = this.classOf[patch] * 64 + gridU * 8 + gridV;
    this.depths[this.count] = depth;
    this.count += 1;
  }

  grow() {
    const double = (/** @type {Uint32Array} */ old) => {
      const longer = new Uint32Array(2 * old.length);
      longer.set(old);
      return longer;
    };
    this.words = double(this.words);
    this.kinds = double(this.kinds);
    this.sorted = new Uint32Array(this.words.length);
    const depths = new Float32Array(2 * this.depths.length);
    depths.set(this.depths);
    this.depths = depths;
  }

  /** Brings grids of a kind together, near ones first. */
  sort() {
    const { starts, kinds, depths, count } = this;
    let near = Infinity;
    let far = -Infinity;
    for (let k = 0; k < count; k++) {
      near = Math.min(near, depths[k]);
      far = Math.max(far, depths[k]);
    }
    const steps = far > near ? (STEPS * 0.999) / (far - near) : 0;
    starts.fill(0);
    for (let k = 0; k < count; k++) {
      kinds[k] = kinds[k] * STEPS + Math.floor((depths[k] - near) * steps);
      starts[kinds[k] + 1] += 1;
    }
    for (let k = 1; k < starts.length; k++) starts[k] += starts[k - 1];
    // While sorting, a start moves on to the next free place, which in the end is where the next kind begins.
    for (let k = 0; k < count; k++) {
      const to = starts[kinds[k]]++ * INSTANCE_WORDS;
      const from = k * INSTANCE_WORDS;
      for (let word = 0; word < INSTANCE_WORDS; word++) this.sorted[to + word] = this.words[from + word];
    }
  }

  /** Begins to compile all programs of a mode. @param {Programs} programs @param {ShadingMode} mode */
  prepare(programs, mode) {
    for (const { shape, trimmed } of this.classes) programs.get(...patchProgram(shape, trimmed, mode), false);
  }

  /**
   * Draws the result of `cull`.
   * @param {Programs} programs
   * @param {ShadingMode} mode
   * @param {boolean} wait for programs that are being compiled
   * @param {FrameStatistics} statistics
   * @param {boolean} trimmedOnly
   */
  draw(programs, mode, wait, statistics, trimmedOnly = false) {
    let first = 0;
    for (let kind = 0; kind < this.classes.length * 64; kind++) {
      const end = this.starts[kind * STEPS + STEPS - 1];
      const count = end - first;
      if (count === 0) continue;
      const gridU = (kind >> 3) & 7;
      const gridV = kind & 7;
      const { shape, trimmed, map } = this.classes[kind >> 6];
      if (trimmedOnly && !trimmed) {
        first = end;
        continue;
      }
      const program = programs.get(...patchProgram(shape, trimmed, mode), wait);
      if (program) {
        program.use();
        if (mode === "material" && map !== null) this.bindMap(program, this.maps[map]);
        this.grids.draw(gridU, gridV, first, count);
        const quads = count * 2 ** (gridU + gridV);
        statistics.patches += count;
        statistics.quads += quads;
        statistics.triangles += 2 * quads;
        statistics.draws += 1;
      }
      first = end;
    }
  }

  /** @param {Program} program @param {MapTexture} map */
  bindMap(program, { texture, largest, falseColours, toBack }) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + UNITS.mapValues);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform3f(program.place("mapScale"), largest, falseColours ? 1 : 0, toBack);
    if (!falseColours || !this.lux) return;
    const { low, high, logarithmic } = this.lux.scale;
    const [first, last] = logarithmic ? [Math.log(low), Math.log(high)] : [low, high];
    gl.uniform3f(program.place("luxScale"), first, last, logarithmic ? 1 : 0);
    const { levels } = this.lux;
    gl.uniform1i(program.place("isoluxCount"), levels.length);
    if (levels.length > 0) gl.uniform1fv(program.place("isoluxLevels"), levels);
  }

  delete() {
    this.grids.delete();
  }
}

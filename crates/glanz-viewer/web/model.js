/**
 * The model of a scene, from the bytes that the server sends (docs/viewer.md).
 *
 * @module
 */

/** @typedef {import("./linear.js").Vector} Vector */

/**
 * @typedef {{ kind: "perspective" | "orthographic", position: Vector, right: Vector, up: Vector, forward: Vector,
 *   fieldOfView: number, height: number, distance: number }} Camera
 * @typedef {{ kind: "patches", first: number, count: number, origin: Vector, region: number | null,
 *   mapping: "patch" | "revolution" }} PatchSurface
 * @typedef {{ kind: "mesh", firstVertex: number, vertices: number, firstIndex: number, indices: number,
 *   origin: Vector }} MeshSurface
 * @typedef {{ kind: "algebraic", terms: [number, number, number, number][], min: Vector, max: Vector }} AlgebraicSurface
 * @typedef {PatchSurface | MeshSurface | AlgebraicSurface} Surface
 * @typedef {{ cells: [number, number], firstCell: number, min: [number, number], max: [number, number] }} Region
 * @typedef {{ surface: number, toWorld: number[], material: number, leaf: number, kind: string, reversed: boolean,
 *   light: boolean, shared: boolean, map: number | null, outside: "front" | "back" | null }} SceneObject
 * @typedef {{ name: string, kind: string, base: Vector, metallic: number, roughness: number, opacity: number,
 *   specular: Vector, exponent: number | null, emission: Vector }} Material
 * @typedef {{ kind: "point" | "spot" | "distant" | "area" | "infinite", position: Vector, direction: Vector,
 *   intensity: Vector, cosInner: number, cosOuter: number, range: number | null }} Light
 * @typedef {{ name: string, kind: "group" | "shape", leaf?: number, what?: string, place?: string,
 *   children?: TreeNode[] }} TreeNode
 * @typedef {{ first: number, count: number, kind: "line" | "circle" | "ellipse" | "spline", radii: number[], length: number,
 *   angle: number, shapes: number[] }} Edge
 * @typedef {{ toWorld: number[], first: number, count: number, firstLeaf: number }} EdgeCopy
 * @typedef {{ unit: string, block: string, width: number, height: number, sides: number, channels: 1 | 3, largest: number }} LightMap
 */

/**
 * The blocks as typed arrays over the received bytes; those that a model lacks are empty.
 * @typedef {object} Blocks
 * @property {Uint32Array} patches 16 words each
 * @property {Float32Array} points homogeneous control points, 4 each
 * @property {Uint32Array} regionCells 4 each
 * @property {Float32Array} regionEntries 4 each
 * @property {Float32Array} regionSteps 2 each
 * @property {Float32Array} regionParts 8 each
 * @property {Float32Array} regionPoints 4 each
 * @property {Float32Array} positions 3 each
 * @property {Float32Array} normals 3 each
 * @property {Uint32Array} indices 3 each triangle
 * @property {Float32Array} edgePoints 3 each
 * @property {Float32Array} luxCells 2 each
 */

/**
 * @typedef {object} Model
 * @property {string} name
 * @property {Vector} up
 * @property {[Vector, Vector]} bounds
 * @property {Camera} camera
 * @property {number} aspect width over height of the picture that the scene asks for
 * @property {Surface[]} surfaces
 * @property {Region[]} regions
 * @property {SceneObject[]} objects
 * @property {Material[]} materials
 * @property {Light[]} lights
 * @property {TreeNode} tree
 * @property {number | null} lengthUnit metres, of CAD files
 * @property {Edge[]} edges
 * @property {EdgeCopy[]} edgeCopies
 * @property {LightMap[]} maps
 * @property {LightMap[]} shownMaps those that objects show
 * @property {boolean} hasWalls whether objects have outer sides
 * @property {string[]} notes
 * @property {Blocks} blocks
 * @property {Float32Array[]} mapValues values of the maps, in the order of `maps`, `channels` each
 */

const MAGIC = "GLANZVW1";

/** Bytes before the JSON text. */
const HEAD = 16;

/** Number of `u32` or `f32` that make one item of a block. */
const WORDS = {
  patches: 16,
  points: 4,
  regionCells: 4,
  regionEntries: 4,
  regionSteps: 2,
  regionParts: 8,
  regionPoints: 4,
  positions: 3,
  normals: 3,
  indices: 3,
  edgePoints: 3,
  luxCells: 2,
};

/** Most bytes of a model; the graphics card takes about as many again. A browser that runs out of memory ends the page without a word. */
const MOST_BYTES = 2 ** 30;

/**
 * The model that the server has at a path.
 * @param {string} path
 * @returns {Promise<Model>}
 * @throws {Error} that says why there is none
 */
export async function fetchModel(path) {
  const leave = new AbortController();
  const response = await fetch(path, { signal: leave.signal });
  if (!response.ok) throw new Error(`The server answered with ${response.status} ${response.statusText}.`);
  const size = Number(response.headers.get("content-length") ?? 0);
  if (size > MOST_BYTES) {
    leave.abort();
    const [needed, most] = [size, MOST_BYTES].map((bytes) => (bytes / 1e9).toFixed(2));
    throw new Error(`The model has ${needed} GB, and a page takes ${most} GB. Open a part of the scene.`);
  }
  return decodeModel(await response.arrayBuffer());
}

/**
 * The model in these bytes.
 * @param {ArrayBuffer} bytes
 * @returns {Model}
 * @throws {Error} that says what does not hold, if the bytes are no model
 */
export function decodeModel(bytes) {
  const { head, start } = readHead(bytes);
  /** @param {string} name @param {number} words */
  const block = (name, words) => blockBytes(bytes, head.blocks ?? {}, start, name, words * 4);
  /** @param {keyof typeof WORDS} name */
  const floats = (name) => new Float32Array(...block(name, WORDS[name]));
  /** @param {keyof typeof WORDS} name */
  const integers = (name) => new Uint32Array(...block(name, WORDS[name]));
  const blocks = {
    patches: integers("patches"),
    points: floats("points"),
    regionCells: integers("regionCells"),
    regionEntries: floats("regionEntries"),
    regionSteps: floats("regionSteps"),
    regionParts: floats("regionParts"),
    regionPoints: floats("regionPoints"),
    positions: floats("positions"),
    normals: floats("normals"),
    indices: integers("indices"),
    edgePoints: floats("edgePoints"),
    luxCells: floats("luxCells"),
  };
  /** @type {LightMap[]} */
  const maps = head.maps ?? [];
  const mapValues = maps.map(({ block: name, channels }, i) => {
    if (channels !== 1 && channels !== 3) throw damaged(`map ${i} has ${channels} channels, not 1 or 3`);
    return new Float32Array(...block(name, channels));
  });
  const { notes = [], edges = [], edgeCopies = [] } = head;
  /** @type {SceneObject[]} */
  const objects = head.objects ?? [];
  const hasWalls = objects.some(({ outside }) => Boolean(outside));
  const shown = new Set(objects.map(({ map }) => map));
  const shownMaps = maps.filter((_, i) => shown.has(i));
  const model = { ...head, maps, shownMaps, notes, edges, edgeCopies, hasWalls, blocks, mapValues };
  checkReferences(model);
  return model;
}

/** @param {ArrayBuffer} bytes @returns {{ head: any, start: number }} the JSON value, and where blocks begin */
function readHead(bytes) {
  if (bytes.byteLength < HEAD) throw damaged(`${bytes.byteLength} bytes are too few`);
  const magic = new TextDecoder().decode(new Uint8Array(bytes, 0, 8));
  if (magic !== MAGIC) throw damaged(`it begins with "${magic}", not "${MAGIC}"; reload the page`);
  const length = new DataView(bytes).getUint32(8, true);
  if (HEAD + length > bytes.byteLength) throw damaged(`its description of ${length} bytes is cut off`);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, HEAD, length)));
  return { head, start: Math.ceil((HEAD + length) / 16) * 16 };
}

/**
 * Position of a block, as the arguments of a typed array of 4-byte items.
 * @param {ArrayBuffer} bytes
 * @param {Record<string, { offset: number, length: number }>} blocks
 * @param {number} start
 * @param {string} name
 * @param {number} unit bytes of one item
 * @returns {[ArrayBuffer, number, number]}
 */
function blockBytes(bytes, blocks, start, name, unit) {
  const block = blocks[name];
  if (!block) return [bytes, 0, 0];
  const from = start + block.offset;
  if (from % 4 !== 0 || block.length % unit !== 0 || from + block.length > bytes.byteLength) {
    throw damaged(`block "${name}" (${block.length} bytes at ${from}) does not fit`);
  }
  return [bytes, from, block.length / 4];
}

/** @param {Model} model */
function checkReferences(model) {
  const { blocks, regions, surfaces, materials } = model;
  const patches = blocks.patches.length / WORDS.patches;
  surfaces.forEach((surface, i) => {
    if (surface.kind === "patches") {
      within(surface.first + surface.count, patches, `patches of surface ${i}`);
      if (surface.region !== null) within(surface.region + 1, regions.length, `region of surface ${i}`);
    } else if (surface.kind === "mesh") {
      within(surface.firstVertex + surface.vertices, blocks.positions.length / 3, `vertices of surface ${i}`);
      within(surface.firstVertex + surface.vertices, blocks.normals.length / 3, `normals of surface ${i}`);
      within(surface.firstIndex + surface.indices, blocks.indices.length, `indices of surface ${i}`);
    }
  });
  for (let i = 0; i < patches; i++) {
    const { degreeU, degreeV, firstPoint } = patchHeader(model, i);
    within(firstPoint + (degreeU + 1) * (degreeV + 1), blocks.points.length / 4, `points of patch ${i}`);
  }
  regions.forEach((region, i) => {
    within(region.firstCell + region.cells[0] * region.cells[1], blocks.regionCells.length / 4, `cells of region ${i}`);
  });
  model.edges.forEach(({ first, count }, i) => {
    within(first + count, blocks.edgePoints.length / WORDS.edgePoints, `points of edge ${i}`);
  });
  model.edgeCopies.forEach(({ first, count }, i) => within(first + count, model.edges.length, `edges of copy ${i}`));
  model.maps.forEach((map, i) => {
    if (model.mapValues[i].length !== map.channels * map.width * map.height)
      throw damaged(`map ${i} does not have its declared size`);
  });
  model.objects.forEach((object, i) => {
    within(object.surface + 1, surfaces.length, `surface of object ${i}`);
    within(object.material + 1, materials.length, `material of object ${i}`);
    if (object.map !== null) within(object.map + 1, model.maps.length, `map of object ${i}`);
  });
}

/** @param {number} end @param {number} count @param {string} what */
function within(end, count, what) {
  if (!(end <= count)) throw damaged(`${what} end at ${end} of ${count}`);
}

/** @param {string} what */
function damaged(what) {
  return new Error(`The model is damaged: ${what}.`);
}

/**
 * Degrees, flags and offsets from the first words of a patch.
 * @param {Model} model
 * @param {number} patch
 */
export function patchHeader(model, patch) {
  const words = model.blocks.patches;
  const degrees = words[patch * WORDS.patches];
  return {
    degreeU: degrees & 255,
    degreeV: (degrees >> 8) & 255,
    rational: ((degrees >> 16) & 1) === 1,
    firstPoint: words[patch * WORDS.patches + 1],
    face: words[patch * WORDS.patches + 2],
  };
}

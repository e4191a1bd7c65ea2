/**
 * Models of one patch, as the server would send them.
 *
 * @module
 */

/** @typedef {{ head: any, patches: Uint32Array, points: Float32Array }} SmallModel */

/**
 * @param {{ degreeU: number, degreeV: number, points: number[] }} patch homogeneous control points
 * @returns {SmallModel}
 */
export function patchModel({ degreeU, degreeV, points }) {
  const patches = new Uint32Array(16);
  patches.set([degreeU + 256 * degreeV + 65536, 0, 7]);
  const head = {
    name: "small",
    surfaces: [{ kind: "patches", first: 0, count: 1, origin: [0, 0, 0], region: null, mapping: "patch" }],
    regions: [],
    objects: [{ surface: 0, toWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], material: 0, leaf: 0, map: null }],
    materials: [{}],
  };
  return { head, patches, points: Float32Array.from(points) };
}

/** @param {SmallModel} model @returns {ArrayBuffer} */
export function encodeModel({ head, patches, points }) {
  const blocks = { patches: { offset: 0, length: 64 }, points: { offset: 64, length: points.byteLength } };
  const text = new TextEncoder().encode(JSON.stringify({ ...head, blocks }));
  const start = Math.ceil((16 + text.length) / 16) * 16;
  const bytes = new Uint8Array(start + 64 + points.byteLength);
  bytes.set(new TextEncoder().encode("GLANZVW1"));
  new DataView(bytes.buffer).setUint32(8, text.length, true);
  bytes.set(text, 16);
  bytes.set(new Uint8Array(patches.buffer), start);
  bytes.set(new Uint8Array(points.buffer), start + 64);
  return bytes.buffer;
}

import assert from "node:assert/strict";
import { test } from "node:test";

import { tileFromBytes } from "../web/session.js";
import { TileImage, renderSize } from "../web/rendered_image.js";

const ONE = 0x3c00;

/** A tile as the server sends it. @param {number[]} place x, y, width, height @param {number[]} halves */
function tileBytes([x, y, width, height], halves) {
  const bytes = new DataView(new ArrayBuffer(20 + 2 * halves.length));
  bytes.setUint8(0, 1);
  bytes.setUint32(4, 7, true);
  [x, y, width, height].forEach((value, i) => bytes.setUint16(8 + 2 * i, value, true));
  bytes.setUint32(16, 5, true);
  halves.forEach((half, i) => bytes.setUint16(20 + 2 * i, half, true));
  return bytes.buffer;
}

test("tile is read as the server writes it", () => {
  const tile = tileFromBytes(tileBytes([2, 3, 2, 1], [1, 2, 3, 4, 5, 6]));
  assert.deepEqual(
    { ...tile, pixels: [...(tile?.pixels ?? [])] },
    {
      id: 7,
      x: 2,
      y: 3,
      width: 2,
      height: 1,
      samples: 5,
      denoised: false,
      pixels: [1, 2, 3, 4, 5, 6],
    },
  );
});

test("second byte of a tile tells that its noise was removed", () => {
  const bytes = tileBytes([0, 0, 1, 1], [1, 2, 3]);
  new DataView(bytes).setUint8(1, 1);
  assert.equal(tileFromBytes(bytes)?.denoised, true);
});

test("bytes that are no whole tile are none", () => {
  assert.equal(tileFromBytes(new ArrayBuffer(0)), null);
  assert.equal(tileFromBytes(tileBytes([0, 0, 2, 1], [1, 2, 3])), null);
  const file = tileBytes([0, 0, 1, 1], [1, 2, 3]);
  new DataView(file).setUint8(0, 2);
  assert.equal(tileFromBytes(file), null);
});

test("picture is covered once every pixel has come, however often some of them come", () => {
  const picture = new TileImage({ width: 3, height: 2 });
  /** @param {number[]} place @param {number[]} halves */
  const put = (place, halves) => picture.put(/** @type {any} */ (tileFromBytes(tileBytes(place, halves))));
  assert.ok(picture.empty && !picture.covered);
  const two = [1, 2, 3, 4, 5, 6];
  put([1, 0, 1, 2], two);
  put([1, 0, 1, 2], two);
  assert.ok(!picture.empty && !picture.covered);
  put([0, 0, 1, 2], two);
  put([2, 0, 1, 2], two);
  assert.ok(picture.covered);
  assert.deepEqual([...picture.data.slice(0, 4)], [1, 2, 3, ONE]);
  assert.deepEqual([...picture.data.slice(12, 16)], [4, 5, 6, ONE]);
  assert.deepEqual(picture.changed.slice(0, 1), [[1, 0, 1, 2]]);
});

test("what of a tile lies outside of the picture is left out", () => {
  const picture = new TileImage({ width: 2, height: 2 });
  const tile = tileFromBytes(tileBytes([1, 1, 2, 1], [1, 2, 3, 4, 5, 6]));
  assert.ok(tile);
  picture.put(tile);
  assert.deepEqual(picture.changed, [[1, 1, 1, 1]]);
  assert.deepEqual([...picture.data.slice(12)], [1, 2, 3, ONE]);
  picture.put({ ...tile, x: 2 });
  assert.equal(picture.missing, 3);
});

test("canvas larger than the server renders is rendered at the same ratio", () => {
  assert.deepEqual(renderSize({ width: 640, height: 480 }), { width: 640, height: 480 });
  assert.deepEqual(renderSize({ width: 8192, height: 2048 }), { width: 4096, height: 1024 });
  assert.deepEqual(renderSize({ width: 100000, height: 1 }), { width: 4096, height: 1 });
});

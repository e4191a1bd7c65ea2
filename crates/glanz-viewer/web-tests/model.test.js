import assert from "node:assert/strict";
import { test } from "node:test";

import { decodeModel, fetchModel, patchHeader } from "../web/model.js";
import { encodeModel, patchModel } from "./small_model.js";

test("a_model_has_the_numbers_that_were_written", () => {
  const model = decodeModel(encodeModel(patchModel({ degreeU: 1, degreeV: 2, points: [...Array(24).keys()] })));
  assert.equal(model.name, "small");
  assert.deepEqual(patchHeader(model, 0), { degreeU: 1, degreeV: 2, rational: true, firstPoint: 0, face: 7 });
  assert.deepEqual([...model.blocks.points.slice(20)], [20, 21, 22, 23]);
  assert.equal(model.blocks.regionCells.length, 0);
});

test("bytes_that_are_no_model_are_refused_with_the_reason", () => {
  assert.throws(() => decodeModel(new ArrayBuffer(3)), /3 bytes are too few/);
  assert.throws(() => decodeModel(new TextEncoder().encode("<!doctype html><p>").buffer), /begins with "<!doctyp"/);
  const bytes = encodeModel(patchModel({ degreeU: 1, degreeV: 1, points: Array(16).fill(1) }));
  assert.throws(() => decodeModel(bytes.slice(0, 40)), /cut off/);
});

test("a_model_that_is_too_large_for_a_page_is_not_fetched", async (context) => {
  const bytes = encodeModel(patchModel({ degreeU: 1, degreeV: 1, points: [...Array(16).keys()] }));
  /** @type {AbortSignal | undefined} */
  let signal;
  /** @param {number} size */
  const serve = (size) =>
    context.mock.method(globalThis, "fetch", async (/** @type {string} */ _, /** @type {RequestInit} */ options) => {
      signal = options.signal ?? undefined;
      return new Response(bytes, { headers: { "content-length": String(size) } });
    });
  serve(2 ** 30);
  assert.equal((await fetchModel("/model/x")).name, "small");
  assert.equal(signal?.aborted, false);
  serve(1.5 * 2 ** 30);
  await assert.rejects(fetchModel("/model/x"), /has 1\.61 GB, and a page takes 1\.07 GB/);
  assert.equal(signal?.aborted, true);
});

test("a_patch_with_points_beyond_the_block_is_refused", () => {
  const bytes = encodeModel(patchModel({ degreeU: 3, degreeV: 3, points: Array(16).fill(1) }));
  assert.throws(() => decodeModel(bytes), /points of patch 0 end at 16 of 4/);
});

test("an_object_of_a_surface_that_is_not_there_is_refused", () => {
  const model = patchModel({ degreeU: 1, degreeV: 1, points: Array(16).fill(1) });
  model.head.objects[0].surface = 1;
  assert.throws(() => decodeModel(encodeModel(model)), /surface of object 0 end at 2 of 1/);
});

test("maps_have_one_number_or_three_a_texel_and_are_shown_by_objects", () => {
  const withMap = (/** @type {object} */ map) => {
    const model = patchModel({ degreeU: 1, degreeV: 1, points: [...Array(24).keys()] });
    model.head.maps = [{ unit: "lx", block: "points", width: 4, height: 2, sides: 1, largest: 23, ...map }];
    return model;
  };
  const decoded = (/** @type {object} */ map) => decodeModel(encodeModel(withMap(map)));
  for (const shape of [
    { channels: 3, width: 4 },
    { channels: 1, width: 12 },
  ])
    assert.equal(decoded(shape).mapValues[0][23], 23);
  assert.throws(() => decoded({ channels: 1 }), /map 0 does not have its declared size/);
  assert.throws(() => decoded({ channels: 2, width: 6 }), /map 0 has 2 channels, not 1 or 3/);
  assert.deepEqual(decoded({ channels: 3 }).shownMaps, []);
  const shown = withMap({ channels: 3 });
  shown.head.objects[0].map = 0;
  assert.equal(decodeModel(encodeModel(shown)).shownMaps.length, 1);
});

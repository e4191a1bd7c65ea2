import assert from "node:assert/strict";
import { test } from "node:test";

import { AdaptiveResolution } from "../web/adaptive_resolution.js";

test("slow pictures become coarser while things move, down to an eighth, and whole at rest", () => {
  const pace = new AdaptiveResolution();
  pace.moved(1000);
  for (const share of [1, 1 / 2, 1 / 4, 1 / 8, 1 / 8]) {
    assert.equal(pace.shareAt(1010), share);
    pace.record(share, 500);
  }
  assert.equal(pace.shareAt(1149), 1 / 8);
  assert.equal(pace.shareAt(1150), 1);
});

test("pictures with time to spare become finer again", () => {
  const pace = new AdaptiveResolution();
  pace.record(1, 500);
  pace.record(1 / 2, 20);
  pace.moved(0);
  assert.equal(pace.shareAt(1), 1);
});

test("slow whole picture at rest makes the next move coarser by one step only", () => {
  const pace = new AdaptiveResolution();
  pace.record(1, 500);
  pace.record(1 / 2, 500);
  // The picture at rest is whole again, and says nothing of coarse ones.
  pace.record(1, 5000);
  pace.moved(0);
  assert.equal(pace.shareAt(1), 1 / 4);
});

test("picture that takes neither long nor short changes nothing", () => {
  const pace = new AdaptiveResolution();
  pace.record(1, 80);
  pace.moved(0);
  assert.equal(pace.shareAt(1), 1);
});

import assert from "node:assert/strict";
import { test } from "node:test";

import { Pace } from "../web/pace.js";

test("slow pictures become coarser while things move, down to an eighth, and whole at rest", () => {
  const pace = new Pace();
  pace.moved(1000);
  for (const share of [1, 1 / 2, 1 / 4, 1 / 8, 1 / 8]) {
    assert.equal(pace.shareAt(1010), share);
    pace.took(share, 500);
  }
  assert.equal(pace.shareAt(1149), 1 / 8);
  assert.equal(pace.shareAt(1150), 1);
});

test("pictures with time to spare become finer again", () => {
  const pace = new Pace();
  pace.took(1, 500);
  pace.took(1 / 2, 20);
  pace.moved(0);
  assert.equal(pace.shareAt(1), 1);
});

test("slow whole picture at rest makes the next move coarser by one step only", () => {
  const pace = new Pace();
  pace.took(1, 500);
  pace.took(1 / 2, 500);
  // The picture at rest is whole again, and says nothing of coarse ones.
  pace.took(1, 5000);
  pace.moved(0);
  assert.equal(pace.shareAt(1), 1 / 4);
});

test("picture that takes neither long nor short changes nothing", () => {
  const pace = new Pace();
  pace.took(1, 80);
  pace.moved(0);
  assert.equal(pace.shareAt(1), 1);
});

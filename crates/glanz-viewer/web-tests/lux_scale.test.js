import assert from "node:assert/strict";
import { test } from "node:test";

import {
  levelsWithin,
  luxScale,
  MOST_LEVELS,
  percentile,
  positionOn,
  roundLevels,
  sortedCells,
  typedLevels,
} from "../web/lux_scale.js";
import { limitsText } from "../web/ui/legend.js";
import { plain } from "../web/ui/units.js";

/** 1 to 100 lx on equal areas, not in order. */
const HUNDRED = sorted(Array.from({ length: 100 }, (_, i) => [((37 * i) % 100) + 1, 0.25]).flat());

/** @param {number[]} cells illuminance and area of each */
function sorted(cells) {
  return sortedCells([Float32Array.from(cells)]);
}

test("percentile is the illuminance that this share of the area has at most", () => {
  assert.equal(percentile(HUNDRED, 0.01), 1);
  assert.equal(percentile(HUNDRED, 0.5), 50);
  assert.equal(percentile(HUNDRED, 0.99), 99);
  // Nine tenths of the area have 7 lx: the number of cells does not count.
  const uneven = sorted([11, 0.25, 3, 0.25, 5, 0.25, 7, 9, 13, 0.25]);
  assert.deepEqual(
    [0.02, 0.1, 0.9, 0.96].map((share) => percentile(uneven, share)),
    [3, 7, 7, 11],
  );
  assert.equal(percentile(new Float32Array(0), 0.5), 0);
});

test("two designs share one scale", () => {
  const both = sortedCells([Float32Array.from([80, 1, 20, 2]), Float32Array.from([50, 3])]);
  assert.deepEqual([...both], [20, 2, 50, 3, 80, 1]);
  assert.equal(luxScale(both, "linear", 1).high, 80);
});

test("scales end where their kind says", () => {
  assert.deepEqual(luxScale(HUNDRED, "linear", 1), { low: 0, high: 100, logarithmic: false });
  assert.deepEqual(luxScale(HUNDRED, "percentile", 5), {
    low: 5,
    high: 95,
    logarithmic: false,
    percent: [5, 95],
  });
  assert.deepEqual(luxScale(HUNDRED, "logarithmic", 1), { low: 1, high: 100, logarithmic: true });
  // Shadows do not take the colours of what is seen.
  assert.deepEqual(luxScale(sorted([0.001, 1, 0, 1, 500, 1]), "logarithmic", 1), {
    low: 0.5,
    high: 500,
    logarithmic: true,
  });
});

test("scales of darkness and of even light have two ends", () => {
  for (const kind of /** @type {const} */ (["linear", "logarithmic", "percentile"])) {
    for (const lux of [0, 80]) {
      const { low, high } = luxScale(sorted([lux, 1, lux, 2]), kind, 1);
      assert.ok(low < high && high >= lux, `${kind} ${lux}: ${low} ${high}`);
    }
  }
});

test("percentiles that are one value leave a scale from 0 up to it", () => {
  // 99.2 % of the area have 500 lx; the lamp's own cell is no part of the scale.
  const cells = sorted([2, 0.4, 500, 99.2, 9000, 0.4]);
  assert.deepEqual(luxScale(cells, "percentile", 1), { low: 0, high: 500, logarithmic: false, percent: [0, 99] });
  assert.deepEqual(luxScale(cells, "percentile", 0), { low: 2, high: 9000, logarithmic: false, percent: [0, 100] });
  // Hardly anything is lit.
  assert.deepEqual(luxScale(sorted([0, 999, 80, 1]), "percentile", 1), { low: 0, high: 80, logarithmic: false });
});

test("light that is even but for the digits of numbers has no scale of these digits", () => {
  const cells = sorted([Math.fround(500), 1, Math.fround(500 * (1 + 2 ** -23)), 1, Math.fround(500.01), 1]);
  for (const kind of /** @type {const} */ (["linear", "logarithmic", "percentile"])) {
    const scale = luxScale(cells, kind, 1);
    assert.ok(scale.low <= 0.5 * scale.high, `${kind}: ${JSON.stringify(scale)}`);
    for (const lux of [0, 250, 500, 501]) assert.ok(Number.isFinite(positionOn(scale, lux)), `${kind} ${lux}`);
    const levels = roundLevels(scale).map((level) => plain(level));
    assert.equal(new Set(levels).size, levels.length);
    assert.ok(levels.length > 2);
  }
  // The ends are written with the digits that tell them apart.
  assert.equal(limitsText({ low: 500, high: 500.3, logarithmic: false }), "500 to 500.3");
  assert.equal(
    limitsText({ low: 0, high: 1234.5, logarithmic: false, percent: [0, 99] }),
    "up to 99 % of the area, 0 to 1230",
  );
  assert.equal(
    limitsText({ low: 20, high: 500, logarithmic: false, percent: [2.5, 97.5] }),
    "2.5 % to 97.5 % of the area, 20 to 500",
  );
});

test("isolux lines are listed where they can be drawn", () => {
  // On the scale or beyond it, but not where no cell is as dark or as bright.
  assert.deepEqual(levelsWithin(HUNDRED, [0.5, 1, 98, 100, 500]), [1, 98, 100]);
  assert.deepEqual(levelsWithin(new Float32Array(), [1]), []);
});

test("colours are at equal steps or at equal factors", () => {
  const linear = { low: 100, high: 300, logarithmic: false };
  assert.deepEqual(
    [50, 100, 150, 300, 900].map((lux) => positionOn(linear, lux)),
    [0, 0, 0.25, 1, 1],
  );
  const logarithmic = { low: 1, high: 1000, logarithmic: true };
  [1, 10, 100, 1000].forEach((lux, i) => assert.ok(Math.abs(positionOn(logarithmic, lux) - i / 3) < 1e-12));
  assert.equal(positionOn(logarithmic, 0), 0);
});

test("levels are round, within the scale, and as many as can be told apart", () => {
  assert.deepEqual(roundLevels({ low: 0, high: 880, logarithmic: false }), [100, 200, 300, 400, 500, 600, 700, 800]);
  assert.deepEqual(roundLevels({ low: 12.3, high: 47, logarithmic: false }), [15, 20, 25, 30, 35, 40, 45]);
  // Illuminances of EN 12464-1, as in the drawings of reports.
  assert.deepEqual(roundLevels({ low: 40, high: 800, logarithmic: true }), [50, 75, 100, 150, 200, 300, 500, 750]);
  assert.deepEqual(roundLevels({ low: 1.5, high: 1100, logarithmic: true }), [2, 5, 10, 20, 50, 100, 200, 500, 1000]);
  assert.deepEqual(roundLevels({ low: 5, high: 5, logarithmic: false }), []);
  for (let i = 0; i < 400; i++) {
    const high = 10 ** (-4 + 0.025 * i);
    for (const share of [0, 0.001, 0.03, 0.3, 0.7, 0.95]) {
      for (const logarithmic of [false, true]) {
        const scale = { low: Math.max(share, logarithmic ? 1e-3 : 0) * high, high, logarithmic };
        const levels = roundLevels(scale);
        assert.ok(levels.length >= 3 && levels.length <= MOST_LEVELS, `${JSON.stringify(scale)}: ${levels}`);
        assert.ok(levels.every((level) => level > scale.low && level < high && String(level).length <= 9));
      }
    }
  }
});

test("typed levels are taken in any order, and what is no illuminance is named", () => {
  assert.deepEqual(typedLevels(" 500, 300;300 0.5 "), { levels: [0.5, 300, 500], error: "" });
  assert.deepEqual(typedLevels(""), { levels: [], error: "" });
  for (const text of ["300 lx", "-5", "0", "1e999", "NaN", "1,5", "1e39", "1e-46"])
    assert.match(typedLevels(text).error, /is no illuminance/);
  assert.match(typedLevels("1 ".repeat(17)).error, /17 levels are too many/);
});

import assert from "node:assert/strict";
import { test } from "node:test";

import {
  angleText,
  areaText,
  directionText,
  fixLengthUnit,
  lengthText,
  luxText,
  luxTexts,
  plain,
  pointText,
  timeText,
  volumeText,
} from "../web/ui/units.js";

test("lengths are said in the largest unit that makes them at least 1", () => {
  assert.equal(lengthText(0.0125), "12.5 mm");
  assert.equal(lengthText(1), "1 m");
  assert.equal(lengthText(0.99999), "999.99 mm");
  assert.equal(lengthText(-0.002), "−2 mm");
  assert.equal(lengthText(4.2e-7), "420 nm");
  assert.equal(lengthText(1e-12), "0.001 nm");
  assert.equal(lengthText(12500), "12.5 km");
  assert.equal(lengthText(0), "0 m");
});

test("areas take the unit of their square's side", () => {
  assert.equal(areaText(2.5e-5), "25 mm²");
  assert.equal(areaText(6), "6 m²");
});

test("numbers have no zeros at their end and no digits beyond those asked for", () => {
  assert.equal(plain(1 / 3), "0.333333");
  assert.equal(plain(2.5), "2.5");
  assert.equal(plain(-Infinity), "−∞");
  assert.equal(plain(NaN), "–");
});

test("directions show rounding errors as zero", () => {
  assert.equal(directionText([1e-17, -0.6, 0.8]), "0, −0.6, 0.8");
});

test("angles are degrees, times minutes and seconds", () => {
  assert.equal(angleText(Math.PI / 3), "60°");
  assert.equal(timeText(4.25), "4.3 s");
  assert.equal(timeText(125.9), "2 min 5 s");
});

test("measures of a CAD file have its unit, if it is a known one", () => {
  fixLengthUnit(0.025400000001);
  assert.equal(lengthText(0.0127), "0.5 in");
  assert.equal(areaText(0.0254 ** 2 * 3), "3 in²");
  assert.equal(volumeText(0.0254 ** 3 * 2), "2 in³");
  assert.equal(pointText([0.0254, 0, -0.0508]), "1, 0, −2 in");
  for (const unknown of [null, 201.168]) {
    fixLengthUnit(unknown);
    assert.equal(lengthText(0.0127), "12.7 mm");
    assert.equal(volumeText(2e-9), "2 mm³");
    assert.equal(pointText([0.0254, 0, 0]), "0.0254, 0, 0 m");
  }
});

test("illuminances have their relative errors, and those of two designs their difference", () => {
  /** @param {number} lux @param {number | null} relativeError */
  const reading = (lux, relativeError) => ({
    ...{ receiver: "floor", cell: /** @type {[number, number]} */ ([0, 0]), lux, relativeError },
    ...{ minimum: 0, mean: 0, maximum: 0 },
  });
  assert.equal(luxText(reading(512.34, 0.0081)), "512.3 lx ± 0.81 %");
  assert.equal(luxText(reading(512.34, 3.6e-7)), "512.3 lx ± < 0.01 %");
  assert.equal(luxText(reading(0, null)), "0 lx");
  const [first, second] = [reading(500, 0.01), reading(480, 0)];
  assert.equal(luxTexts(first, second), "A 500 lx ± 1 %, B 480 lx, B − A −20 lx (−4 %)");
  assert.equal(luxTexts(second, first), "A 480 lx, B 500 lx ± 1 %, B − A +20 lx (+4.2 %)");
  assert.equal(luxTexts(reading(0, null), reading(3, null)), "A 0 lx, B 3 lx, B − A +3 lx");
  assert.equal(luxTexts(null, second), "A –, B 480 lx");
  assert.equal(luxTexts(null, null), "");
});

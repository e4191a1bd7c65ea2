import assert from "node:assert/strict";
import { test } from "node:test";

import { HOVER_PAUSE, PointerControls } from "../web/ui/pointer_controls.js";
import { timers } from "./timers.js";

/** Controls of a canvas that is nowhere, and the places where the pointer was said to rest. */
function controls() {
  /** @type {unknown[]} */
  const rests = [];
  const nothing = () => {};
  const canvas = /** @type {any} */ ({
    ...{ addEventListener: nothing, setPointerCapture: nothing },
    getBoundingClientRect: () => ({ left: 100, top: 50 }),
  });
  const viewpoint = /** @type {any} */ ({ halt: nothing, orbitAboutFocus: nothing, orbit: nothing });
  const listener = {
    ...{ pick: async () => null, clicked: nothing, released: nothing },
    hover: (/** @type {unknown} */ place) => rests.push(place),
  };
  return { pointer: new PointerControls(canvas, viewpoint, listener), rests };
}

/** @param {string} type @param {string} pointerType @param {number} clientX @returns {any} */
function event(type, pointerType, clientX) {
  return { type, pointerType, clientX, clientY: 60, pointerId: 1, button: 0, shiftKey: false };
}

test("pointer rests where a drag ended, a finger nowhere", (context) => {
  const clock = timers(context);
  for (const [type, end, expected] of [
    ["mouse", "pointerup", [null, { x: 80, y: 10 }]],
    ["pen", "pointerup", [null, { x: 80, y: 10 }]],
    ["touch", "pointerup", [null]],
    ["mouse", "pointercancel", [null]],
  ]) {
    const { pointer, rests } = controls();
    pointer.down(event("pointerdown", String(type), 110));
    pointer.move(event("pointermove", String(type), 180));
    pointer.up(event(String(end), String(type), 180));
    clock.tick(HOVER_PAUSE);
    assert.deepEqual(rests, expected, `${type}, ${end}`);
  }
});

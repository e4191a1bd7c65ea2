import assert from "node:assert/strict";
import { test } from "node:test";

import { commandsOf } from "../web/commands.js";
import { defaultSettings } from "../web/settings.js";

/** The element for announcements, which is all that these commands need of the page. */
class FakeElement {
  textContent = "";
}
const live = new FakeElement();
Object.assign(globalThis, { HTMLElement: FakeElement, document: { getElementById: () => live } });

/** Presses a key on a page whose scene has some things. @param {string} key @param {boolean} has */
function pressed(key, has) {
  const settings = defaultSettings();
  const page = { settings, viewpoint: {}, hasMaps: has, hasLux: has, hasWalls: has, settingsSet: () => {} };
  live.textContent = "";
  commandsOf(/** @type {any} */ (page))
    .find(({ keys }) => keys.includes(key))
    ?.run();
  return settings;
}

test("keys of light and walls change nothing in scenes without them, and say so", () => {
  for (const key of ["l", "g", "t", "w"]) {
    assert.notDeepEqual(pressed(key, true), defaultSettings(), key);
    assert.deepEqual(pressed(key, false), defaultSettings(), key);
    assert.match(live.textContent, /The scene has no/, key);
  }
});

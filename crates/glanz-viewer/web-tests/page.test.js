import assert from "node:assert/strict";
import { test } from "node:test";

class FakeElement {
  /** @type {string[]} */
  texts = [];
  textContent = "";
  className = "";
  hidden = false;

  /** @param {FakeElement[]} children */
  replaceChildren(...children) {
    this.texts = children.map(({ textContent }) => textContent);
  }
}
const elements = { notes: new FakeElement(), "note-list": new FakeElement() };
const document = {
  getElementById: (/** @type {keyof typeof elements} */ id) => elements[id],
  createElement: () => new FakeElement(),
};
Object.assign(globalThis, { HTMLElement: FakeElement, document });

const { Page } = await import("../web/page.js");

test("notes of both designs are shown", () => {
  /** @param {object} page with `model` and `second` @returns {string[] | null} */
  const shown = (page) => {
    Object.assign(Object.create(Page.prototype), page).showNotes();
    return elements.notes.hidden ? null : elements["note-list"].texts;
  };
  assert.deepEqual(shown({ model: { notes: ["one"] }, second: { model: { notes: ["two"] } } }), ["one", "B: two"]);
  assert.deepEqual(shown({ model: { notes: [] }, second: { model: { notes: ["two"] } } }), ["B: two"]);
  assert.deepEqual(shown({ model: { notes: ["one"] }, second: { model: null } }), ["one"]);
  assert.equal(shown({ model: { notes: [] }, second: null }), null);
  assert.equal(shown({ model: null, second: null }), null);
});

test("late answer does not replace a newer one at the same place", async () => {
  /** @type {((hit: object) => void)[]} */
  const answers = [];
  /** @type {unknown[]} */
  const shown = [];
  const page = Object.assign(Object.create(Page.prototype), {
    hovers: 0,
    hovering: null,
    model: {},
    second: null,
    settings: { maps: false },
    picker: { surface: () => new Promise((resolve) => answers.push(resolve)) },
    status: { point: (/** @type {unknown} */ point) => shown.push(point) },
  });
  const first = page.hover({ x: 1, y: 2 });
  page.updateHover();
  answers[1]({ point: [0, 0, 2] });
  answers[0]({ point: [0, 0, 1] });
  await first;
  assert.deepEqual(shown, [[0, 0, 2]]);
});

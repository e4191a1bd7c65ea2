import assert from "node:assert/strict";
import { test } from "node:test";

import { timers } from "./timers.js";

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
class FakeDialog extends FakeElement {
  open = false;
  shown = 0;

  showModal() {
    this.open = true;
    this.shown += 1;
  }
}
const problem = new FakeDialog();
const elements = {
  ...{ notes: new FakeElement(), "note-list": new FakeElement() },
  ...{ problem, "problem-heading": new FakeElement(), "problem-text": new FakeElement() },
};
const document = {
  getElementById: (/** @type {keyof typeof elements} */ id) => elements[id],
  createElement: () => new FakeElement(),
};
Object.assign(globalThis, { HTMLElement: FakeElement, HTMLDialogElement: FakeDialog, document });

const { Page } = await import("../web/page.js");
const { SecondDesign } = await import("../web/second_design.js");

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

test("what is under a pointer at rest is looked up again once the camera rests", (context) => {
  const clock = timers(context);
  /** @type {unknown[]} */
  const hovered = [];
  const nothing = () => {};
  const page = Object.defineProperties(Object.create(Page.prototype), {
    rendering: { value: "chosen" },
    hovering: { value: null, writable: true },
  });
  Object.assign(page, {
    ...{ resolution: { moved: nothing }, renderedImage: { restart: nothing }, invalidate: nothing },
    hover: (/** @type {unknown} */ place) => hovered.push(place),
  });
  page.viewChanged();
  clock.tick(200);
  assert.deepEqual(hovered, []);
  page.hovering = { x: 1, y: 2 };
  page.viewChanged();
  clock.tick(60);
  page.viewChanged();
  clock.tick(60);
  assert.deepEqual(hovered, []);
  clock.tick(60);
  assert.deepEqual(hovered, [{ x: 1, y: 2 }]);
});

test("problem of both designs is shown once, and again when it comes back", () => {
  const page = Object.assign(Object.create(Page.prototype), { problem: null });
  const [first, second] = [{}, {}];
  const shown = (/** @type {object} */ design, /** @type {string} */ text) => {
    problem.open = false;
    const before = problem.shown;
    page.showProblemOf(design, "room.pbrt", text);
    return problem.shown > before;
  };
  assert.deepEqual([shown(first, "no shape"), shown(second, "no shape")], [true, false]);
  assert.deepEqual([shown(first, "no shape"), shown(second, "no shape")], [true, false]);
  assert.deepEqual([shown(second, "no light"), shown(first, "no light")], [true, false]);
  assert.deepEqual([shown(second, "no lux maps"), shown(first, "no camera")], [true, true]);
});

test("closed second design leaves nothing under the pointer, and no problem", () => {
  /** @type {unknown[]} */
  const hovered = [];
  const page = { problem: {}, hover: (/** @type {unknown} */ place) => hovered.push(place) };
  const nothing = () => {};
  const second = Object.assign(Object.create(SecondDesign.prototype), {
    ...{ page, session: { close: nothing }, renderer: { delete: nothing } },
    ...{ canvas: { remove: nothing }, label: { remove: nothing } },
  });
  second.close();
  second.hover({ x: 1, y: 2 });
  assert.deepEqual(hovered, [null]);
  assert.equal(page.problem, null);
});

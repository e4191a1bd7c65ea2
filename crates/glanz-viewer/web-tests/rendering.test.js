import assert from "node:assert/strict";
import { test } from "node:test";

import { RenderedImage } from "../web/rendered_image.js";
import { timers } from "./timers.js";

/** A session that remembers what it is told to send. */
function recorder() {
  /** @type {any[]} */
  const sent = [];
  let id = 0;
  const session = { isOnline: true, nextId: () => ++id, send: (/** @type {any} */ message) => sent.push(message) };
  return { sent, session: /** @type {import("../web/session.js").Session} */ (/** @type {unknown} */ (session)) };
}

const ORDER = /** @type {import("../web/rendered_image.js").RenderRequest} */ (
  /** @type {unknown} */ ({
    camera: "camera",
    size: { width: 2, height: 1 },
    hidden: [],
    integrator: "path",
    denoise: true,
  })
);

/** @param {number} id */
const tile = (id) => ({ id, x: 0, y: 0, width: 2, height: 1, samples: 1, denoised: false, pixels: new Uint16Array(6) });

test("move ends the rendering of the view before it, and forgets the picture", () => {
  const { sent, session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  image.tile(tile(1));
  assert.ok(image.picture?.covered);
  image.restart(null);
  assert.deepEqual(
    sent.map(({ type, id }) => [type, id]),
    [
      ["view", 1],
      ["stop", 1],
    ],
  );
  assert.equal(image.picture, null);
  assert.equal(image.status, null);
});

test("what comes late of an earlier view changes nothing", () => {
  const { session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  image.restart(null);
  image.begin(ORDER);
  image.tile(tile(1));
  image.progress({ type: "progress", id: 1, samples: 9, noise: 0.1, seconds: 1, done: true });
  assert.ok(image.picture?.empty);
  assert.equal(image.status?.samples, 0);
  image.tile(tile(2));
  image.progress({ type: "progress", id: 2, samples: 1, noise: null, seconds: 1, done: false });
  assert.deepEqual([image.status?.samples, image.status?.covered], [1, true]);
});

test("view asks for what the settings say of noise, and the status tells which picture is without", () => {
  const { sent, session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  assert.equal(sent[0].denoise, true);
  image.tile(tile(1));
  assert.equal(image.status?.denoised, null);
  image.tile({ ...tile(1), samples: 8, denoised: true });
  image.progress({ type: "progress", id: 1, samples: 13, noise: 0.1, seconds: 1, done: false });
  assert.deepEqual([image.status?.denoised, image.status?.samples], [8, 13]);
  image.begin(ORDER);
  assert.equal(image.status?.denoised, null);
});

test("latency is known once the server has stopped what it was told to", () => {
  const { session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  image.restart(null);
  image.stopped(99);
  assert.equal(image.latency, null);
  image.stopped(1);
  assert.ok(image.latency !== null && image.latency >= 0);
});

test("failure is that of the view only if it has its number", () => {
  const { session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  assert.equal(image.failed(5, "other"), false);
  assert.equal(image.failed(1, "too large"), true);
  assert.equal(image.status?.error, "too large");
});

test("rest of 250 ms begins rendering, and every move begins the rest anew", (context) => {
  const clock = timers(context);
  const { sent, session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.restart(() => ORDER);
  clock.tick(200);
  image.restart(() => ORDER);
  clock.tick(200);
  assert.equal(sent.length, 0);
  clock.tick(50);
  assert.equal(sent.length, 1);
});

test("nothing is asked for while there is no connection", () => {
  const { sent, session } = recorder();
  const image = new RenderedImage(Object.assign(session, { isOnline: false }), () => {});
  image.begin(ORDER);
  assert.deepEqual([sent.length, image.status], [0, null]);
});

/** Types and numbers of messages. @param {any[]} sent */
const named = (sent) => sent.map(({ type, id }) => `${type} ${id}`);

test("hidden page pauses its rendering, and resumes it when it is shown", (context) => {
  const clock = timers(context);
  const { sent, session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.hide(true);
  image.hide(false);
  assert.equal(sent.length, 0, "nothing is rendered");
  image.begin(ORDER);
  image.hide(true);
  clock.tick(59000);
  assert.equal(image.hide(false), false);
  clock.tick(60000);
  assert.deepEqual(named(sent), ["view 1", "pause 1", "resume 1"]);
  assert.ok(image.picture);
});

test("view of a hidden page is not begun until it is shown", () => {
  const { sent, session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.hide(true);
  image.begin(ORDER);
  assert.deepEqual(named(sent), []);
  assert.equal(image.hide(false), true);
  image.begin(ORDER);
  assert.deepEqual(named(sent), ["view 1"]);
});

test("page that is hidden for a minute gives its image up and wants it again when it is shown", (context) => {
  const clock = timers(context);
  const { sent, session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  image.hide(true);
  clock.tick(60000);
  assert.deepEqual(named(sent), ["view 1", "pause 1", "stop 1"]);
  assert.equal(image.hide(false), true);
  image.hide(true);
  clock.tick(60000);
  assert.equal(image.hide(false), false, "there was nothing to give up");
});

test("finished image stays however long the page is hidden", (context) => {
  const clock = timers(context);
  const { session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  image.tile(tile(1));
  image.progress({ type: "progress", id: 1, samples: 4096, noise: 0.1, seconds: 1, done: true });
  image.hide(true);
  clock.tick(60000);
  assert.equal(image.hide(false), false);
  assert.ok(image.picture?.covered);
});

test("image that failed while the page was hidden is wanted again when it is shown", () => {
  const { session } = recorder();
  const image = new RenderedImage(session, () => {});
  image.begin(ORDER);
  assert.equal(image.hide(true), false);
  image.failed(1, "the view was paused for too long");
  assert.equal(image.hide(false), true);
});

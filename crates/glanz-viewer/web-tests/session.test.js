import assert from "node:assert/strict";
import { test } from "node:test";

import { Session } from "../web/session.js";
import { timers } from "./timers.js";

/** A WebSocket without a network. */
class Socket {
  static OPEN = 1;
  /** @type {Socket[]} */
  static made = [];
  readyState = 0;
  /** @type {any[]} */
  sent = [];
  onopen = () => {};
  onclose = () => {};
  onmessage = (/** @type {{ data: any }} */ _event) => {};
  constructor() {
    Socket.made.push(this);
  }
  open() {
    this.readyState = 1;
    this.onopen();
  }
  close() {
    this.readyState = 3;
    this.onclose();
  }
  /** @param {string} text */
  send(text) {
    this.sent.push(JSON.parse(text));
  }
}

Object.assign(globalThis, { WebSocket: Socket });

/** A session, its socket, and the names of what its listener was told. */
function connected() {
  /** @type {any[][]} */
  const heard = [];
  const listener = new Proxy(
    {},
    {
      get:
        (_target, name) =>
        (/** @type {any[]} */ ...values) =>
          void heard.push([name, ...values]),
    },
  );
  const session = new Session(
    new URL("ws://localhost/ws"),
    /** @type {import("../web/session.js").Listener} */ (listener),
  );
  const [socket] = Socket.made.slice(-1);
  socket.open();
  return { session, socket, heard };
}

test("answers come to those who asked, in whatever order", async () => {
  const { session, socket } = connected();
  const [first, second] = [session.request({ type: "pick" }), session.request({ type: "pick" })];
  const [a, b] = socket.sent.map(({ id }) => id);
  socket.onmessage({ data: JSON.stringify({ type: "hit", id: b, hit: "b" }) });
  socket.onmessage({ data: JSON.stringify({ type: "hit", id: a, hit: null }) });
  assert.deepEqual([(await first).hit, (await second).hit], [null, "b"]);
});

test("request that fails is rejected with the server's words, other failures go to the listener", async () => {
  const { session, socket, heard } = connected();
  const request = session.request({ type: "save" });
  socket.onmessage({ data: JSON.stringify({ type: "failed", id: socket.sent[0].id, message: "no picture" }) });
  await assert.rejects(request, /no picture/);
  socket.onmessage({ data: JSON.stringify({ type: "failed", id: 77, message: "too large" }) });
  assert.deepEqual(heard.at(-1), ["failed", 77, "too large"]);
});

test("new scene rejects what was asked about the one before", async () => {
  const { session, socket, heard } = connected();
  const request = session.request({ type: "pick" });
  const scene = { type: "scene", model: "/model/1", name: "b.pbrt", error: null };
  socket.onmessage({ data: JSON.stringify(scene) });
  await assert.rejects(request, /scene has changed/);
  assert.deepEqual(heard.at(-1), ["scene", scene]);
});

test("scene that cannot be read again leaves requests to be answered, one that is lost rejects them", async () => {
  const { session, socket, heard } = connected();
  const first = session.request({ type: "pick" });
  const refused = { type: "scene", model: null, name: "a.pbrt", error: "error: 1:1", lost: false };
  socket.onmessage({ data: JSON.stringify(refused) });
  assert.deepEqual(heard.at(-1), ["scene", refused]);
  socket.onmessage({ data: JSON.stringify({ type: "hit", id: socket.sent[0].id, hit: null }) });
  assert.equal((await first).hit, null);
  const second = session.request({ type: "pick" });
  socket.onmessage({ data: JSON.stringify({ ...refused, lost: true }) });
  await assert.rejects(second, /scene has changed/);
});

test("file comes as its bytes to the request that it answers", async () => {
  const { session, socket } = connected();
  const request = session.request({ type: "save" });
  const { id } = socket.sent[0];
  socket.onmessage({ data: Uint8Array.of(2, 0, 0, 0, id, 0, 0, 0, 118, 47, 49, 1).buffer });
  assert.deepEqual([...new Uint8Array(await request)], [118, 47, 49, 1]);
});

test("lost connection rejects what waits, and is made anew after growing pauses up to 15 s", async (context) => {
  const clock = timers(context);
  const { session, socket, heard } = connected();
  const request = session.request({ type: "pick" });
  socket.close();
  await assert.rejects(request, /lost/);
  await assert.rejects(session.request({ type: "pick" }), /no connection/);
  const pauses = [500, 1000, 2000, 4000, 8000, 15000, 15000];
  for (const pause of pauses) {
    assert.deepEqual(heard.at(-1), ["offline", pause]);
    const made = Socket.made.length;
    clock.tick(pause - 1);
    assert.equal(Socket.made.length, made);
    clock.tick(1);
    assert.equal(Socket.made.length, made + 1);
    Socket.made[made].close();
  }
  clock.tick(15000);
  Socket.made[Socket.made.length - 1].open();
  assert.deepEqual(heard.at(-1), ["online"]);
  Socket.made[Socket.made.length - 1].close();
  assert.deepEqual(heard.at(-1), ["offline", 500]);
});

test("a session that is closed while it waits to connect again stays closed", (context) => {
  const clock = timers(context);
  const { session, socket } = connected();
  socket.close();
  const made = Socket.made.length;
  session.close();
  clock.tick(20000);
  assert.equal(Socket.made.length, made);
});

/** A clock that stands still until it is told to go on, in place of `setTimeout`. */

/**
 * Replaces timers for the time of a test.
 * @param {import("node:test").TestContext} context
 */
export function timers(context) {
  let now = 0;
  /** @type {{ run: () => void, at: number }[]} */
  let waiting = [];
  const set = (/** @type {() => void} */ run, pause = 0) => {
    const timer = { run, at: now + pause };
    waiting.push(timer);
    return timer;
  };
  const clear = (/** @type {unknown} */ timer) => {
    waiting = waiting.filter((other) => other !== timer);
  };
  context.mock.method(globalThis, "setTimeout", /** @type {any} */ (set));
  context.mock.method(globalThis, "clearTimeout", /** @type {any} */ (clear));
  return {
    /** @param {number} milliseconds */
    tick(milliseconds) {
      now += milliseconds;
      const due = waiting.filter(({ at }) => at <= now);
      due.forEach(clear);
      due.forEach(({ run }) => run());
    },
  };
}

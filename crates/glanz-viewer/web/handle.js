/**
 * `window.glanz`: the page as programs see it, tests among them.
 *
 * @module
 */

/** @typedef {import("./page.js").Page} Page */
/** @typedef {import("./camera.js").Camera} Camera */

/**
 * Places are in CSS pixels from the upper left corner of the canvas.
 * - `ready`: done once the first scene is drawn.
 * - `state()`: what is shown now.
 * - `setCamera(camera)`: looks from there, without transition.
 * - `pick(x, y)`: what the exact surface is there, as the server says; selects nothing.
 * - `normals()`: normal and number of the object for each pixel of the frame buffer.
 * - `truth()`: how far the rendered picture is, `null` while none is asked for.
 * - `latency`: milliseconds from the last stop until the server had ended rendering, `null` before the first.
 * @param {Page} page
 */
export function handle(page) {
  return {
    ready: page.ready,
    state: () => ({
      camera: page.viewpoint.camera,
      center: page.viewpoint.center,
      size: page.size,
      scene: page.scene.name,
      online: page.session.isOnline,
      hidden: [...(page.parts?.hidden ?? [])],
      selected: page.parts?.selectedLeaf ?? null,
      hit: page.hit,
      settings: { ...page.settings },
      section: page.section,
      frame: page.frame,
      moving: page.viewpoint.isMoving || page.hands.isDragging,
    }),
    /** @param {Camera} camera */
    setCamera: (camera) => page.viewpoint.set(camera),
    /** @param {number} x @param {number} y */
    pick: (x, y) => page.pick(x, y),
    normals: () => page.renderer.readNormals(page.view()),
    truth: () => page.truth.status && { ...page.truth.status },
    get latency() {
      return page.truth.latency;
    },
  };
}

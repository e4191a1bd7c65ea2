/**
 * `window.glanz`: the scripting interface, also used by the tests.
 *
 * @module
 */

/** @typedef {import("./page.js").Page} Page */
/** @typedef {import("./camera.js").Camera} Camera */

/**
 * Places are in CSS pixels from the upper left corner of the canvas.
 * - `ready`: resolves when the first scene is drawn.
 * - `state()`: the current state of the view.
 * - `setCamera(camera)`: looks from there, without transition.
 * - `lux`: in the state, scale and levels of illuminances; `second`: name of the second design, `null` if there is none.
 * - `pick(x, y)`: the server's hit on the exact surface; selects nothing.
 * - `pickSecond(x, y)`: the hit in the second design.
 * - `normals()`: normal and number of the object for each pixel of the frame buffer.
 * - `renderStatus()`: progress of the rendered image, `null` while none is requested.
 * - `latency`: milliseconds from the last stop until the server had ended rendering, `null` before the first.
 * @param {Page} page
 */
export function scriptInterface(page) {
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
      edge: page.edge,
      settings: { ...page.settings },
      lux: page.lux,
      second: page.second?.model?.name ?? null,
      section: page.section,
      frame: page.frame,
      moving: page.viewpoint.isMoving || page.pointer.isDragging,
    }),
    /** @param {Camera} camera */
    setCamera: (camera) => page.viewpoint.set(camera),
    /** @param {number} x @param {number} y */
    pick: (x, y) => page.picker.surface(x, y),
    /** @param {number} x @param {number} y */
    pickSecond: (x, y) => page.second?.picker.surface(x, y) ?? null,
    normals: () => page.renderer.readNormals(page.view()),
    renderStatus: () => page.renderedImage.status && { ...page.renderedImage.status },
    get latency() {
      return page.renderedImage.latency;
    },
  };
}

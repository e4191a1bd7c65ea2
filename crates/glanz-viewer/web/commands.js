/**
 * Commands of the page, run by keys and buttons.
 *
 * @module
 */

import { leafBounds } from "./leaf_bounds.js";
import { LUX_SCALES } from "./lux_scale.js";
import { nextShading, shareThrough } from "./settings.js";
import { announce, element } from "./ui/dom.js";
import { download, showProblem, upload } from "./ui/files.js";

/** @typedef {import("./page.js").Page} Page */
/** @typedef {import("./ui/key_bindings.js").Command} Command */
/** @typedef {import("./camera.js").StandardView} StandardView */
/** @typedef {import("./settings.js").Shading} Shading */

/** Pan of one key press as a fraction of the view's shorter side; an orbit by the same drag turns the scene by 7.5 degrees. */
const STEP = 1 / 24;

/** Zoom factor of one key press. */
const ZOOM = 0.8;

/**
 * All commands of the page.
 * @param {Page} page
 * @returns {Command[]}
 */
export function commandsOf(page) {
  return [...cameraCommands(page), ...viewCommands(page), ...partCommands(page), ...toolCommands(page)];
}

/**
 * Camera navigation by keys.
 * @param {Page} page
 * @returns {Command[]}
 */
function cameraCommands({ viewpoint }) {
  /** @type {[way: string, x: number, y: number][]} */
  const ways = [
    ["Left", -1, 0],
    ["Right", 1, 0],
    ["Up", 0, -1],
    ["Down", 0, 1],
  ];
  const step = () => STEP * Math.min(viewpoint.size.width, viewpoint.size.height);
  const turns = ways.map(([way, x, y]) => ({
    name: `turn${way}`,
    keys: [`Arrow${way}`],
    label: "Turn",
    onView: true,
    run: () => viewpoint.orbit(x * step(), y * step()),
  }));
  const moves = ways.map(([way, x, y]) => ({
    name: `move${way}`,
    keys: [`Shift+Arrow${way}`],
    label: "Move",
    onView: true,
    run: () => viewpoint.pan(x * step(), y * step()),
  }));
  return [
    ...turns,
    ...moves,
    { name: "zoomIn", keys: ["+", "="], label: "Nearer", run: () => viewpoint.zoom(ZOOM) },
    { name: "zoomOut", keys: ["-", "_"], label: "Farther", run: () => viewpoint.zoom(1 / ZOOM) },
  ];
}

/**
 * @param {Page} page
 * @returns {Command[]}
 */
function viewCommands(page) {
  const { viewpoint } = page;
  /** @type {StandardView[]} */
  const views = ["front", "back", "left", "right", "top", "bottom", "isometric"];
  const standard = views.map((view, i) => ({
    name: view,
    keys: [String(i + 1)],
    label: view === "isometric" ? "Isometric view" : `View from the ${view}`,
    run: () => viewpoint.look(view),
  }));
  const fit = () => {
    const { selected } = page.parts ?? {};
    const bounds = page.model && selected ? leafBounds(page.model, selected.first, selected.end) : null;
    viewpoint.fit(bounds ?? viewpoint.bounds);
  };
  return [
    { name: "fit", keys: ["f"], label: "Fit the selection, or everything", run: fit },
    ...standard,
    { name: "reset", keys: ["0"], label: "The scene's own view", run: () => viewpoint.reset() },
    {
      name: "projection",
      keys: ["o"],
      label: "Perspective or orthographic",
      run: () => {
        viewpoint.switchProjection();
        announce(viewpoint.camera.kind);
      },
    },
  ];
}

/**
 * @param {Page} page
 * @returns {Command[]}
 */
function partCommands(page) {
  /** @param {(parts: import("./scene_parts.js").SceneParts, item: import("./scene_parts.js").Item) => void} act on what is selected */
  const onSelected = (act) => () => {
    const { parts } = page;
    if (!parts?.selected) {
      announce("Nothing is selected");
      return;
    }
    act(parts, parts.selected);
    page.visibilityChanged();
  };
  const showAll = () => {
    page.parts?.showAll();
    page.visibilityChanged();
  };
  const pickMiddle = () => page.click(viewpoint.size.width / 2, viewpoint.size.height / 2);
  const { viewpoint } = page;
  const escape = () => {
    if (page.measure.active) toggleMeasure(page);
    else page.select(null, null);
  };
  return [
    { name: "pick", keys: ["Enter"], label: "Pick at the centre", onView: true, run: pickMiddle },
    {
      name: "hide",
      keys: ["h"],
      label: "Hide or show the selection",
      run: onSelected((parts, item) => parts.show(item, parts.visibility(item) !== "shown")),
    },
    {
      name: "isolate",
      keys: ["i"],
      label: "Isolate the selection, and back",
      run: onSelected((parts, item) => parts.isolate(item)),
    },
    { name: "showAll", keys: ["a"], label: "Show all", run: showAll },
    { name: "escape", keys: ["Escape"], label: "Stop measuring, clear the selection", run: escape },
  ];
}

/**
 * @param {Page} page
 * @returns {Command[]}
 */
function toolCommands(page) {
  const { settings } = page;
  /** @param {() => void} change */
  const setting = (change) => () => {
    change();
    page.settingsSet();
  };
  /** @param {Shading[]} order */
  const next = (order) => () => (settings.shading = nextShading(settings.shading, order));
  /** A command for scenes that have something. @param {() => boolean} has @param {string} what @param {() => void} run */
  const only = (has, what, run) => () => (has() ? run() : announce(`The scene has no ${what}`));
  const hasMaps = () => page.hasMaps;
  const hasLux = () => page.hasLux;
  const nextScale = () => {
    settings.luxScale = LUX_SCALES[(LUX_SCALES.indexOf(settings.luxScale) + 1) % LUX_SCALES.length];
    announce(`Scale: ${settings.luxScale}`);
  };
  return [
    {
      name: "section",
      keys: ["s"],
      label: "Section plane",
      run: setting(() => (settings.section = !settings.section)),
    },
    { name: "zebra", keys: ["z"], label: "Zebra stripes", run: setting(next(["material", "zebra"])) },
    {
      name: "curvature",
      keys: ["c"],
      label: "Curvature: Gaussian, mean, largest",
      run: setting(next(["material", "gaussian", "mean", "maximum"])),
    },
    { name: "edges", keys: ["e"], label: "Edges", run: setting(() => (settings.edges = !settings.edges)) },
    {
      name: "maps",
      keys: ["l"],
      label: "Light on surfaces",
      run: only(
        hasMaps,
        "light on surfaces",
        setting(() => (settings.maps = !settings.maps)),
      ),
    },
    {
      name: "luxScale",
      keys: ["g"],
      label: "Scale of illuminance: linear, logarithmic, percentiles",
      run: only(hasLux, "illuminances", setting(nextScale)),
    },
    {
      name: "isolux",
      keys: ["t"],
      label: "Isolux lines",
      run: only(
        hasLux,
        "illuminances",
        setting(() => (settings.isolux = !settings.isolux)),
      ),
    },
    {
      name: "seeThrough",
      keys: ["w"],
      label: "Walls seen through from outside",
      run: only(
        () => page.hasWalls,
        "outer walls",
        setting(() => (settings.seeThrough = !settings.seeThrough)),
      ),
    },
    { name: "net", keys: ["n"], label: "Control net", run: setting(() => (settings.net = !settings.net)) },
    { name: "measure", keys: ["m"], label: "Distance between two points", run: () => toggleMeasure(page) },
    { name: "savePng", keys: ["p"], label: "Save the view as PNG", run: () => savePng(page) },
    { name: "saveExr", keys: ["x"], label: "Save the rendered picture as OpenEXR", run: () => saveExr(page) },
    { name: "help", keys: ["?"], label: "Show this help", run: () => element("help", HTMLDialogElement).showModal() },
  ];
}

/** @param {Page} page */
function toggleMeasure(page) {
  page.measure.activate(!page.measure.active);
  for (const button of document.querySelectorAll('[data-command="measure"]')) {
    button.setAttribute("aria-pressed", String(page.measure.active));
  }
  page.invalidate();
}

/**
 * Puts the section plane through the picked point, across its normal.
 * @param {Page} page
 */
export function sectionThroughPicked(page) {
  const { settings, hit, viewpoint } = page;
  if (!hit) return;
  settings.section = true;
  settings.sectionAxis = "picked";
  settings.pickedNormal = hit.normal;
  settings.sectionShare = shareThrough(settings, viewpoint.bounds, hit.point);
  page.settingsSet();
}

/**
 * The name of a file with what is seen.
 * @param {Page} page
 * @param {string} extension
 */
function fileName(page, extension) {
  return `${page.scene.name.replace(/\.[^.]*$/, "") || "glanz"}.${extension}`;
}

/** @param {Page} page */
function savePng(page) {
  // The browser clears the canvas once it was shown: only right after drawing there is something to read.
  page.draw(true);
  const name = fileName(page, page.isDenoised ? "denoised.png" : "png");
  const canvas = page.second ? sideBySide(page.canvas, page.second.canvas) : page.canvas;
  canvas.toBlob((blob) => {
    if (blob) download(blob, name);
  }, "image/png");
}

/**
 * A picture of two.
 * @param {HTMLCanvasElement} left
 * @param {HTMLCanvasElement} right
 */
function sideBySide(left, right) {
  const both = document.createElement("canvas");
  both.width = left.width + right.width;
  both.height = Math.max(left.height, right.height);
  const context = both.getContext("2d");
  context?.drawImage(left, 0, 0);
  context?.drawImage(right, left.width, 0);
  return both;
}

/** @param {Page} page */
async function saveExr(page) {
  try {
    const bytes = await page.session.request({ type: "save" });
    download(new Blob([bytes], { type: "image/x-exr" }), fileName(page, "exr"));
  } catch (error) {
    showProblem("Not saved", error instanceof Error ? error.message : String(error));
  }
}

/** Names of STEP and IGES files, and from how many bytes on reading one takes as long as compiling programs. */
const CAD_FILE = /\.(ste?p|p21|ige?s)$/i;
const LARGE = 5e5;

/**
 * Opens files in place of the scene.
 * @param {Page} page
 * @param {import("./ui/files.js").NamedFile[]} files
 */
export async function openFiles(page, files) {
  page.showMessage(files.length === 1 ? `Opening ${files[0].name}` : `Opening ${files.length} files`);
  // While the server reads them.
  if (files.some(({ name, file }) => CAD_FILE.test(name) && file.size >= LARGE))
    page.renderer.prepareForCad(page.settings.shading);
  const url = new URL(`open?session=${encodeURIComponent(page.scene.session)}`, location.href);
  const problem = await upload(url, files);
  page.showMessage("");
  if (problem !== null) showProblem("Not opened", problem);
}

/**
 * The panels beside the view, which its buttons show and hide.
 *
 * @module
 */

import { element } from "./dom.js";

/** Below this width panels overlay the view and only one is open. */
const NARROW = "(max-width: 60rem)";

/** @type {[panel: string, button: string][]} */
const PANELS = [
  ["parts", "show-parts"],
  ["tools", "show-tools"],
];

/**
 * @param {string} id
 * @param {boolean} shown
 */
function show(id, shown) {
  for (const [panel, button] of PANELS) {
    const isIt = panel === id;
    if (!isIt && !(shown && matchMedia(NARROW).matches)) continue;
    element(panel, HTMLElement).hidden = !(isIt && shown);
    element(button, HTMLElement).setAttribute("aria-expanded", String(isIt && shown));
  }
}

/** Connects the buttons that show and hide the panels. */
export function initPanels() {
  const narrow = matchMedia(NARROW);
  for (const [panel, button] of PANELS) {
    element(button, HTMLElement).addEventListener("click", () =>
      show(panel, element(panel, HTMLElement).hidden !== false),
    );
  }
  const arrange = () => PANELS.forEach(([panel]) => show(panel, !narrow.matches));
  narrow.addEventListener("change", arrange);
  arrange();
}

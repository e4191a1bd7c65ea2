/**
 * Dark, light, or as the system has it.
 *
 * @module
 */

import { element } from "./dom.js";
import { store, stored } from "./storage.js";

const STORED = "glanz-theme";

/**
 * Connects the control that switches between dark, light and the system's theme.
 * @param {() => void} changed called when colours are others now
 */
export function initThemes(changed) {
  const control = element("theme", HTMLSelectElement);
  const apply = () => {
    document.documentElement.dataset["theme"] = control.value;
    changed();
  };
  control.value = stored(STORED) ?? "auto";
  // A word that no option has leaves the control empty.
  if (!control.value) control.value = "auto";
  apply();
  control.addEventListener("change", () => {
    store(STORED, control.value);
    apply();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
}

/**
 * The colour behind the scene, red, green and blue as the display shows them, 0 to 1.
 * @returns {[number, number, number]}
 */
export function backgroundColour() {
  const [red, green, blue] = getComputedStyle(element("view", HTMLElement)).backgroundColor.match(/[\d.]+/g) ?? [];
  return [Number(red) / 255, Number(green) / 255, Number(blue) / 255];
}

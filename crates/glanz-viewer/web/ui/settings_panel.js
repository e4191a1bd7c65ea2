/**
 * The settings of the picture as controls.
 *
 * @module
 */

import { typedLevels } from "../lux_scale.js";
import { fullColour } from "../settings.js";
import { element } from "./dom.js";
import { lengthText, plain } from "./units.js";

/** @typedef {import("../settings.js").Settings} Settings */
/** @typedef {import("../settings.js").Plane} Plane */

/** Shadings whose colours are curvatures. */
const CURVATURES = ["gaussian", "mean", "maximum"];

export class SettingsPanel {
  /**
   * @param {Settings} settings changed in place by the controls
   * @param {() => void} changed
   */
  constructor(settings, changed) {
    this.settings = settings;
    this.form = element("settings", HTMLFormElement);
    this.form.addEventListener("submit", (event) => event.preventDefault());
    this.form.addEventListener("input", () => {
      this.read();
      changed();
    });
    this.write();
  }

  /** Controls whose names are those of settings. */
  *controls() {
    for (const control of this.form.elements) {
      if ((control instanceof HTMLInputElement || control instanceof HTMLSelectElement) && control.name) yield control;
    }
  }

  /** Takes the settings over from the controls. */
  read() {
    /** @type {Record<string, unknown>} */
    const values = {};
    for (const control of this.controls()) {
      if (control instanceof HTMLSelectElement) values[control.name] = control.value;
      else if (control.type === "checkbox") values[control.name] = control.checked;
      else if (control.type === "text") values[control.name] = control.value;
      else if (control.type === "range") values[control.name] = control.valueAsNumber;
      else if (control.checked) values[control.name] = control.value;
    }
    Object.assign(this.settings, values);
  }

  /** Writes the settings to the controls. */
  write() {
    /** @type {Record<string, unknown>} */
    const values = this.settings;
    for (const control of this.controls()) {
      const value = values[control.name];
      if (control.type === "checkbox" && control instanceof HTMLInputElement) control.checked = value === true;
      else if (control.type === "radio" && control instanceof HTMLInputElement)
        control.checked = control.value === value;
      else control.value = String(value);
    }
  }

  /** @param {boolean} isPicked whether a section can go through a picked point */
  allowPicked(isPicked) {
    element("section-here", HTMLButtonElement).disabled = !isPicked;
  }

  /**
   * Offers to remove noise, or shows why that is not possible.
   * @param {{ error: string | null } | null} denoiser of the server
   */
  allowDenoising(denoiser) {
    const error = denoiser?.error ?? null;
    element("denoise-row", HTMLElement).hidden = denoiser === null;
    element("denoise", HTMLInputElement).disabled = error !== null;
    element("no-denoiser", HTMLElement).textContent = error ?? "";
    if (!denoiser || error !== null) this.settings.denoise = false;
    this.write();
  }

  /**
   * Updates the values beside the sliders and hides the controls that do not apply to the scene.
   * @param {number} extent metres, of the scene
   * @param {Plane | null} section
   * @param {{ hasMaps: boolean, hasLux: boolean, hasWalls: boolean }} scene
   */
  describe(extent, section, { hasMaps, hasLux, hasWalls }) {
    const { exposure, stripes, isocurves, shading, sectionFlip } = this.settings;
    /** @param {string} id @param {string} text */
    const say = (id, text) => {
      element(`${id}-value`, HTMLElement).textContent = text;
      element(id, HTMLInputElement).setAttribute("aria-valuetext", text);
    };
    say("exposure", `${exposure > 0 ? "+" : ""}${plain(exposure)} EV`);
    say("stripes", String(stripes));
    const curvature = fullColour(this.settings, extent);
    say("curvature", `radius ${lengthText(Number((1 / curvature).toPrecision(3)))}`);
    say("isocurves", isocurves === 0 ? "none" : String(isocurves));
    say("section-offset", section ? lengthText(sectionFlip ? -section.offset : section.offset) : "");
    element("section-picked", HTMLOptionElement).disabled = this.settings.pickedNormal === null;
    element("stripes-row", HTMLElement).hidden = shading !== "zebra";
    element("curvature-row", HTMLElement).hidden = !CURVATURES.includes(shading);
    const { luxScale, luxTail, isolux, isoluxLevels } = this.settings;
    element("walls-row", HTMLElement).hidden = !hasWalls;
    element("light", HTMLElement).hidden = !hasMaps;
    for (const id of ["lux-scale-row", "isolux-row"]) element(id, HTMLElement).hidden = !hasLux;
    element("lux-tail-row", HTMLElement).hidden = !hasLux || luxScale !== "percentile";
    say("lux-tail", `${plain(luxTail)} % at each end`);
    element("isolux-levels-row", HTMLElement).hidden = !hasLux || !isolux;
    const { error } = typedLevels(isoluxLevels);
    element("isolux-levels", HTMLInputElement).setAttribute("aria-invalid", String(error !== ""));
    element("isolux-error", HTMLElement).textContent = error;
  }
}

/**
 * Entry point of the page.
 *
 * @module
 */

import { commandsOf, openFiles, sectionThroughPicked } from "./commands.js";
import { scriptInterface } from "./scripting.js";
import { Page } from "./page.js";
import { element } from "./ui/dom.js";
import { bindFileOpening } from "./ui/files.js";
import { KeyBindings } from "./ui/key_bindings.js";
import { initPanels } from "./ui/panels.js";
import { initThemes } from "./ui/theme.js";

/** @param {unknown} error that prevents the page from starting */
function showFatalError(error) {
  const message = element("message", HTMLElement);
  message.textContent = error instanceof Error ? error.message : String(error);
  message.hidden = false;
}

function start() {
  initPanels();
  const page = new Page();
  new KeyBindings(commandsOf(page));
  initThemes(() => page.invalidate());
  bindFileOpening((files) => openFiles(page, files));
  element("orthographic", HTMLInputElement).addEventListener("change", () => page.viewpoint.switchProjection());
  element("section-here", HTMLButtonElement).addEventListener("click", () => sectionThroughPicked(page));
  Object.assign(window, { glanz: scriptInterface(page) });
}

try {
  start();
} catch (error) {
  showFatalError(error);
}

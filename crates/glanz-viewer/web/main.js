/**
 * Brings the parts of the page together.
 *
 * @module
 */

import { commandsOf, openFiles, sectionThroughPicked } from "./commands.js";
import { handle } from "./handle.js";
import { Page } from "./page.js";
import { element } from "./ui/element.js";
import { offerOpening } from "./ui/files.js";
import { Keys } from "./ui/keys.js";
import { offerPanels } from "./ui/panels.js";
import { offerThemes } from "./ui/theme.js";

/** @param {unknown} error what keeps the page from showing anything */
function giveUp(error) {
  const message = element("message", HTMLElement);
  message.textContent = error instanceof Error ? error.message : String(error);
  message.hidden = false;
}

function start() {
  offerPanels();
  const page = new Page();
  new Keys(commandsOf(page));
  offerThemes(() => page.invalidate());
  offerOpening((files) => openFiles(page, files));
  element("orthographic", HTMLInputElement).addEventListener("change", () => page.viewpoint.switchProjection());
  element("section-here", HTMLButtonElement).addEventListener("click", () => sectionThroughPicked(page));
  Object.assign(window, { glanz: handle(page) });
}

try {
  start();
} catch (error) {
  giveUp(error);
}

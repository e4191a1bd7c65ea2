/**
 * Commands and their key bindings.
 *
 * @module
 */

import { create, element } from "./dom.js";

/**
 * `keys`: as `KeyboardEvent.key` has them, with "Shift+" before those of which Shift makes no other. `onView`: only where the view has the focus, as
 * other elements need these keys themselves.
 * @typedef {{ name: string, keys: string[], label: string, onView?: boolean, run(): void }} Command
 */

/** Names of keys in the help. @type {Record<string, string>} */
const KEY_NAMES = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc", " ": "Space" };

/** Prefix of keys that are pressed with Shift. */
const SHIFT = "Shift+";

/** Elements that take letters as text. */
const TEXT_FIELDS = "input:not([type=checkbox], [type=radio], [type=range], [type=button]), textarea, select";

/** Runs commands by their keys and by the buttons that carry their name. */
export class KeyBindings {
  /** @param {Command[]} commands */
  constructor(commands) {
    this.view = element("view", HTMLElement);
    this.commands = commands;
    document.addEventListener("keydown", (event) => this.press(event));
    for (const button of document.querySelectorAll("button[data-command]")) {
      const command = commands.find(({ name }) => button instanceof HTMLElement && name === button.dataset["command"]);
      button.addEventListener("click", () => command?.run());
      if (command?.keys[0]) button.setAttribute("aria-keyshortcuts", command.keys[0]);
    }
    element("keys", HTMLElement).replaceChildren(...helpRows(commands));
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const target = event.target instanceof Element ? event.target : null;
    if (target?.matches(TEXT_FIELDS) && event.key !== "Escape") return;
    const onView = target === this.view || target === document.body;
    const key = event.shiftKey && event.key.length > 1 ? `${SHIFT}${event.key}` : event.key;
    const command = this.commands.find(({ keys, onView: only }) => keys.includes(key) && (onView || !only));
    if (!command) return;
    event.preventDefault();
    command.run();
  }
}

/**
 * Rows of a table of keys; commands of the same label share one.
 * @param {Command[]} commands
 */
function helpRows(commands) {
  /** @type {Map<string, string[]>} */
  const keysOf = new Map();
  for (const { label, keys } of commands) keysOf.set(label, [...(keysOf.get(label) ?? []), ...keys]);
  return [...keysOf].map(([label, keys]) => {
    const row = create("tr");
    const cell = create("td");
    const withShift = keys.every((key) => key.startsWith(SHIFT));
    if (withShift) cell.append(create("kbd", "Shift"), " + ");
    for (const key of keys) {
      const plain = withShift ? key.slice(SHIFT.length) : key;
      cell.append(create("kbd", KEY_NAMES[plain] ?? plain), " ");
    }
    const heading = create("th", label);
    heading.scope = "row";
    row.append(heading, cell);
    return row;
  });
}

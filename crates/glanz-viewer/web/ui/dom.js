/**
 * Elements of the page.
 *
 * @module
 */

/**
 * The element of the page with this id.
 * @template {Element} T
 * @param {string} id
 * @param {new () => T} type
 * @returns {T}
 * @throws {Error} if there is none of this type
 */
export function element(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`the page has no ${type.name} with the id "${id}"`);
  return found;
}

/**
 * A new element with a text in it.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {string} text
 * @param {string} className
 * @returns {HTMLElementTagNameMap[K]}
 */
export function create(tag, text = "", className = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  made.className = className;
  return made;
}

/**
 * Fills a list with terms and what they are.
 * @param {HTMLElement} list
 * @param {[term: string, description: string][]} rows
 */
export function describe(list, rows) {
  list.replaceChildren(...rows.flatMap(([term, description]) => [create("dt", term), create("dd", description)]));
}

/**
 * Announces a text to screen readers.
 * @param {string} text
 */
export function announce(text) {
  element("live", HTMLElement).textContent = text;
}

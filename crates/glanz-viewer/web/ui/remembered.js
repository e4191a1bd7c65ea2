/**
 * What the browser keeps for the page.
 *
 * @module
 */

/**
 * @param {string} name
 * @param {string} text
 */
export function remember(name, text) {
  try {
    localStorage.setItem(name, text);
  } catch {
    // Browsers that keep nothing for this page start it with what is usual.
  }
}

/**
 * The text that was kept under a name, `null` if there is none.
 * @param {string} name
 */
export function remembered(name) {
  try {
    return localStorage.getItem(name);
  } catch {
    return null;
  }
}

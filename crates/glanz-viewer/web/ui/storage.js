/**
 * Texts in the storage of the browser.
 *
 * @module
 */

/**
 * Stores a text under a name.
 * @param {string} name
 * @param {string} text
 */
export function store(name, text) {
  try {
    localStorage.setItem(name, text);
  } catch {
    // Some browsers store nothing for this page, which then begins with its defaults.
  }
}

/**
 * The text that is stored under a name, `null` if there is none.
 * @param {string} name
 */
export function stored(name) {
  try {
    return localStorage.getItem(name);
  } catch {
    return null;
  }
}

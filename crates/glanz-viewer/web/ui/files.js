/**
 * Opening and saving files.
 *
 * @module
 */

import { announce, element } from "./dom.js";

/** @typedef {{ name: string, file: File }} NamedFile a file and its path */

/**
 * Opens files that are chosen with the button or dropped on the page.
 * @param {(files: NamedFile[]) => void} open
 */
export function bindFileOpening(open) {
  const input = element("files", HTMLInputElement);
  const target = element("drop", HTMLElement);
  element("open", HTMLButtonElement).addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    const files = [...(input.files ?? [])].map((file) => ({ name: file.name, file }));
    // The same files can be chosen again after they were changed.
    input.value = "";
    if (files.length > 0) open(files);
  });
  /** @param {DragEvent} event */
  const carriesFiles = (event) => event.dataTransfer?.types.includes("Files") ?? false;
  document.addEventListener("dragover", (event) => {
    if (!carriesFiles(event)) return;
    event.preventDefault();
    target.hidden = false;
  });
  document.addEventListener("dragleave", (event) => {
    // It also comes for every element that the pointer leaves; only outside of the page is there no other.
    if (!event.relatedTarget) target.hidden = true;
  });
  document.addEventListener("drop", (event) => {
    if (!carriesFiles(event)) return;
    event.preventDefault();
    target.hidden = true;
    if (event.dataTransfer) dropped(event.dataTransfer).then(open);
  });
}

/** Most files that are looked for in dropped folders; the server takes fewer, and says so. */
const MOST_FILES = 1000;

/**
 * The files that were dropped, those in folders with their paths; a folder that was dropped alone is left out of these.
 * @param {DataTransfer} transfer
 * @returns {Promise<NamedFile[]>}
 */
async function dropped(transfer) {
  // Entries must be taken before the first pause: then the browser forgets what was dropped.
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  /** @type {NamedFile[]} */
  const found = [];
  const [only] = entries;
  const alone = entries.length === 1 && only?.isDirectory ? `${only.fullPath}/` : "/";
  for (const entry of entries) await collect(entry, alone, found);
  return found;
}

/**
 * @param {FileSystemEntry} entry
 * @param {string} prefix of the path, left out of the name
 * @param {NamedFile[]} found what is added to
 */
async function collect(entry, prefix, found) {
  if (found.length >= MOST_FILES) return;
  if (entry instanceof FileSystemFileEntry) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    found.push({ name: entry.fullPath.slice(prefix.length), file });
  } else if (entry instanceof FileSystemDirectoryEntry) {
    const reader = entry.createReader();
    // Folders are read in batches, the last of which is empty.
    for (;;) {
      /** @type {FileSystemEntry[]} */
      const piece = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
      if (piece.length === 0) return;
      for (const child of piece) await collect(child, prefix, found);
    }
  }
}

/**
 * Sends files to the server, which opens the scene among them.
 * @param {URL} url
 * @param {NamedFile[]} files
 * @returns {Promise<string | null>} what is wrong with them, or `null`
 */
export async function upload(url, files) {
  const list = JSON.stringify(files.map(({ name, file }) => [name, file.size]));
  const body = new Blob([`${list}\n`, ...files.map(({ file }) => file)]);
  try {
    const response = await fetch(url, { method: "POST", body });
    return response.ok ? null : await response.text();
  } catch {
    return "The server cannot be reached.";
  }
}

/**
 * Shows an error of a scene.
 * @param {string} heading
 * @param {string} text
 */
export function showProblem(heading, text) {
  const dialog = element("problem", HTMLDialogElement);
  element("problem-heading", HTMLElement).textContent = heading;
  element("problem-text", HTMLElement).textContent = text;
  if (!dialog.open) dialog.showModal();
}

/**
 * Saves a file through the browser.
 * @param {Blob} content
 * @param {string} name
 */
export function download(content, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  // The browser has begun to read by then.
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  announce(`Saved ${name}`);
}

/**
 * Files that come to the page and leave it.
 *
 * @module
 */

import { announce, element } from "./element.js";

/**
 * Has the button and dropping files on the page open them.
 * @param {(files: File[]) => void} open
 */
export function offerOpening(open) {
  const input = element("files", HTMLInputElement);
  const target = element("drop", HTMLElement);
  element("open", HTMLButtonElement).addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    const files = [...(input.files ?? [])];
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
    open([...(event.dataTransfer?.files ?? [])]);
  });
}

/**
 * Sends files to the server, which opens the scene among them.
 * @param {URL} url
 * @param {File[]} files
 * @returns {Promise<string | null>} what is wrong with them, or `null`
 */
export async function upload(url, files) {
  const form = new FormData();
  for (const file of files) form.append("files", file, file.name);
  try {
    const response = await fetch(url, { method: "POST", body: form });
    return response.ok ? null : await response.text();
  } catch {
    return "The server cannot be reached.";
  }
}

/**
 * Shows what is wrong with a scene.
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
 * Has the browser keep a file.
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

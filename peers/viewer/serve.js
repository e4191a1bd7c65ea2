// Serves the pages of the comparison, the page code of Glanz, three.js, and a working folder on the loopback interface.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join } from "node:path";

const here = import.meta.dirname;
const web = join(here, "../../crates/glanz-viewer/web");
const kinds = { ".html": "text/html", ".js": "text/javascript" };

/** The file of a path; `null` if there is none. */
function fileOf(path, work) {
  if (path.includes("..")) return null;
  if (/^\/(glanz|three)\.(html|js)$/.test(path) || /^\/node_modules\/three\/build\/[\w./-]+\.js$/.test(path)) return join(here, path);
  if (/^\/web\/[\w./-]+\.js$/.test(path)) return join(web, path.slice("/web".length));
  if (/^\/work\/[\w./-]+$/.test(path)) return join(work, path.slice("/work".length));
  return null;
}

/** A listening server of these pages and of the folder `work`, and its address. */
export function serve(work) {
  const server = createServer(async (request, response) => {
    const file = fileOf(new URL(request.url, "http://localhost").pathname, work);
    try {
      const bytes = await readFile(file);
      response.writeHead(200, { "content-type": kinds[extname(file)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((ready) => {
    server.listen(0, "127.0.0.1", () => ready({ server, address: `http://127.0.0.1:${server.address().port}` }));
  });
}

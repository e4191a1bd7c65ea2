// Renders a model with three.js in a headless Chromium: node three.js MODEL.glb PICTURE.png WIDTHxHEIGHT [--chromium /usr/bin/chromium]
//
// Serves page.html and the model on a free port of the loopback interface. Prints one line of JSON: the versions, the renderer, and all
// messages of the browser's console. OpenGL is the browser's software renderer, so that no graphics card is needed.

import { createServer } from "node:http";
import { readFile, writeFile } from "node:fs/promises";
import { extname, join } from "node:path";
import { parseArgs } from "node:util";

import { chromium } from "playwright-core";

const here = import.meta.dirname;
const kinds = { ".html": "text/html", ".js": "text/javascript", ".glb": "model/gltf-binary" };

/** The files served: the page, its libraries, and the model. */
function fileOf(path, model) {
  if (path === "/model.glb") return model;
  const isOurs = /^\/(page\.html|page\.js|node_modules\/three\/[\w./-]+\.js)$/.test(path) && !path.includes("..");
  return isOurs ? join(here, path) : null;
}

function serve(model) {
  const server = createServer(async (request, response) => {
    const file = fileOf(new URL(request.url, "http://localhost").pathname, model);
    try {
      const bytes = await readFile(file);
      response.writeHead(200, { "content-type": kinds[extname(file)] }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((ready) => server.listen(0, "127.0.0.1", () => ready(server)));
}

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { chromium: { type: "string", default: "/usr/bin/chromium" } },
});
const [model, picture, size] = positionals;
const [width, height] = size.split("x").map(Number);

const server = await serve(model);
const browser = await chromium.launch({
  executablePath: values.chromium,
  // Root has no sandbox; the software renderer has to be enabled by name.
  args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid() === 0 ? ["--no-sandbox"] : [])],
});
try {
  const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
  const said = [];
  page.on("console", (message) => said.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => said.push(`error: ${error.message}`));
  page.on("requestfailed", (request) => said.push(`error: ${request.url()} did not come`));
  await page.goto(`http://127.0.0.1:${server.address().port}/page.html?model=model.glb&width=${width}&height=${height}`);
  const url = await page.evaluate(() => window.picture);
  await writeFile(picture, Buffer.from(url.split(",")[1], "base64"));
  const [revision, drawn] = await page.evaluate(async () => {
    const gl = document.querySelector("canvas").getContext("webgl2");
    const details = gl.getExtension("WEBGL_debug_renderer_info");
    return [(await import("three")).REVISION, gl.getParameter(details.UNMASKED_RENDERER_WEBGL)];
  });
  console.log(JSON.stringify({ three: revision, chromium: browser.version(), drawn, said }));
} finally {
  await browser.close();
  server.close();
}

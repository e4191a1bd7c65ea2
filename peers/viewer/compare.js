#!/usr/bin/env node
// Comparison of the page of `glanz view` with three.js, which draws a tessellation of the same surfaces.
//
//     apt-get install chromium nodejs npm
//     (cd peers/viewer && npm ci)
//     peers/viewer/compare.js zoom [--out docs/images/viewer-zoom.png]
//     peers/viewer/compare.js measure [--out benches/results/DATE-viewer]
//         [--chromium /usr/bin/chromium] [--profile release] [--size 400x300] [--frames 12]
//
// OpenGL is the browser's software renderer, so that no graphics card is needed; times are processor-bound.
//
// `zoom`: magnifies a hole and a highlight 100 times in both. The triangles are those of viewers that tessellate a model on loading:
// within a thousandth of the size of the object, with the surface's normals at their vertices. Look at the picture.
//
// `measure`: for fields of bicubic patches that fill the picture,
//   - the frame time over the number of patches, with a rotating camera and each frame completed: the page's renderer, and three.js
//     with triangles within a quarter of a pixel of the surface at the middle of the view, which is the tolerance of the page. Materials,
//     lights and samples per pixel are the same, and both draw shadow maps once. Rounds of both alternate; medians of frames;
//   - the first picture: the time from the start of navigation until the page of `glanz view` has drawn 1008 patches, and bytes per patch.

import { execFileSync, spawn } from "node:child_process";
import { mkdir, mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";

import { chromium } from "playwright-core";

import { writeField } from "./field.js";
import { plot, table } from "./report.js";
import { serve } from "./serve.js";
import { sheet } from "./sheet.js";

const root = join(import.meta.dirname, "../..");

/** The magnified objects: `target` in fractions of the picture from its upper left, `tolerance` a thousandth of the size, metres. */
const ZOOMS = [
  { scene: "plate.pbrt", what: "a hole", target: [0.5486, 0.6454], tolerance: 0.005 },
  { scene: "teapot.pbrt", what: "a highlight", target: [0.7963, 0.5583], tolerance: 0.006 },
];

/** Magnification, and size of the pictures. */
const ZOOM = 100;
const ZOOM_SIZE = [480, 360];

/** Columns and rows of patches of the fields. */
const FIELDS = [
  [4, 3],
  [12, 9],
  [36, 28],
  [82, 61],
];

/** The field whose first picture is timed, and the number of repetitions. */
const FIRST = [36, 28];
const LOADS = 5;

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    chromium: { type: "string", default: "/usr/bin/chromium" },
    profile: { type: "string", default: "release" },
    size: { type: "string", default: "400x300" },
    frames: { type: "string", default: "12" },
    out: { type: "string" },
  },
});

/** The paths of the command line and of glanz.rs. */
function built() {
  const cargo = ["build", "--profile", values.profile, "-p", "glanz-cli", "--bin", "glanz", "--example", "viewer", "--message-format=json"];
  const said = execFileSync("cargo", cargo, { cwd: root, encoding: "utf8", maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "inherit"] });
  const made = said.split("\n").flatMap((line) => (line.startsWith("{") ? [JSON.parse(line)] : []));
  const path = (name) => made.find((message) => message.executable && message.target?.name === name).executable;
  return { glanz: path("glanz"), viewer: path("viewer") };
}

/** The JSON part of a model. */
async function modelIn(folder) {
  const bytes = await readFile(join(folder, "model"));
  const text = bytes.subarray(16, 16 + bytes.readUInt32LE(8)).toString();
  return { ...JSON.parse(text), bytes: bytes.length };
}

/** Runs glanz.rs to write the model and the mesh of a scene; returns its description of the mesh. */
async function prepare(program, scene, folder, tolerance) {
  await mkdir(folder, { recursive: true });
  const about = execFileSync(program, [scene, folder, String(tolerance)], { encoding: "utf8" });
  await writeFile(join(folder, "about.json"), about);
  return JSON.parse(about);
}

/** A page that fails on errors and warnings of its console. */
async function quiet(browser, size) {
  const page = await browser.newPage({ viewport: { width: size[0], height: size[1] } });
  const faults = [];
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
  return { page, faults };
}

/** Opens glanz.html or three.html on what is in a folder of the server; `await page.evaluate(() => window.viewer)` waits for it. */
async function open(browser, address, kind, name, size, more = "") {
  const { page, faults } = await quiet(browser, size);
  const folder = `work/${name}`;
  const mesh = `&mesh=${folder}/mesh&about=${folder}/about.json`;
  await page.goto(`${address}/${kind}.html?model=${folder}/model${mesh}&width=${size[0]}&height=${size[1]}${more}`);
  await page.evaluate(() => window.viewer.then(() => true));
  if (faults.length > 0) throw new Error(`${kind}.html: ${faults.join("; ")}`);
  return page;
}

/** The picture of a camera, as PNG. */
async function picture(page, camera) {
  await page.evaluate(async (camera) => {
    const viewer = await window.viewer;
    // The picture is incomplete until all programs are compiled.
    while (viewer.draw(camera).pending > 0) await new Promise((later) => setTimeout(later, 20));
    await new Promise((drawn) => requestAnimationFrame(drawn));
    viewer.draw(camera);
  }, camera);
  return page.locator("canvas").screenshot();
}

const add = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/** A camera at the same position, centred on a point of the picture and magnified. */
function zoomed(camera, [x, y], [width, height], factor) {
  const half = Math.tan(camera.fieldOfView / 2) / Math.min(width, height);
  const across = add(
    camera.right.map((r) => r * (2 * x - 1) * width * half),
    camera.up,
    (1 - 2 * y) * height * half,
  );
  const forward = unit(add(camera.forward, across));
  const right = unit(add(camera.right, forward, -dot(camera.right, forward)));
  const level = add(camera.up, forward, -dot(camera.up, forward));
  const up = unit(add(level, right, -dot(level, right)));
  return { ...camera, forward, right, up, fieldOfView: 2 * Math.atan(Math.tan(camera.fieldOfView / 2) / factor) };
}

/** A camera rotated about the vertical axis through a point, radians. */
function turned(camera, middle, angle) {
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  const turn = ([x, y, z]) => [cos * x - sin * y, sin * x + cos * y, z];
  const position = add(middle, turn(add(camera.position, middle, -1)));
  return { ...camera, position, right: turn(camera.right), up: turn(camera.up), forward: turn(camera.forward) };
}

async function zoom(programs, browser, address, work) {
  const rows = [];
  for (const { scene, what, target, tolerance } of ZOOMS) {
    const name = scene.replace(".pbrt", "");
    const about = await prepare(programs.viewer, join(root, "scenes", scene), join(work, name), tolerance);
    const { camera, bytes } = await modelIn(join(work, name));
    const kilobytes = Math.round(bytes / 1000);
    const near = zoomed(camera, target, ZOOM_SIZE, ZOOM);
    const ours = await open(browser, address, "glanz", name, ZOOM_SIZE);
    const theirs = await open(browser, address, "three", name, ZOOM_SIZE);
    const [count, distance] = [about.triangles.toLocaleString("en"), 1000 * tolerance];
    rows.push([
      { bytes: await picture(ours, camera), mark: target, caption: `${scene} in Glanz; ringed: ${what}` },
      { bytes: await picture(ours, near), caption: `in Glanz, ${ZOOM} times: the surface itself, from ${kilobytes} kB` },
      { bytes: await picture(theirs, near), caption: `in three.js, ${ZOOM} times: ${count} triangles within ${distance} mm (1/1000)` },
    ]);
    await ours.close();
    await theirs.close();
  }
  const out = values.out ?? join(root, "docs/images/viewer-zoom.png");
  await writeFile(out, await sheet(browser, rows, ZOOM_SIZE));
  console.log(out);
}

const median = (numbers) => numbers.toSorted((a, b) => a - b)[Math.floor(numbers.length / 2)];

/** Frame times of both over fields of patches. */
async function frames(programs, browser, address, work) {
  const size = values.size.split("x").map(Number);
  const rows = [];
  for (const [columns, lines] of FIELDS) {
    const { file, distance } = await writeField(work, columns, lines);
    const name = `${columns * lines}`;
    const tolerance = (((2 * distance * Math.tan(Math.PI / 12)) / size[1]) * 0.25).toFixed(9);
    const about = await prepare(programs.viewer, file, join(work, name), tolerance);
    const { camera } = await modelIn(join(work, name));
    const pages = {};
    for (const kind of ["glanz", "three"]) pages[kind] = await open(browser, address, kind, name, size, "&shadows");
    const times = { glanz: [], three: [] };
    const statistics = {};
    for (let round = 0; round < 4; round++) {
      for (const [kind, page] of Object.entries(pages)) {
        await page.bringToFront();
        if (round === 0) await picture(page, camera);
        statistics[kind] = await page.evaluate(async (camera) => (await window.viewer).draw(camera), camera);
        const angle = (i) => 0.01 * (i + 1 + round * Number(values.frames));
        const cameras = Array.from({ length: Number(values.frames) }, (_, i) => turned(camera, [columns / 2, lines / 2, 0], angle(i)));
        const found = await page.evaluate(async (cameras) => (await window.viewer).time(cameras), cameras);
        // One-time work is done in the first round.
        if (round > 0) times[kind].push(...found);
      }
    }
    const row = {
      patches: columns * lines,
      glanz: median(times.glanz),
      three: median(times.three),
      ratio: median(times.glanz) / median(times.three),
      triangles: { glanz: statistics.glanz.triangles, three: about.triangles },
      bytes: { glanz: (await modelIn(join(work, name))).bytes, three: 24 * about.vertices + 12 * about.triangles },
      times,
    };
    console.error(JSON.stringify({ ...row, times: undefined }));
    rows.push(row);
    for (const page of Object.values(pages)) await page.close();
  }
  return rows;
}

/** A running `glanz view`, and its address. */
function view(program, scene) {
  const server = spawn(program, ["view", scene, "--no-open", "--port", "0"], { stdio: ["ignore", "pipe", "pipe"] });
  return new Promise((ready, failed) => {
    let said = "";
    const listen = (text) => {
      said += text;
      const found = /http:\/\/\S+/.exec(said);
      if (found) ready({ server, address: found[0] });
    };
    server.stdout.on("data", listen);
    server.stderr.on("data", listen);
    server.on("exit", () => failed(new Error(`glanz view: ${said}`)));
  });
}

/** Milliseconds from the start of navigation to the first picture, for several loads, and bytes sent. */
async function first(programs, browser, work) {
  const { file } = await writeField(work, ...FIRST);
  const { server, address } = await view(programs.glanz, file);
  try {
    const loads = [];
    let sent = null;
    for (let load = 0; load < LOADS; load++) {
      const { page, faults } = await quiet(browser, values.size.split("x").map(Number));
      await page.addInitScript(() => {
        let own;
        Object.defineProperty(window, "glanz", {
          get: () => own,
          set: (value) => {
            own = value;
            window.firstPicture = value.ready.then(() => performance.now());
          },
        });
      });
      await page.goto(address);
      await page.waitForFunction(() => window.firstPicture);
      loads.push(await page.evaluate(() => window.firstPicture));
      sent = await page.evaluate(() => {
        const entries = performance
          .getEntriesByType("resource")
          .map(({ name, encodedBodySize }) => [new URL(name).pathname, encodedBodySize]);
        const of = (isWanted) => entries.filter(([path]) => isWanted(path)).reduce((sum, [, bytes]) => sum + bytes, 0);
        return { model: of((path) => path.startsWith("/model/")), page: of((path) => !path.startsWith("/model/")) };
      });
      if (faults.length > 0) throw new Error(`glanz view: ${faults.join("; ")}`);
      await page.close();
    }
    const patches = FIRST[0] * FIRST[1];
    return { patches, loads, median: median(loads), sent, bytesPerPatch: sent.model / patches };
  } finally {
    server.removeAllListeners("exit");
    server.kill();
  }
}

async function measure(programs, browser, address, work) {
  const found = {
    chromium: browser.version(),
    size: values.size,
    profile: values.profile,
    first: await first(programs, browser, work),
    frames: await frames(programs, browser, address, work),
  };
  const out = values.out ?? join(root, `benches/results/${new Date().toISOString().slice(0, 10)}-viewer`);
  await mkdir(out, { recursive: true });
  await writeFile(join(out, "figures.json"), `${JSON.stringify(found)}\n`);
  await writeFile(join(out, "frame-time.svg"), plot(found.frames));
  console.log(table(found));
}

const commands = { zoom, measure };
const command = commands[positionals[0]];
if (!command || positionals.length !== 1) {
  console.error(`usage: compare.js ${Object.keys(commands).join("|")} [options], see the head of the file`);
  process.exit(2);
}
const programs = built();
const work = await mkdtemp(join(tmpdir(), "glanz-viewer-"));
const { server, address } = await serve(work);
const browser = await chromium.launch({
  executablePath: values.chromium,
  // Root has no sandbox; the software renderer has to be enabled by name.
  args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(process.getuid() === 0 ? ["--no-sandbox"] : [])],
});
try {
  await command(programs, browser, address, work);
} finally {
  await browser.close();
  server.close();
  await rm(work, { recursive: true });
}

// The measurements as a table and as a plot.

const number = (x) => x.toLocaleString("en", Number.isInteger(x) ? {} : { maximumSignificantDigits: 3 });

/** The figures in Markdown. */
export function table({ first, frames }) {
  const lines = [
    `First picture of ${first.patches} patches: ${number(first.median)} ms after the start of navigation (median of ${first.loads.length}), ` +
      `${number(first.bytesPerPatch)} bytes per patch of ${number(first.sent.model)} in all; the page itself: ${number(first.sent.page)} bytes.`,
    "",
    "| patches | Glanz, ms | three.js, ms | ratio | triangles of Glanz' grids | triangles in three.js | MB of the model | MB of the mesh |",
    "|---|---|---|---|---|---|---|---|",
  ];
  for (const { patches, glanz, three, ratio, triangles, bytes } of frames) {
    const cells = [patches, glanz, three, ratio, triangles.glanz, triangles.three, bytes.glanz / 1e6, bytes.three / 1e6];
    lines.push(`| ${cells.map(number).join(" | ")} |`);
  }
  return lines.join("\n");
}

const [WIDTH, HEIGHT] = [640, 420];
const [LEFT, RIGHT, TOP, BOTTOM] = [70, 40, 40, 60];

/** Powers of ten around all numbers. */
function decades(numbers) {
  return [Math.floor(Math.log10(Math.min(...numbers))), Math.ceil(Math.log10(Math.max(...numbers)))];
}

/** Frame times over numbers of patches, both axes logarithmic, as SVG. */
export function plot(frames) {
  const [x0, x1] = decades(frames.map((row) => row.patches));
  const [y0, y1] = decades(frames.flatMap((row) => [row.glanz, row.three]));
  const x = (patches) => LEFT + ((Math.log10(patches) - x0) / (x1 - x0)) * (WIDTH - LEFT - RIGHT);
  const y = (time) => HEIGHT - BOTTOM - ((Math.log10(time) - y0) / (y1 - y0)) * (HEIGHT - TOP - BOTTOM);
  const parts = [];
  for (let power = x0; power <= x1; power++) {
    const at = x(10 ** power);
    parts.push(`<line x1="${at}" y1="${TOP}" x2="${at}" y2="${HEIGHT - BOTTOM}" stroke="#ddd"/>`);
    parts.push(`<text x="${at}" y="${HEIGHT - BOTTOM + 18}" text-anchor="middle">${(10 ** power).toLocaleString("en")}</text>`);
  }
  for (let power = y0; power <= y1; power++) {
    const at = y(10 ** power);
    parts.push(`<line x1="${LEFT}" y1="${at}" x2="${WIDTH - RIGHT}" y2="${at}" stroke="#ddd"/>`);
    parts.push(`<text x="${LEFT - 8}" y="${at + 4}" text-anchor="end">${(10 ** power).toLocaleString("en")}</text>`);
  }
  const lines = [
    ["glanz", "Glanz", "#0062b1", "", -10],
    ["three", "three.js", "#b14700", "6 4", 24],
  ];
  for (const [key, name, colour, dashes, below] of lines) {
    const points = frames.map((row) => [x(row.patches), y(row[key])]);
    const path = points.map((point) => point.map((c) => c.toFixed(1)).join(",")).join(" ");
    parts.push(`<polyline points="${path}" fill="none" stroke="${colour}" stroke-width="2" stroke-dasharray="${dashes}"/>`);
    parts.push(...points.map(([cx, cy]) => `<circle cx="${cx.toFixed(1)}" cy="${cy.toFixed(1)}" r="3.5" fill="${colour}"/>`));
    const [lastX, lastY] = points[points.length - 1];
    parts.push(`<text x="${lastX.toFixed(1)}" y="${(lastY + below).toFixed(1)}" text-anchor="end" fill="${colour}">${name}</text>`);
  }
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" font-family="sans-serif" font-size="13">
<rect width="${WIDTH}" height="${HEIGHT}" fill="white"/>
${parts.join("\n")}
<text x="${(LEFT + WIDTH - RIGHT) / 2}" y="${HEIGHT - 16}" text-anchor="middle">bicubic patches in sight</text>
<text transform="translate(18 ${(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)" text-anchor="middle">time of a frame, ms</text>
<text x="${WIDTH / 2}" y="22" text-anchor="middle">Both within a quarter of a pixel of the surface; OpenGL in software</text>
</svg>
`;
}

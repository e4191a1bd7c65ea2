// Scenes of bicubic patches: a field of bumps that fills the picture.

import { writeFile } from "node:fs/promises";
import { join } from "node:path";

/** Height of the bumps over the field and its derivatives by x, y, and both; a patch is 1 m wide, a bump about two patches. */
function surface(x, y) {
  const [a, b] = [2.9, 3.3];
  const [sx, cx, sy, cy] = [Math.sin(a * x), Math.cos(a * x), Math.sin(b * y), Math.cos(b * y)];
  const h = 0.12;
  return { z: h * sx * sy, x: h * a * cx * sy, y: h * b * sx * cy, xy: h * a * b * cx * cy };
}

/** The control points of the bicubic patch that has the surface's heights and derivatives at its corners. */
function patch(column, row) {
  const points = [];
  for (let j = 0; j < 4; j++) {
    for (let i = 0; i < 4; i++) {
      const corner = surface(column + (i > 1 ? 1 : 0), row + (j > 1 ? 1 : 0));
      // Thirds of derivatives towards the inner points.
      const dx = i === 1 ? 1 / 3 : i === 2 ? -1 / 3 : 0;
      const dy = j === 1 ? 1 / 3 : j === 2 ? -1 / 3 : 0;
      points.push([column + i / 3, row + j / 3, corner.z + dx * corner.x + dy * corner.y + dx * dy * corner.xy]);
    }
  }
  return points;
}

/**
 * Writes a scene of `columns` x `rows` patches, and returns its file and the camera's distance.
 * Half the angle of view over the height is 15 degrees.
 */
export async function writeField(folder, columns, rows) {
  const name = `field-${columns * rows}`;
  const patches = [];
  const points = [];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const first = points.length + 1;
      points.push(...patch(column, row));
      patches.push(Array.from({ length: 16 }, (_, i) => first + i).join(","));
    }
  }
  const list = points.map((point) => point.map((x) => x.toFixed(9)).join(","));
  await writeFile(join(folder, `${name}.txt`), [patches.length, ...patches, points.length, ...list].join("\n") + "\n");
  // Obliquely from above, close enough that the field fills the picture.
  const distance = (0.5 * rows) / Math.tan((15 * Math.PI) / 180);
  const middle = [columns / 2, rows / 2, 0];
  const eye = [middle[0], middle[1] - 0.6 * distance, 0.8 * distance];
  const scene = `LookAt ${eye.join(" ")}  ${middle.join(" ")}  0 0 1
Camera "perspective" "float fov" 30
Film "rgb" "integer xresolution" 400 "integer yresolution" 300
WorldBegin
LightSource "distant" "point3 from" [-2 -3 4] "point3 to" [0 0 0] "rgb L" [2.5 2.5 2.5]
LightSource "infinite" "rgb L" [0.1 0.1 0.1]
Material "diffuse" "rgb reflectance" [0.5 0.45 0.4]
Shape "patchmesh" "string filename" "${name}.txt"
`;
  const file = join(folder, `${name}.pbrt`);
  await writeFile(file, scene);
  return { file, distance };
}

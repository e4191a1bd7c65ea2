/**
 * The camera and its navigation: orbit, pan, zoom, fit, standard views.
 *
 * Functions from a camera to a new one; none changes its arguments. Positions are in metres and directions of length 1, both in the world, angles in radians,
 * pixels count from the upper left corner of the picture with y downwards. A camera's `right`, `up` and `forward` may be of either handedness:
 * mirrored worlds are left as they are.
 *
 * @module
 */

import { add, cross, dot, length, normalize, scale, subtract } from "./linear.js";

/** @typedef {[number, number, number]} Vector */

/**
 * `fieldOfView`: radians over the shorter side. `height`: metres over the shorter side (orthographic). `distance`: metres to what it looks at.
 * @typedef {{ kind: "perspective" | "orthographic", position: Vector, right: Vector, up: Vector, forward: Vector,
 *   fieldOfView: number, height: number, distance: number }} Camera
 */

/** @typedef {{ width: number, height: number }} Size pixels */
/** @typedef {[Vector, Vector]} Bounds lowest and highest corner */
/** @typedef {"front" | "back" | "left" | "right" | "top" | "bottom" | "isometric"} StandardView */

/** Right angle: how far up and down a turntable goes. */
const QUARTER = Math.PI / 2;

/** Of the picture's sides, what is left free around a fitted scene. */
const FIT_MARGIN = 0.06;

/** Field of view for scenes whose own camera is orthographic. */
const USUAL_FIELD_OF_VIEW = (40 * Math.PI) / 180;

/**
 * A camera as the server sends it, with defaults for the fields that its projection does not use.
 * @param {Camera | (Omit<Camera, "fieldOfView" | "height"> & { fieldOfView?: number | null, height?: number | null })} sent
 * @returns {Camera}
 */
export function withDefaults(sent) {
  const distance = sent.distance > 0 ? sent.distance : 1;
  const fieldOfView = sent.fieldOfView || USUAL_FIELD_OF_VIEW;
  const height = sent.height || 2 * distance * Math.tan(fieldOfView / 2);
  return { ...sent, distance, fieldOfView, height };
}

/**
 * The camera with its field of view widened so that the whole of a picture of another aspect ratio is visible.
 * @param {Camera} camera
 * @param {number} aspect width over height of that picture
 * @param {Size} size of the one that is drawn
 * @returns {Camera}
 */
export function framed(camera, aspect, size) {
  const ratio = size.width / size.height;
  const [x, y] = aspect >= 1 ? [aspect, 1] : [1, 1 / aspect];
  const wider = ratio >= 1 ? Math.max(y, x / ratio) : Math.max(x, y * ratio);
  const fieldOfView = 2 * Math.atan(wider * Math.tan(camera.fieldOfView / 2));
  return { ...camera, fieldOfView, height: wider * camera.height };
}

/**
 * Half of the picture's sides as tangents (perspective) or metres (orthographic).
 * @param {Camera} camera
 * @param {Size} size
 * @returns {{ x: number, y: number }}
 */
export function halfSides(camera, size) {
  const short = Math.min(size.width, size.height);
  const half = camera.kind === "perspective" ? Math.tan(camera.fieldOfView / 2) : camera.height / 2;
  return { x: (half * size.width) / short, y: (half * size.height) / short };
}

/**
 * Metres across one pixel at a depth (metres along `forward`).
 * @param {Camera} camera
 * @param {Size} size
 * @param {number} depth
 */
export function metresPerPixel(camera, size, depth) {
  const perDepth = (2 * halfSides(camera, size).y) / size.height;
  return camera.kind === "perspective" ? perDepth * depth : perDepth;
}

/**
 * The ray that a point of the picture sees.
 * @param {Camera} camera
 * @param {Size} size
 * @param {number} x
 * @param {number} y
 * @returns {{ origin: Vector, direction: Vector }}
 */
export function rayThrough(camera, size, x, y) {
  const half = halfSides(camera, size);
  const across = scale(camera.right, half.x * ((2 * x) / size.width - 1));
  const upwards = scale(camera.up, half.y * (1 - (2 * y) / size.height));
  const aside = add(across, upwards);
  if (camera.kind === "perspective") {
    return { origin: camera.position, direction: normalize(add(camera.forward, aside)) };
  }
  return { origin: add(camera.position, aside), direction: camera.forward };
}

/**
 * Pixel of a world point, `null` behind the camera.
 * @param {Camera} camera
 * @param {Size} size
 * @param {Vector} point
 * @returns {{ x: number, y: number, depth: number } | null}
 */
export function project(camera, size, point) {
  const from = subtract(point, camera.position);
  const depth = dot(from, camera.forward);
  if (camera.kind === "perspective" && !(depth > 0)) {
    return null;
  }
  const half = halfSides(camera, size);
  const divisor = camera.kind === "perspective" ? depth : 1;
  return {
    x: ((dot(from, camera.right) / (half.x * divisor) + 1) * size.width) / 2,
    y: ((1 - dot(from, camera.up) / (half.y * divisor)) * size.height) / 2,
    depth,
  };
}

/**
 * The point of the world at a depth behind a point of the picture.
 * @param {Camera} camera
 * @param {Size} size
 * @param {number} x
 * @param {number} y
 * @param {number} depth
 * @returns {Vector}
 */
export function pointAt(camera, size, x, y, depth) {
  const ray = rayThrough(camera, size, x, y);
  return add(ray.origin, scale(ray.direction, depth / dot(ray.direction, camera.forward)));
}

/**
 * Focus of the camera: the point in the middle of the picture at its `distance`.
 * @param {Camera} camera
 * @returns {Vector}
 */
export function focus(camera) {
  return add(camera.position, scale(camera.forward, camera.distance));
}

/**
 * +1 or -1: the sign of the determinant of right, up, forward.
 * @param {Camera} camera
 */
export function handedness(camera) {
  return dot(cross(camera.right, camera.up), camera.forward) < 0 ? -1 : 1;
}

/**
 * The same camera with orthonormal axes; rounding errors accumulate otherwise.
 * @param {Camera} camera
 * @returns {Camera}
 */
function orthonormalized(camera) {
  const hand = handedness(camera);
  const forward = normalize(camera.forward);
  const up = normalize(subtract(camera.up, scale(forward, dot(camera.up, forward))));
  return { ...camera, forward, up, right: scale(cross(up, forward), hand) };
}

/**
 * The camera with its directions, and its place as seen from `center`, mapped by a rotation.
 * @param {Camera} camera
 * @param {Vector} center
 * @param {(vector: Vector) => Vector} rotation
 * @returns {Camera}
 */
export function rotated(camera, center, rotation) {
  return orthonormalized({
    ...camera,
    position: add(center, rotation(subtract(camera.position, center))),
    right: rotation(camera.right),
    up: rotation(camera.up),
    forward: rotation(camera.forward),
  });
}

/**
 * The rotation in the plane of two directions at right angles, from the first to the second.
 * @param {Vector} from
 * @param {Vector} to
 * @param {number} angle
 * @returns {(vector: Vector) => Vector}
 */
export function rotationInPlane(from, to, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return (vector) => {
    const [a, b] = [dot(vector, from), dot(vector, to)];
    const inPlane = add(scale(from, a * cos - b * sin - a), scale(to, a * sin + b * cos - b));
    return add(vector, inPlane);
  };
}

/**
 * Elevation and horizontal heading of the camera.
 * @param {Camera} camera
 * @param {Vector} worldUp
 * @returns {{ elevation: number, ahead: Vector }}
 */
function attitude(camera, worldUp) {
  const sin = dot(camera.forward, worldUp);
  const flat = subtract(camera.forward, scale(worldUp, sin));
  // A level camera knows its heading from its `up` too, at the poles from that alone.
  const level = Math.abs(dot(camera.right, worldUp)) < 1e-6 || length(flat) < 1e-6;
  if (level) {
    const cos = dot(camera.up, worldUp);
    const heading = subtract(scale(camera.forward, cos), scale(camera.up, sin));
    const ahead = normalize(subtract(heading, scale(worldUp, dot(heading, worldUp))));
    return { elevation: Math.atan2(sin, cos), ahead };
  }
  return { elevation: Math.asin(Math.max(-1, Math.min(1, sin))), ahead: normalize(flat) };
}

/**
 * Turns the camera about a point as if the scene stood on a turntable: about `worldUp`, and up or down as far as the poles.
 * @param {Camera} camera
 * @param {Vector} worldUp
 * @param {Vector} center
 * @param {number} toRight how far what is before the center goes to the right
 * @param {number} toBottom how far it goes down: the camera rises
 * @returns {Camera}
 */
export function orbited(camera, worldUp, center, toRight, toBottom) {
  const { elevation, ahead } = attitude(camera, worldUp);
  const target = Math.max(-QUARTER, Math.min(QUARTER, elevation - toBottom));
  const tilted = rotated(camera, center, rotationInPlane(ahead, worldUp, target - elevation));
  const aside = cross(worldUp, ahead);
  return rotated(tilted, center, rotationInPlane(ahead, aside, toRight * handedness(camera)));
}

/**
 * Moves the camera aside, so that what is at `depth` goes along with a cursor that moves by so many pixels.
 * @param {Camera} camera
 * @param {Size} size
 * @param {number} depth
 * @param {number} dx
 * @param {number} dy
 * @returns {Camera}
 */
export function panned(camera, size, depth, dx, dy) {
  const metres = metresPerPixel(camera, size, depth);
  const step = add(scale(camera.right, -dx * metres), scale(camera.up, dy * metres));
  return { ...camera, position: add(camera.position, step) };
}

/**
 * Goes nearer to a point, which stays where it is in the picture.
 * @param {Camera} camera
 * @param {Vector} point
 * @param {number} factor below 1: nearer
 * @returns {Camera}
 */
export function zoomed(camera, point, factor) {
  const offset = subtract(camera.position, point);
  const along = camera.kind === "perspective" ? 0 : dot(offset, camera.forward) * (1 - factor);
  return {
    ...camera,
    position: add(add(point, scale(offset, factor)), scale(camera.forward, along)),
    height: camera.height * factor,
    distance: camera.kind === "perspective" ? camera.distance * factor : camera.distance,
  };
}

/**
 * The eight corners of a box.
 * @param {Bounds} bounds
 * @returns {Vector[]}
 */
export function corners(bounds) {
  return Array.from({ length: 8 }, (_, i) => [bounds[i & 1][0], bounds[(i >> 1) & 1][1], bounds[(i >> 2) & 1][2]]);
}

/**
 * The camera, turned as it is, moved so that a box just fits into the picture.
 * @param {Camera} camera
 * @param {Size} size
 * @param {Bounds} bounds
 * @returns {Camera}
 */
export function fitted(camera, size, bounds) {
  const middle = scale(add(bounds[0], bounds[1]), 0.5);
  // A point has no size to fit: it is given that of a grain.
  const diagonal = Math.max(length(subtract(bounds[1], bounds[0])), 1e-6);
  const box = corners(bounds).map((corner) => {
    const offset = subtract(corner, middle);
    return { x: dot(offset, camera.right), y: dot(offset, camera.up), z: dot(offset, camera.forward) };
  });
  const half = halfSides({ ...camera, height: 2 }, size);
  const sides = { x: half.x * (1 - FIT_MARGIN), y: half.y * (1 - FIT_MARGIN) };
  if (camera.kind === "orthographic") {
    const reach = Math.max(...box.map((p) => Math.max(Math.abs(p.x) / sides.x, Math.abs(p.y) / sides.y)));
    const height = 2 * Math.max(reach, diagonal / 1000);
    const distance = Math.max(camera.distance, diagonal);
    return { ...camera, height, distance, position: subtract(middle, scale(camera.forward, distance)) };
  }
  /** @param {"x" | "y"} axis how far aside and back the camera must be for all corners to be between two sides of the picture */
  const apex = (axis) => {
    const most = Math.max(...box.map((p) => p[axis] - sides[axis] * p.z));
    const least = Math.max(...box.map((p) => -p[axis] - sides[axis] * p.z));
    return { aside: (most - least) / 2, back: (most + least) / (2 * sides[axis]) };
  };
  const [x, y] = [apex("x"), apex("y")];
  const back = Math.max(x.back, y.back, diagonal / 1000);
  const aside = add(scale(camera.right, x.aside), scale(camera.up, y.aside));
  const position = add(middle, subtract(aside, scale(camera.forward, back)));
  return { ...camera, position, distance: back, height: 2 * back * Math.tan(camera.fieldOfView / 2) };
}

/**
 * The camera in one of the usual directions, at the same distance from `center`.
 * @param {Camera} camera
 * @param {Vector} worldUp one of the axes, of either sign
 * @param {Vector} center
 * @param {StandardView} view
 * @returns {Camera}
 */
export function standard(camera, worldUp, center, view) {
  const hand = handedness(camera);
  // Seen from the front, one looks along y where z is up, and against z where y is up.
  /** @type {Vector} */
  const front = worldUp[1] === 0 ? [0, 1, 0] : [0, 0, -1];
  const aside = scale(cross(worldUp, front), hand);
  const down = scale(worldUp, -1);
  /** @type {Record<StandardView, [Vector, Vector]>} */
  const directions = {
    front: [front, worldUp],
    back: [scale(front, -1), worldUp],
    right: [scale(aside, -1), worldUp],
    left: [aside, worldUp],
    top: [down, front],
    bottom: [worldUp, scale(front, -1)],
    isometric: [add(add(front, scale(aside, -1)), down), worldUp],
  };
  const [along, up] = directions[view];
  const forward = normalize(along);
  const turned = orthonormalized({ ...camera, forward, up, right: scale(cross(up, forward), hand) });
  const distance = Math.max(dot(subtract(center, camera.position), camera.forward), camera.distance * 1e-3);
  return { ...turned, distance, position: subtract(center, scale(forward, distance)) };
}

/**
 * From perspective to orthographic or back, with the same size of what is as deep as `center`.
 * @param {Camera} camera
 * @param {Vector} center
 * @returns {Camera}
 */
export function otherProjection(camera, center) {
  const depth = dot(subtract(center, camera.position), camera.forward);
  const tangent = Math.tan(camera.fieldOfView / 2);
  if (camera.kind === "perspective") {
    const distance = Math.max(depth, camera.distance * 1e-3);
    // The point in the middle of the picture stays there, not `center`: parallel rays would move it.
    return { ...camera, kind: "orthographic", distance, height: 2 * distance * tangent };
  }
  const distance = camera.height / (2 * tangent);
  const position = add(camera.position, scale(camera.forward, depth - distance));
  return { ...camera, kind: "perspective", distance, position };
}

/**
 * An orthographic camera moved back until the whole box is in front of it.
 * @param {Camera} camera
 * @param {Bounds} bounds
 * @returns {Camera}
 */
export function movedBehind(camera, bounds) {
  if (camera.kind === "perspective") {
    return camera;
  }
  const depths = corners(bounds).map((corner) => dot(subtract(corner, camera.position), camera.forward));
  const nearest = Math.min(...depths);
  const room = (Math.max(...depths) - nearest) / 100;
  if (nearest >= 0) {
    return camera;
  }
  const back = room - nearest;
  return {
    ...camera,
    distance: camera.distance + back,
    position: subtract(camera.position, scale(camera.forward, back)),
  };
}

#!/usr/bin/env python3
"""A hall with 1000 lights: Glanz, Mitsuba 3 and Cycles with and without its light tree, at the same number of samples.

    peers/scenes/hall.py --glanz target/release/glanz --cycles PYTHON [--json FILE]

`--cycles`: a Python interpreter with Blender's module bpy. Each program renders independent pictures; the error of a picture is measured against the mean of
the others by the same program, so that no program is judged by another one's noise. The means of the programs must agree.
"""

import argparse
import json
import math
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import drjit
import mitsuba
import numpy

import languages
from languages import box, diffuse, point, rectangle, transform

HALF = (10.0, 2.0, 6.0)
SQUARE = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]


def hall(scene: languages.Scene, count: int) -> dict[str, object]:
    """Fills the scene; returns the same for Cycles: walls, squares and points that emit, camera."""
    random = numpy.random.default_rng(1)
    width, height, depth = HALF
    grey = diffuse(0.6)
    eye, target = (-9.0, 2.2, 5.0), (2.0, 1.2, -1.0)
    scene.look_at(eye, target, fov=60)
    scene.depth = 3
    cycles: dict[str, object] = {"eye": eye, "target": target, "fov": 60, "bounces": 2, "walls": [], "lights": [], "points": []}

    def add(to_world: object, corners: list[list[float]]) -> None:
        points = (languages.matrix(to_world) @ numpy.array([[*c, 1] for c in corners], dtype=float).T).T[:, :3]
        cycles["walls"].append(points.tolist())

    faces = [((1, 0, 0), -90, (0, 0, 0), (width, depth)), ((1, 0, 0), 90, (0, 2 * height, 0), (width, depth)),
             ((0, 1, 0), 0, (0, height, -depth), (width, height)), ((0, 1, 0), 180, (0, height, depth), (width, height)),
             ((0, 1, 0), 90, (-width, height, 0), (depth, height)), ((0, 1, 0), -90, (width, height, 0), (depth, height))]
    for axis, angle, centre, (x, y) in faces:
        to_world = transform(scale=(x, y, 1), rotate=[(axis, angle)], translate=centre)
        scene.add(rectangle(grey, to_world))
        add(to_world, SQUARE)
    for _ in range(40):
        half = random.uniform((0.1, 0.2, 0.1), (0.4, 1.5, 0.4))
        to_world = transform(scale=half.tolist(), translate=[random.uniform(-8, 8), half[1].item(), random.uniform(-4, 4)])
        scene.add(box(grey, to_world))
        for axis, angle in (((0, 1, 0), 0), ((0, 1, 0), 90), ((0, 1, 0), 180), ((0, 1, 0), 270), ((1, 0, 0), 90), ((1, 0, 0), -90)):
            add(to_world @ transform(rotate=[(axis, angle)]) @ transform(translate=(0, 0, 1)), SQUARE)
    for number in range(count):
        position = random.uniform((-9.7, 0.8, -5.7), (9.7, 3.8, 5.7)).tolist()
        colour = (10 ** random.uniform(-1, 1) * random.uniform(0.4, 1, 3)).tolist()
        if number % 2:
            intensity = [0.3 * c for c in colour]
            scene.add(point(position, intensity))
            cycles["points"].append([position, intensity])
        else:
            radiance = [100 * c for c in colour]
            to_world = transform(scale=(0.05, 0.05, 1), rotate=[(random.normal(size=3), random.uniform(0, 180))], translate=position)
            scene.add(rectangle(diffuse(0), to_world, emission=radiance))
            cycles["lights"].append([languages.matrix(to_world).tolist(), radiance])
    return cycles


def without_lights(cycles: dict[str, object], size: int) -> numpy.ndarray:
    """The pixels that no square light can touch: Cycles does not show its lights to the camera."""
    eye, target = numpy.array(cycles["eye"]), numpy.array(cycles["target"])
    forward = (target - eye) / numpy.linalg.norm(target - eye)
    right = numpy.cross(forward, (0, 1, 0))
    right /= numpy.linalg.norm(right)
    axes = numpy.array([right, -numpy.cross(right, forward), forward])
    shown = numpy.ones((size, size), dtype=bool)
    for to_world, _ in cycles["lights"]:
        corners = (numpy.array(to_world) @ numpy.array([[*c, 1] for c in SQUARE], dtype=float).T).T[:, :3]
        x, y, z = axes @ (corners - eye).T
        if (z > 0.01).all():
            column, row = ((1 + v / z / math.tan(math.radians(cycles["fov"] / 2))) * size / 2 for v in (x, y))
            # A pixel more on each side.
            low = [max(0, math.floor(v.min()) - 1) for v in (row, column)]
            high = [max(0, math.ceil(v.max()) + 1) for v in (row, column)]
            shown[low[0]:high[0], low[1]:high[1]] = False
        elif (z > 0.01).any():
            sys.exit("a light reaches behind the camera")
    return shown


def processor_seconds() -> float:
    return sum(resource.getrusage(who).ru_utime for who in (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF))


def by_command(command: list[object], out: pathlib.Path) -> numpy.ndarray:
    out.unlink(missing_ok=True)
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode or not out.exists():
        sys.exit(done.stdout + done.stderr)
    return languages.read(out)


def relative_error(pictures: numpy.ndarray, shown: numpy.ndarray) -> tuple[float, float]:
    """Of the pixels `shown`: root of the mean squared relative error (over mean^2 + 1 % of the picture's mean^2) of one picture, and the same without the worst 1 % of pixels."""
    mean = pictures.mean(axis=0)
    relative = (pictures.var(axis=0, ddof=1) / (mean**2 + 0.01 * mean.mean() ** 2)).mean(axis=2)[shown]
    kept = numpy.sort(relative.ravel())[: int(0.99 * relative.size)]
    return float(numpy.sqrt(relative.mean())), float(numpy.sqrt(kept.mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--glanz", required=True)
    parser.add_argument("--cycles", help="Python interpreter with bpy")
    parser.add_argument("--lights", type=int, default=1000)
    parser.add_argument("--renders", type=int, default=16)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json", type=pathlib.Path)
    asked = parser.parse_args()
    drjit.set_thread_count(asked.threads)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        scene = languages.Scene(folder, asked.size)
        described = hall(scene, asked.lights)
        shown = without_lights(described, asked.size)
        (folder / "cycles.json").write_text(json.dumps(described))
        (folder / "scene.pbrt").write_text(scene.pbrt())
        world, out = scene.mitsuba(), folder / "out.exr"

        def glanz(seed: int) -> numpy.ndarray:
            return by_command([asked.glanz, "render", folder / "scene.pbrt", "-o", out, "--spp", asked.samples, "--seed", seed, "--threads",
                               asked.threads, "--strict", "-q"], out)

        def cycles(tree: str) -> object:
            script = pathlib.Path(__file__).with_name("hall_cycles.py")
            return lambda seed: by_command([asked.cycles, script, folder / "cycles.json", out, asked.size, asked.samples, seed, asked.threads, tree], out)

        sides = {"glanz": glanz, "mitsuba": lambda seed: numpy.array(mitsuba.render(world, spp=asked.samples, seed=seed), dtype=float)}
        if asked.cycles:
            sides |= {"cycles with light tree": cycles("tree"), "cycles without": cycles("all")}
        report = {"date": time.strftime("%Y-%m-%d"), "lights": asked.lights, "renders": asked.renders, "samples": asked.samples, "size": asked.size, "pixels_without_lights": int(shown.sum()),
                  "mitsuba": mitsuba.__version__, "programs": {}}
        for name, render in sides.items():
            start = processor_seconds()
            pictures = numpy.stack([render(seed) for seed in range(1, asked.renders + 1)])
            error, most = relative_error(pictures, shown)
            means = pictures[:, shown].mean(axis=(1, 2))
            report["programs"][name] = {"relative_error": error, "without_worst_percent": most, "mean": float(means.mean()),
                                        "mean_error": float(means.std(ddof=1) / len(means) ** 0.5),
                                        "processor_seconds_per_picture": round((processor_seconds() - start) / asked.renders, 2)}
            print(name, report["programs"][name], flush=True)
    if asked.json:
        asked.json.write_text(json.dumps(report, indent=1) + "\n")


main()

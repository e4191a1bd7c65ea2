"""The office with Radiance: ies2rad, oconv and rtrace of pyradiance."""

import os
import pathlib
import subprocess

import numpy
import pyradiance

import room
from glanz import measured
from lux_map import Array, LuxMap

PROGRAMS = pathlib.Path(pyradiance.__file__).parent
ENVIRONMENT = os.environ | {"RAYPATH": f".:{PROGRAMS / 'lib'}", "LC_ALL": "C"}

# Every point samples every light; none is estimated.
DIRECT = ["-ds", 0, "-dj", 0, "-dt", 0, "-dc", 1, "-dr", 0]

# Light of all bounces by random paths: no cache and no interpolation (-aa 0); paths end by Russian roulette.
AMBIENT = ["-aa", 0, "-as", 0, "-av", 0, 0, 0, "-u+", "-lr", -30, "-lw", 2e-4]

# Distance of measurement points above a receiver that is a surface, metres.
ABOVE = 1e-5


def program(name: str) -> str:
    return str(PROGRAMS / "bin" / name)


def version() -> str:
    ran = subprocess.run([program("rtrace"), "-version"], stdout=subprocess.PIPE, text=True, env=ENVIRONMENT, check=False)
    return ran.stdout.strip()


def octree(folder: pathlib.Path, scene: str) -> pathlib.Path:
    """Builds the octree of a scene written by room.write, with the luminaires of lamp.ies."""
    lamp = [program("ies2rad"), "-dm", "-c", 1, 1, 1, "-o", "lamp", "lamp.ies"]
    measured(lamp, cwd=folder, env=ENVIRONMENT)
    parts = [(folder / f"{scene}.rad").read_text()]
    for mounted in room.MOUNTED:
        turn = ["-rx", mounted.about_x, "-rz", mounted.about_z, "-t", *mounted.position]
        moved = [program("xform"), *map(str, turn), "lamp.rad"]
        ran = subprocess.run(moved, cwd=folder, env=ENVIRONMENT, check=True, stdout=subprocess.PIPE, text=True)
        parts.append(ran.stdout)
    (folder / f"{scene}-lit.rad").write_text("\n".join(parts))
    tree = folder / f"{scene}.oct"
    with tree.open("wb") as file:
        measured([program("oconv"), f"{scene}-lit.rad"], cwd=folder, env=ENVIRONMENT, stdout=file)
    return tree


def illuminance(tree: pathlib.Path, points: Array, bounces: int, divisions: int, threads: int) -> tuple[Array, float]:
    """Illuminance of points that face upwards, lux, and processor seconds."""
    ambient = ["-ab", bounces, "-ad", divisions, *AMBIENT] if bounces else ["-ab", 0]
    command = [program("rtrace"), "-h", "-I+", "-w", "-n", threads, "-fdf", *DIRECT, *ambient, tree.name]
    rays = numpy.hstack([points, numpy.tile([0.0, 0.0, 1.0], (len(points), 1))])
    asked, answered = tree.with_suffix(".rays"), tree.with_suffix(".values")
    rays.astype("<f8").tofile(asked)
    with asked.open("rb") as from_, answered.open("wb") as to:
        seconds = measured(command, cwd=tree.parent, env=ENVIRONMENT, stdin=from_, stdout=to)
    rgb = numpy.fromfile(answered, "<f4").reshape(-1, 3).astype(numpy.float64)
    # Radiance converts 179 lm of white light to a watt on reading luminaires; the inverse applies to its results.
    return 179 * (rgb @ [0.265, 0.670, 0.065]), seconds


def lux_map(tree: pathlib.Path, height: float, parts: int, bounces: int, divisions: int, threads: int) -> tuple[LuxMap, float]:
    """Means over cells, and processor seconds.

    They are means of random points, two in each of `parts` x `parts` parts of a cell, whose difference estimates the error.
    """
    random = numpy.random.default_rng(round(1000 * height))
    corners, sides = room.corners_of_cells(height)
    grid = numpy.indices((parts, parts)).reshape(2, -1).T
    shares = (grid[:, None, None, :] + random.random((parts**2, 2, len(corners), 2))) / parts
    points = corners + numpy.concatenate([shares * sides[:2], numpy.full((*shares.shape[:-1], 1), ABOVE)], axis=-1)
    lux, seconds = illuminance(tree, points.reshape(-1, 3), bounces, divisions, threads)
    first, second = numpy.moveaxis(lux.reshape(parts**2, 2, -1), 1, 0)
    areas = numpy.full(len(corners), sides[0] * sides[1])
    errors = numpy.sqrt(((first - second) ** 2).sum(axis=0)) / (2 * parts**2)
    return LuxMap.sorted(corners + sides / 2, areas, lux.reshape(2 * parts**2, -1).mean(axis=0), errors), seconds

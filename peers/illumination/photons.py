"""Radiance's photons in the room of document 000: those that mkpmap stores, without its density estimate.

mkpmap stores every photon that arrives at a diffuse surface, direct ones in one map, those from mirrors in another. The walls
are nearly black: black ones would store nothing, and light that they reflect would count as light of the mirror.
"""

import pathlib
import subprocess

import numpy
from numpy.typing import NDArray

import mirror
from glanz import measured
from lux_map import Array
from radiance import ENVIRONMENT, program

# Reflectance of the walls, in all three channels.
DARK = 1e-4

# Direct photons, and those from mirrors.
KINDS = {"direct": "-apd", "caustic": "-apc"}


def write(folder: pathlib.Path, mesh: mirror.Mesh) -> pathlib.Path:
    """The room as an octree."""
    normals = mesh.vertices[:0] if mesh.normals is None else mesh.normals
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "mirror.obj").open("w") as file:
        numpy.savetxt(file, mesh.vertices, "v %.9g %.9g %.9g")
        numpy.savetxt(file, normals, "vn %.9g %.9g %.9g")
        numpy.savetxt(file, numpy.repeat(mesh.faces + 1, 2, axis=1), "f %d//%d %d//%d %d//%d")
    radiance = mirror.EFFICACY / 179 * mirror.RADIANCE
    lines = [
        f"void light shining 0 0 3 {radiance} {radiance} {radiance}",
        "shining sphere lamp 0 0 4 {} {} {} {}".format(*mirror.LAMP, mirror.RADIUS),
        f"void plastic dark 0 0 5 {DARK} {DARK} {DARK} 0 0",
        "void metal silver 0 0 5 {0} {0} {0} 1 0".format(mirror.REFLECTANCE),
        "silver mesh mirror 1 mirror.rtm 0 0",
    ]
    box = ["genbox", "dark", "box", *[f"{mirror.SIZE}"] * 3, "-i"]
    walls = subprocess.run([program(box[0]), *box[1:]], check=True, stdout=subprocess.PIPE, text=True, env=ENVIRONMENT).stdout
    (folder / "room.rad").write_text("\n".join(lines) + "\n" + walls)
    measured([program("obj2mesh"), "mirror.obj", "mirror.rtm"], cwd=folder, env=ENVIRONMENT)
    tree = folder / "room.oct"
    with tree.open("wb") as file:
        measured([program("oconv"), "room.rad"], cwd=folder, env=ENVIRONMENT, stdout=file)
    return tree


def arrivals(tree: pathlib.Path, kind: str, count: int, cells: int) -> tuple[Array, int, float]:
    """Lumens by cell and their squares for about `count` photons of a kind, their actual number, and processor seconds.

    A photon's flux is stored as a byte and an exponent, so that all of them may be off by half a per cent. The seconds are those of
    tracing and storing them.
    """
    stored = tree.with_name(f"{kind}.pm")
    make = [program("mkpmap"), KINDS[kind], stored.name, count, "-fo+", tree.name]
    seconds = measured(make, cwd=tree.parent, env=ENVIRONMENT, stderr=subprocess.DEVNULL)
    dump = [program("pmapdump"), "-a", "-f", "-n", str(2 * count), stored.name]
    text = subprocess.run(dump, cwd=tree.parent, check=True, stdout=subprocess.PIPE, env=ENVIRONMENT).stdout
    photons = numpy.array(text.split(), dtype=numpy.float64).reshape(-1, 6)
    lumens = 179 * (photons[:, 3:] @ [0.265, 0.670, 0.065])
    number = cell(photons[:, :3], cells)
    sums = numpy.array([numpy.bincount(number, values, 6 * cells**2) for values in (lumens, lumens**2)])
    return sums, len(photons), seconds


def cell(positions: Array, cells: int) -> NDArray[numpy.intp]:
    """Indices of the cells of points on the walls."""
    shares = positions / mirror.SIZE
    axis = numpy.minimum(shares, 1 - shares).argmin(axis=1)
    far = numpy.take_along_axis(shares, axis[:, None], axis=1)[:, 0] > 0.5
    fast, slow = (numpy.where(axis == other, shares[:, a], shares[:, b]) for other, a, b in ((0, 1, 0), (2, 1, 2)))
    column, row = (numpy.clip((x * cells).astype(int), 0, cells - 1) for x in (fast, slow))
    return ((2 * axis + far) * cells + row) * cells + column

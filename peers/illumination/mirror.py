"""The room of document 000: a spherical light and a tessellated mirror."""

import dataclasses
import math
import pathlib
import re

import numpy
from numpy.typing import NDArray

from glanz import ROOT
from lux_map import Array, LuxMap

SCENE = ROOT / "scenes" / "reflector.pbrt"

# Dimensions of the scene, metres; its walls are those of `--room 10 10 10`.
SIZE = 10.0
LAMP, RADIUS = (0.25, 5.0, 5.0), 0.1
RADIANCE = 3.70869
REFLECTANCE = 0.9

# Reflectance of the lamp, which has the default material of the scene language.
LAMP_REFLECTANCE = 0.5

# Walls in the order of x = 0, x = 10, y = 0 and so on.
WALLS = ["wall x=0", "wall x=10", "wall y=0", "wall y=10", "floor", "ceiling"]

# A black box around the lamp, open towards the mirror and wide enough not to occlude it: low and high corner. With it, the wall
# behind the lamp, x = 0, receives only light of the mirror.
HOOD = numpy.array([[0.1, 4.75, 4.75], [0.4, 5.25, 5.25]])

# Lumens per watt.
EFFICACY = 683.0


def flux() -> float:
    """Luminous flux of the lamp, lm."""
    return EFFICACY * math.pi * RADIANCE * 4 * math.pi * RADIUS**2


def control_points(scene: pathlib.Path = SCENE) -> Array:
    """Control points P_ijk of the scene's Bézier triangle, i descending, then j descending."""
    found = re.search(r'"beziertriangle".*?"point3 P" \[(.*?)\]', scene.read_text(), re.DOTALL)
    if not found:
        raise ValueError(f"{scene} has no Bézier triangle")
    lines = [line.split("#")[0].split() for line in found[1].splitlines()]
    return numpy.array([[float(word) for word in line] for line in lines if line])


def hood() -> list[Array]:
    """Corners of the five faces of the hood, in order."""
    faces = []
    for axis, end in ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1)):
        choice = numpy.zeros((4, 3), dtype=int)
        choice[:, axis] = end
        choice[[1, 2], (axis + 1) % 3] = choice[[2, 3], (axis + 2) % 3] = 1
        faces.append(numpy.take_along_axis(HOOD, choice, axis=0))
    return faces


def hooded_scene() -> str:
    lines = [SCENE.read_text(), 'Material "matte" "rgb Kd" [0 0 0]']
    for corners in hood():
        points = " ".join(f"{x:.10g}" for x in corners[[0, 1, 3, 2]].ravel())
        lines.append(f'Shape "bilinearmesh" "point3 P" [ {points} ]')
    return "\n".join(lines) + "\n"


@dataclasses.dataclass(frozen=True)
class Mesh:
    """Triangles, with the surface's normals at their corners or without normals."""

    vertices: Array
    normals: Array | None
    faces: NDArray[numpy.uint32]


def tessellated(points: Array, cuts: int) -> Mesh:
    """Tessellation into `cuts` squared triangles between points of a regular grid of the parameters."""
    i, j = numpy.indices((cuts + 1, cuts + 1)).reshape(2, -1)
    inside = i + j <= cuts
    i, j = i[inside], j[inside]
    r, s = i / cuts, j / cuts
    position, along_r, along_s = evaluated(points, r, s)
    normals = numpy.cross(along_r, along_s)
    normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    number = numpy.full((cuts + 1, cuts + 1), -1)
    number[i, j] = numpy.arange(len(i))
    low, high = i + j < cuts, i + j < cuts - 1
    upright = [number[i[low], j[low]], number[i[low] + 1, j[low]], number[i[low], j[low] + 1]]
    turned = [number[i[high] + 1, j[high]], number[i[high] + 1, j[high] + 1], number[i[high], j[high] + 1]]
    faces = numpy.concatenate([numpy.stack(upright, axis=1), numpy.stack(turned, axis=1)])
    return Mesh(position, normals, faces.astype(numpy.uint32))


def evaluated(points: Array, r: Array, s: Array) -> tuple[Array, Array, Array]:
    """Position and derivatives along r and s (t = 1 - r - s) of the cubic sum of 3! / (i! j! k!) r^i s^j t^k P_ijk."""
    t = 1 - r - s
    position, along_r, along_s = (numpy.zeros((len(r), 3)) for _ in range(3))
    number = 0
    for i in range(3, -1, -1):
        for j in range(3 - i, -1, -1):
            k = 3 - i - j
            factor = 6 / math.factorial(i) / math.factorial(j) / math.factorial(k)

            def term(a: int, b: int, c: int) -> Array:
                return r**a * s**b * t**c if min(a, b, c) >= 0 else numpy.zeros_like(r)

            along_t = k * term(i, j, k - 1)
            point = factor * points[number]
            position += term(i, j, k)[:, None] * point
            along_r += (i * term(i - 1, j, k) - along_t)[:, None] * point
            along_s += (j * term(i, j - 1, k) - along_t)[:, None] * point
            number += 1
    return position, along_r, along_s


def maps(flux_of_cells: Array, squares: Array, particles: int | None, cells: int) -> list[LuxMap]:
    """Maps of `cells` x `cells` per wall from the lumens that arrive in each cell and the sums of their squares.

    Each particle arrives once or not at all, so the variance of a sum is the sum of squares minus the square of the sum divided
    by the number of particles. If that is unknown, it is the sum of squares.
    """
    area = (SIZE / cells) ** 2
    found = []
    middles = (numpy.arange(cells) + 0.5) * SIZE / cells
    slow, fast = (grid.ravel() for grid in numpy.meshgrid(middles, middles, indexing="ij"))
    for wall in range(6):
        axis, far = divmod(wall, 2)
        positions = numpy.empty((cells * cells, 3))
        first, second = (other for other in range(3) if other != axis)
        positions[:, axis], positions[:, first], positions[:, second] = far * SIZE, fast, slow
        part = slice(wall * cells * cells, (wall + 1) * cells * cells)
        lumens = flux_of_cells[part]
        variance = squares[part] - (lumens**2 / particles if particles else 0)
        errors = numpy.sqrt(numpy.maximum(0, variance))
        found.append(LuxMap.sorted(positions, numpy.full(cells * cells, area), lumens / area, errors / area))
    return found

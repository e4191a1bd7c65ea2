"""The office: walls, furniture and two luminaires, in the formats of Glanz and Radiance."""

import dataclasses
import pathlib

import numpy
from numpy.typing import NDArray

from luminaire import Luminaire
from lux_map import Array, LuxMap

SIZE = numpy.array([6.0, 4.0, 2.8])
CELLS = (24, 16)

# Heights of the measurement planes, metres. That of the desk is an interface, which light passes.
RECEIVERS = {"desk": 0.75, "floor": 0.0}

REFLECTANCE = {"wall": 0.5, "ceiling": 0.7, "floor": 0.2, "furniture": 0.4}


@dataclasses.dataclass(frozen=True)
class Box:
    """A solid box along the axes."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]

    def faces(self) -> list[Array]:
        """Four corners of each face, in the order for which the normal points outwards."""
        low, high = numpy.array(self.low, dtype=float), numpy.array(self.high, dtype=float)
        faces = []
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for far in (False, True):
                corners = numpy.tile(low, (4, 1))
                corners[:, axis] = (high if far else low)[axis]
                corners[[1, 2], u] = high[u]
                corners[[2, 3], v] = high[v]
                faces.append(corners if far else corners[::-1])
        return faces

    def blocks(self, origin: Array, target: Array) -> NDArray[numpy.bool_]:
        """Whether the box is between `origin` and the targets."""
        with numpy.errstate(divide="ignore"):
            ends = numpy.stack([(numpy.array(end) - origin) / (target - origin) for end in (self.low, self.high)])
        enter, leave = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
        return (enter < leave) & (leave > 0) & (enter < 1)


# Two table tops below the plane of the desk, and a screen between them that crosses it.
FURNITURE = [
    Box((0.9, 1.2, 0.70), (2.5, 2.0, 0.72)),
    Box((3.6, 1.0, 0.70), (4.4, 2.6, 0.72)),
    Box((2.98, 0.9, 0.0), (3.02, 2.7, 1.3)),
]


@dataclasses.dataclass(frozen=True)
class Mounted:
    """A luminaire, rotated first about x, then about z (degrees), then moved."""

    position: tuple[float, float, float]
    about_x: float
    about_z: float

    def rotation(self) -> Array:
        a, b = numpy.radians([self.about_x, self.about_z])
        x = numpy.array([[1, 0, 0], [0, numpy.cos(a), -numpy.sin(a)], [0, numpy.sin(a), numpy.cos(a)]])
        z = numpy.array([[numpy.cos(b), -numpy.sin(b), 0], [numpy.sin(b), numpy.cos(b), 0], [0, 0, 1]])
        return z @ x


MOUNTED = [Mounted((1.5, 2.2, 2.6), 0, 30), Mounted((4.5, 1.8, 2.6), 25, 130)]


def surfaces(black: bool) -> list[tuple[Array, str, float]]:
    """Corners, kind and reflectance of all rectangles; walls face the room."""
    kinds = ["wall", "wall", "wall", "wall", "floor", "ceiling"]
    walls = [(face[::-1], kind) for face, kind in zip(Box((0, 0, 0), (SIZE[0], SIZE[1], SIZE[2])).faces(), kinds, strict=True)]
    furniture = [(face, "furniture") for box in FURNITURE for face in box.faces()]
    return [(face, kind, 0.0 if black else REFLECTANCE[kind]) for face, kind in walls + furniture]


def scene_of_glanz(luminaire_file: str, black: bool) -> str:
    def quad(corners: Array, more: str = "") -> str:
        # Bilinear patches have rows of corners.
        points = " ".join(f"{x:.10g}" for x in corners[[0, 1, 3, 2]].ravel())
        return f'Shape "bilinearmesh" "point3 P" [ {points} ]{more}'

    lines = ['LookAt 3 .3 1.7  3 3 1  0 0 1\nCamera "perspective" "float fov" 70\nWorldBegin']
    for lamp in MOUNTED:
        place = " ".join(f"{x:g}" for x in lamp.position)
        light = f'LightSource "photometric" "string filename" "{luminaire_file}"'
        turn = f"Rotate {lamp.about_z:g} 0 0 1 Rotate {lamp.about_x:g} 1 0 0"
        lines.append(f"AttributeBegin Translate {place} {turn}\n  {light}\nAttributeEnd")
    cells = '"integer cells" [ {} {} ]'.format(*CELLS)
    for corners, kind, reflectance in surfaces(black):
        receiver = f' "string receiver" "floor" {cells}' if kind == "floor" else ""
        lines.append(f'Material "diffuse" "rgb reflectance" [ {reflectance} {reflectance} {reflectance} ]')
        lines.append(quad(corners, receiver))
    lines.append('Material "interface"')
    x, y, _ = SIZE
    height = RECEIVERS["desk"]
    desk = numpy.array([[0, 0, height], [x, 0, height], [x, y, height], [0, y, height]])
    lines.append(quad(desk, f' "string receiver" "desk" {cells}'))
    return "\n".join(lines) + "\n"


def scene_of_radiance(black: bool) -> str:
    """The scene without luminaires."""
    lines = []
    for number, (corners, kind, reflectance) in enumerate(surfaces(black)):
        points = " ".join(f"{x:.10g}" for x in corners.ravel())
        lines.append(f"void plastic {kind}{number} 0 0 5 {reflectance} {reflectance} {reflectance} 0 0")
        lines.append(f"{kind}{number} polygon face{number} 0 0 12 {points}")
    return "\n".join(lines) + "\n"


def corners_of_cells(height: float) -> tuple[Array, Array]:
    """Lower corners of the cells of a receiver, rows of y, and the sides of a cell."""
    sides = numpy.array([SIZE[0] / CELLS[0], SIZE[1] / CELLS[1], 0.0])
    j, i = numpy.indices(CELLS[::-1]).reshape(2, -1)
    return numpy.stack([i * sides[0], j * sides[1], numpy.full(len(i), height)], axis=-1), sides


def direct(luminaire: Luminaire, points: Array) -> Array:
    """Direct illuminance of points that face upwards, lux: I cos / d^2 without occlusion."""
    lux = numpy.zeros(points.shape[:-1])
    for lamp in MOUNTED:
        position = numpy.array(lamp.position)
        ray = points - position
        distance = numpy.linalg.norm(ray, axis=-1)
        # Multiplying rows by a rotation applies its inverse.
        candela = luminaire.intensity(ray / distance[..., None] @ lamp.rotation())
        seen = ~numpy.any([box.blocks(position, points) for box in FURNITURE], axis=0)
        lux += numpy.where(seen, candela * (-ray[..., 2]) / distance**3, 0)
    return lux


def closed_form(luminaire: Luminaire, height: float, parts: int = 40) -> LuxMap:
    """Means of the direct illuminance over cells, by a random point in each of `parts` x `parts` parts of a cell."""
    random = numpy.random.default_rng(1)
    corners, sides = corners_of_cells(height)
    lux = numpy.zeros(len(corners))
    for part in numpy.indices((parts, parts)).reshape(2, -1).T:
        shares = numpy.pad((part + random.random((len(corners), 2))) / parts, ((0, 0), (0, 1)))
        lux += direct(luminaire, corners + shares * sides) / parts**2
    areas = numpy.full(len(corners), sides[0] * sides[1])
    return LuxMap.sorted(corners + sides / 2, areas, lux, numpy.zeros(len(corners)))


def write(folder: pathlib.Path, luminaire: Luminaire) -> None:
    """Writes all files except those of Radiance's luminaires."""
    folder.mkdir(parents=True, exist_ok=True)
    luminaire.write(folder / "lamp.ies")
    for name, black in (("black", True), ("office", False)):
        (folder / f"{name}.pbrt").write_text(scene_of_glanz("lamp.ies", black))
        (folder / f"{name}.rad").write_text(scene_of_radiance(black))

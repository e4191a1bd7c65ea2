"""Luminaires with known intensity in all directions, written and read as LM-63-2002, type C."""

import dataclasses
import pathlib
from typing import Self

import numpy
from numpy.typing import NDArray

from lux_map import Array


@dataclasses.dataclass(frozen=True)
class Luminaire:
    """Candela over directions, bilinear in the angles between those of the file.

    `gammas`: degrees from -z, ascending. `planes`: degrees about z from +x to +y, from 0 to 360. `candela`: one row per plane.
    """

    gammas: Array
    planes: Array
    candela: Array

    def intensity(self, directions: Array) -> Array:
        """Candela in directions, an array of unit vectors in the luminaire's frame."""
        x, y, z = numpy.moveaxis(directions, -1, 0)
        gamma = numpy.degrees(numpy.arccos(numpy.clip(-z, -1, 1)))
        plane = numpy.degrees(numpy.arctan2(y, x)) % 360
        i, s = place(self.planes, plane)
        j, t = place(self.gammas, gamma)
        lower = (1 - t) * self.candela[i, j] + t * self.candela[i, j + 1]
        upper = (1 - t) * self.candela[i + 1, j] + t * self.candela[i + 1, j + 1]
        return numpy.where(gamma <= self.gammas[-1], (1 - s) * lower + s * upper, 0)

    def flux(self) -> float:
        """Lumens: the midpoint rule over half a degree of gamma, trapezoids over the planes."""
        gammas = numpy.radians((numpy.arange(360) + 0.5) / 2)
        planes = numpy.radians(numpy.arange(720) / 2)
        g, c = numpy.meshgrid(gammas, planes)
        directions = numpy.stack([numpy.sin(g) * numpy.cos(c), numpy.sin(g) * numpy.sin(c), -numpy.cos(g)], axis=-1)
        step = numpy.radians(0.5)
        return float((self.intensity(directions) * numpy.sin(g)).sum() * step**2)

    def write(self, path: pathlib.Path) -> None:
        """Writes it as a point without size, which Radiance treats as a ball of half a millimetre."""
        lines = [
            "IESNA:LM-63-2002",
            "[TEST] made up for a comparison of programs",
            "[TESTLAB] none",
            "[ISSUEDATE] 2026-11-22",
            "[MANUFAC] none",
            "[LUMCAT] none",
            "[LUMINAIRE] asymmetric, with some light upwards",
            "TILT=NONE",
            f"1 -1 1 {len(self.gammas)} {len(self.planes)} 1 2 0 0 0",
            "1 1 40",
            *(" ".join(f"{x:.6g}" for x in row) for row in (self.gammas, self.planes, *self.candela)),
        ]
        path.write_text("\n".join(lines) + "\n")

    @classmethod
    def read(cls, path: pathlib.Path) -> Self:
        """Reads a file of type C without tilt data; symmetry is expanded, the size of the opening is ignored."""
        _, numbers = path.read_text(encoding="latin-1").split("TILT=NONE", 1)
        values = numpy.array([float(word) for word in numbers.replace(",", " ").split()])
        _, _, multiplier, gamma_count, plane_count, kind = values[:6]
        if kind != 1:
            raise ValueError(f"{path}: the photometric type is {kind:g}; it must be C (1)")
        factor = multiplier * values[10] * values[11]
        gammas, planes, candela = numpy.split(values[13:], numpy.cumsum([gamma_count, plane_count]).astype(int))
        table = factor * candela.reshape(len(planes), len(gammas))
        if planes[-1] == 0:
            planes, table = numpy.array([0.0, 360.0]), numpy.repeat(table, 2, axis=0)
        while planes[-1] < 360:
            planes = numpy.concatenate([planes, 2 * planes[-1] - planes[-2::-1]])
            table = numpy.concatenate([table, table[-2::-1]])
        return cls(gammas, planes, table)


def place(grid: Array, values: Array) -> tuple[NDArray[numpy.intp], Array]:
    """Indices of the grid points below the values, and the fractions of the way to the next ones."""
    index = numpy.clip(numpy.searchsorted(grid, values, side="right") - 1, 0, len(grid) - 2)
    return index, (values - grid[index]) / (grid[index + 1] - grid[index])


def asymmetric() -> Luminaire:
    """A smooth luminaire without symmetry: a lobe at 25 degrees from straight down towards C0, stronger towards C90.

    Some light goes upwards. Values are rounded to tenths of candela, as in the file.
    """
    gammas, planes = numpy.arange(0, 181, 5.0), numpy.arange(0, 361, 15.0)
    c, g = numpy.meshgrid(numpy.radians(planes), numpy.radians(gammas), indexing="ij")
    lean = numpy.radians(25)
    along = numpy.cos(g) * numpy.cos(lean) + numpy.sin(g) * numpy.cos(c) * numpy.sin(lean)
    lobe = 900 * numpy.exp(3 * (along - 1)) * (1 + 0.3 * numpy.sin(c) * numpy.sin(g))
    upwards = 60 * numpy.maximum(0, -numpy.cos(g))
    return Luminaire(gammas, planes, numpy.round(lobe + upwards, 1))

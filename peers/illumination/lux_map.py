"""Illuminance maps with their errors, and the agreement of two of them."""

import csv
import dataclasses
import math
import pathlib
from typing import Self

import numpy
from numpy.typing import NDArray

Array = NDArray[numpy.float64]

# Relative standard error of a difference from which a cell has too few particles: 32 if both maps have the same number.
FEW = 0.25

# Standard errors of the difference beyond which fractions of cells are reported.
BEYOND = (2, 3, 4)


@dataclasses.dataclass(frozen=True)
class LuxMap:
    """Cells of a rectangle along the axes, in ascending order of z, then y, then x. Metres, m^2 and lux."""

    positions: Array
    areas: Array
    lux: Array
    errors: Array

    @classmethod
    def sorted(cls, positions: Array, areas: Array, lux: Array, errors: Array) -> Self:
        order = numpy.lexsort(numpy.round(positions, 6).T)
        return cls(positions[order], areas[order], lux[order], errors[order])

    @classmethod
    def read(cls, path: pathlib.Path) -> Self:
        """Reads a map written by `glanz illuminate`."""
        with path.open(newline="") as file:
            rows = [[float(value) for value in list(row.values())[2:]] for row in csv.DictReader(file)]
        table = numpy.array(rows)
        return cls.sorted(table[:, :3], table[:, 3], table[:, 4], table[:, 5])

    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        counts = [len(numpy.unique(numpy.round(axis, 6))) for axis in self.positions.T if numpy.ptp(axis) > 1e-6]
        return counts[1], counts[0]

    def coarser(self, side: int) -> Self:
        """The map with `side` x `side` cells merged to one; all cells must have the same size."""
        rows, columns = (n // side for n in self.shape())

        def summed(values: Array) -> Array:
            shape = (rows, side, columns, side, *values.shape[1:])
            return values.reshape(shape).sum(axis=(1, 3)).reshape(rows * columns, *values.shape[1:])

        errors = numpy.sqrt(summed(self.errors**2))
        return type(self)(summed(self.positions) / side**2, summed(self.areas), summed(self.lux) / side**2, errors / side**2)

    def flux(self) -> float:
        return float((self.areas * self.lux).sum())

    def flux_error(self) -> float:
        """Standard error of the flux for independent cells; their correlation by particles is as small as a cell's fraction of the light."""
        return float(numpy.sqrt(((self.areas * self.errors) ** 2).sum()))


def mean(maps: list[LuxMap]) -> LuxMap:
    """Mean of independent maps of the same cells with equal weights."""
    errors = numpy.sqrt(sum(one.errors**2 for one in maps)) / len(maps)
    return LuxMap(maps[0].positions, maps[0].areas, numpy.mean([one.lux for one in maps], axis=0), errors)


def variance_found(maps: list[list[LuxMap]]) -> float:
    """Variance of maps between seeds over the variance that they state. `maps`: for each seed the maps of all receivers."""
    lux, errors = (
        numpy.array([numpy.concatenate([getattr(one, what) for one in seed]) for seed in maps]) for what in ("lux", "errors")
    )
    lit = (lux > 0).all(axis=0)
    return float(numpy.mean(lux.var(axis=0, ddof=1)[lit] / (errors**2).mean(axis=0)[lit]))


@dataclasses.dataclass(frozen=True)
class Agreement:
    """Differences of two maps of the same cells, in standard errors of the difference."""

    cells: int
    left_out: int
    above: dict[str, float]
    largest: float
    mean: float
    variance: float
    flux: float
    flux_error: float
    median_error: float

    @classmethod
    def of(cls, ours: list[LuxMap], theirs: list[LuxMap]) -> Self:
        """Statistics of all cells with normally distributed errors: those below a quarter of the light of both maps.

        `flux` is their flux minus ours, relative to ours, of all cells.
        """
        for a, b in zip(ours, theirs, strict=True):
            if not numpy.allclose(a.positions, b.positions, atol=1e-5):
                raise ValueError("the maps have different cells")
        lux, other = (numpy.concatenate([one.lux for one in maps]) for maps in (ours, theirs))
        both = numpy.hypot(*(numpy.concatenate([one.errors for one in maps]) for maps in (ours, theirs)))
        lit = both < FEW * (lux + other) / 2
        if not lit.any():
            raise ValueError("no cell has a small enough error; trace more particles")
        z = (other - lux)[lit] / both[lit]
        flux = sum(one.flux() for one in ours)
        flux_error = math.hypot(*(one.flux_error() for one in [*ours, *theirs]))
        return cls(
            cells=int(lit.sum()),
            left_out=int((~lit).sum()),
            above={str(k): float((numpy.abs(z) > k).mean()) for k in BEYOND},
            largest=float(numpy.abs(z).max()),
            mean=float(z.mean()),
            variance=float((z**2).mean()),
            flux=sum(one.flux() for one in theirs) / flux - 1,
            flux_error=flux_error / flux,
            median_error=float(numpy.median(both[lit] / (lux + other)[lit] * 2)),
        )

    def text(self) -> str:
        shares = ", ".join(f"{100 * share:.2f} % above {k}" for k, share in self.above.items())
        return (
            f"{self.cells} cells ({self.left_out} left out), {shares}, largest {self.largest:.2f}, mean {self.mean:+.3f},"
            f" variance {self.variance:.3f}; flux {100 * self.flux:+.3f} +- {100 * self.flux_error:.3f} %"
            f"; combined error {100 * self.median_error:.2f} % by the median"
        )


def expected(standard_errors: float) -> float:
    """Fraction of normal deviates beyond a number of standard errors."""
    return math.erfc(standard_errors / math.sqrt(2))

"""Results of jobs that are plain values."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class RenderStatistics:
    """Statistics of a render.

    Attributes
    ----------
    end : ``"complete"``, ``"time"`` (the time limit was reached) or ``"interrupted"``.
    seconds : wall time of the render loop.
    rays, samples : counts over all pixels.
    undecided : rays for which a hit on a freeform surface was not decided.
    threads, integrator, sampler, seed : the settings that were used.
    """

    end: str
    seconds: float
    rays: int
    samples: int
    undecided: int
    threads: int
    integrator: str
    sampler: str
    seed: int

    @property
    def rays_per_second(self) -> float:
        """Rays per second of wall time."""
        return self.rays / self.seconds if self.seconds else 0.0


@dataclass(frozen=True, eq=False)
class Comparison:
    """Differences of a picture from a reference, over the pixels that are finite in both.

    Attributes
    ----------
    rmse : root of the mean squared difference.
    relmse : mean of the squared difference over the squared reference + 0.01.
    display_rmse : `rmse` of the values clipped to [0, 1].
    max : largest difference; ``max_at``: its column and row.
    flip : mean FLIP error, 0 to 1, the perceived difference; ``flip_map``: that of each pixel, H x W.
    mean, reference_mean : mean red, green and blue.
    excluded_pixels : pixels that are infinite or not a number in one of the pictures.
    """

    rmse: float
    relmse: float
    display_rmse: float
    max: float
    max_at: tuple[int, int]
    flip: float
    mean: list[float]
    reference_mean: list[float]
    excluded_pixels: int
    flip_map: NDArray[np.float32]

    def __repr__(self) -> str:
        return (
            f"Comparison(rmse={self.rmse:.6g}, relmse={self.relmse:.6g}, display_rmse={self.display_rmse:.6g}, "
            f"max={self.max:.6g}, flip={self.flip:.6g})"
        )


@dataclass(frozen=True)
class FluxBalance:
    """Luminous flux that the lights emit, and where it ended, lm.

    ``closes_to``: error of the balance as a fraction of the emitted flux.
    """

    emitted: float
    absorbed_by_receivers: float
    absorbed_elsewhere: float
    escaped: float
    given_up: float
    closes_to: float


@dataclass(frozen=True, eq=False)
class LuxMap:
    """Illuminance on a receiver.

    Attributes
    ----------
    name : the receiver.
    size : its width and height, m.
    lux : illuminance of the cells, lx, float64, rows along v, columns along u, or against u where the back of a surface is measured.
    standard_errors : of `lux`, lx; estimated bounds of an integration.
    areas : of the cells, m2; 0 where a cell is cut away.
    positions : centres of the cells, m, N x 3, in the order of ``lux.ravel()``.
    minimum, mean, maximum : illuminance over the area, lx; by particles, estimates without a bias by noise.
    u0, u1 : uniformities, minimum over mean and minimum over maximum.
    minimum_interval, mean_interval, maximum_interval, u0_interval, u1_interval : lower and upper limit, 95 % by particles, estimated bounds by
        integration.
    area : of the receiver, m2; ``flux``: on it, lm.
    """

    name: str
    size: tuple[float, float]
    lux: NDArray[np.float64]
    standard_errors: NDArray[np.float64]
    areas: NDArray[np.float64]
    positions: NDArray[np.float64]
    minimum: float
    minimum_interval: tuple[float, float]
    mean: float
    mean_interval: tuple[float, float]
    maximum: float
    maximum_interval: tuple[float, float]
    u0: float
    u0_interval: tuple[float, float]
    u1: float
    u1_interval: tuple[float, float]
    area: float
    flux: float

    def to_pandas(self) -> Any:
        """One row for each cell: receiver, row, column, x, y, z (m), area (m2), lux and standard_error (lx).

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return _frame(self.name, self)

    def __repr__(self) -> str:
        rows, columns = self.lux.shape
        return (
            f"LuxMap({self.name!r}, {columns} x {rows} cells, minimum {self.minimum:.4g} lx, mean {self.mean:.4g} lx, "
            f"maximum {self.maximum:.4g} lx, U0 {self.u0:.3f})"
        )


@dataclass(frozen=True, eq=False)
class LightChart:
    """Light on one side of a part of a surface.

    Attributes
    ----------
    shape : number of the shape in the order of the scene.
    back : whether it is the side opposite to the normal; ``hidden``: whether that is the inside of a closed solid.
    page, corner : page of the atlas, and column and row of the first texel there, so that the chart is
        ``page[row:row + H, column:column + W]``; None if no light arrives.
    irradiance, radiance : H x W x 3, float32, irradiance in units of radiance; empty if no light arrives.
    """

    shape: int
    back: bool
    hidden: bool
    page: int | None
    corner: tuple[int, int] | None
    irradiance: NDArray[np.float32]
    radiance: NDArray[np.float32]


def _frame(receiver: str, lux_map: LuxMap) -> Any:
    pandas = importlib.import_module("pandas")
    rows, columns = np.indices(lux_map.lux.shape)
    x, y, z = lux_map.positions.T
    return pandas.DataFrame(
        {
            "receiver": receiver,
            "row": rows.ravel(),
            "column": columns.ravel(),
            "x": x,
            "y": y,
            "z": z,
            "area": lux_map.areas.ravel(),
            "lux": lux_map.lux.ravel(),
            "standard_error": lux_map.standard_errors.ravel(),
        }
    )


def illumination_frame(receivers: dict[str, LuxMap]) -> Any:
    """The frames of all receivers, one below the other."""
    pandas = importlib.import_module("pandas")
    frames = [_frame(name, lux_map) for name, lux_map in receivers.items()]
    return pandas.concat(frames, ignore_index=True) if frames else pandas.DataFrame()

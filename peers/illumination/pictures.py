"""Two maps and their difference, side by side."""

import pathlib

import matplotlib
import numpy

from lux_map import Array, LuxMap

matplotlib.use("Agg")
from matplotlib import pyplot


def draw(path: pathlib.Path, title: str, ours: LuxMap, theirs: LuxMap, name: str) -> None:
    """Draws both maps on one scale, and their difference in standard errors."""
    axes = [axis for axis in range(3) if numpy.ptp(ours.positions[:, axis]) > 1e-6]
    across, up = (numpy.unique(numpy.round(ours.positions[:, axis], 6)) for axis in axes)
    ends = [x for middles in (across, up) for x in (1.5 * middles[0] - middles[1] / 2, 1.5 * middles[-1] - middles[-2] / 2)]
    both = numpy.hypot(ours.errors, theirs.errors)
    z = numpy.divide(theirs.lux - ours.lux, both, out=numpy.zeros_like(both), where=both > 0)
    top = numpy.quantile(ours.lux, 0.999)
    panels: list[tuple[str, Array, float, float, str]] = [
        ("Glanz, lx", ours.lux, 0, top, "inferno"),
        (f"{name}, lx", theirs.lux, 0, top, "inferno"),
    ]
    panels.append((f"({name} - Glanz) / standard error", z, -4, 4, "coolwarm"))
    figure, places = pyplot.subplots(
        1, 3, figsize=(15, 4.8 * max(0.75, numpy.ptp(up) / numpy.ptp(across))), layout="constrained"
    )
    for place, (caption, values, low, high, colours) in zip(places, panels, strict=True):
        picture = place.imshow(values.reshape(ours.shape()), origin="lower", extent=ends, vmin=low, vmax=high, cmap=colours)
        place.set(title=caption, xlabel=f"{'xyz'[axes[0]]}, m", ylabel=f"{'xyz'[axes[1]]}, m")
        figure.colorbar(picture, ax=place, shrink=0.8)
    figure.suptitle(title)
    figure.savefig(path, dpi=80)
    pyplot.close(figure)

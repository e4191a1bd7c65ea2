"""Loops that trim shapes, in the parameters u and v of the shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class TrimPolygon:
    """A polygon. ``points``: u and v of its corners, K x 2."""

    points: ArrayLike


@dataclass(frozen=True)
class TrimRectangle:
    """A rectangle between two corners."""

    u0: float
    v0: float
    u1: float
    v1: float


@dataclass(frozen=True)
class TrimEllipse:
    """An ellipse about (u, v)."""

    u: float
    v: float
    uradius: float
    vradius: float


@dataclass(frozen=True, eq=False)
class TrimCurve:
    """A rational spline curve. ``knots``: K plus order; ``points``: u and v of its control points, K x 2; ``weights``: K."""

    knots: ArrayLike
    points: ArrayLike
    weights: ArrayLike | None = None

    def homogeneous(self) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """The points w u, w v, w, K x 3."""
        points = np.asarray(self.points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 2:
            raise ValueError(f"points of a trimming curve have the shape {points.shape}; it must be (K, 2)")
        weights = np.ones(len(points)) if self.weights is None else np.asarray(self.weights, dtype=np.float64)
        if weights.shape != (len(points),):
            raise ValueError(f"weights of a trimming curve have the shape {weights.shape}; it must be ({len(points)},)")
        return np.column_stack([points * weights[:, None], weights])


@dataclass(frozen=True, eq=False)
class TrimLoops:
    """Closed loops of curves; the part on their left is kept: outer borders run counterclockwise, holes clockwise."""

    loops: Sequence[Sequence[TrimCurve]]


#: A loop or several.
Trim = TrimPolygon | TrimRectangle | TrimEllipse | TrimLoops


def trim_parameters(trim: Trim) -> dict[str, tuple[str, ArrayLike]]:
    """The parameters of a loop: name to type and values."""
    match trim:
        case TrimPolygon(points):
            return {"trimpolygon": ("float", points)}
        case TrimRectangle(u0, v0, u1, v1):
            return {"trimrectangle": ("float", [u0, v0, u1, v1])}
        case TrimEllipse(u, v, uradius, vradius):
            return {"trimellipse": ("float", [u, v, uradius, vradius])}
        case TrimLoops(loops):
            curves = [curve for loop in loops for curve in loop]
            points = [curve.homogeneous() for curve in curves]
            knots = [np.ravel(np.asarray(curve.knots, dtype=np.float64)) for curve in curves]
            none = [np.zeros(0)]
            return {
                "trimloops": ("integer", [len(loop) for loop in loops]),
                "trimorders": ("integer", [len(k) - len(p) for k, p in zip(knots, points, strict=True)]),
                "trimcounts": ("integer", [len(p) for p in points]),
                "trimknots": ("float", np.concatenate(knots or none)),
                "trimpoints": ("float", np.concatenate(points) if points else np.zeros(0)),
            }

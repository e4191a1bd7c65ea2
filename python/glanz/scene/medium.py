"""Participating media."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ._statement import Float, Floats, Integer, Light, Point


@dataclass(frozen=True, eq=False, kw_only=True)
class Medium:
    """A medium: absorption ``sigma_a`` and scattering ``sigma_s``, 1/m, times ``scale``; ``g``: mean cosine of the scattering angle."""

    KIND: ClassVar[str]
    sigma_a: Light | None = None
    sigma_s: Light | None = None
    scale: Float | None = None
    g: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class HomogeneousMedium(Medium):
    """The same everywhere. ``Le`` times ``Lescale``: radiance that it emits where it absorbs."""

    KIND = "homogeneous"
    Le: Light | None = None
    Lescale: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class GridMedium(Medium):
    """Times a ``density`` at the middles of nx x ny x nz cells, x fastest, of the box from ``p0`` to ``p1``, m, in the world."""

    KIND = "uniformgrid"
    density: Floats
    nx: Integer
    ny: Integer
    nz: Integer
    p0: Point | None = None
    p1: Point | None = None

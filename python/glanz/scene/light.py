"""Lights.

Parameters have the names, units and defaults of the scene language (docs/scene-format.md); None stands for the default. Of ``power`` (W),
``lumens`` (lm), ``candela`` (cd), ``illuminance`` (lx, on a surface that faces the light) and ``nits`` (cd/m2) a light has at most
one, which replaces the magnitude of its colour; 683 lm are 1 W of its luminance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ._statement import Bool, Float, Integer, Light, Path, Point, Points, String, Vector
from .transform import Transform


@dataclass(frozen=True, eq=False, kw_only=True)
class LightSource:
    """A light. ``transform``: from the light's space to the world; ``scale``: a factor."""

    KIND: ClassVar[str]
    transform: Transform | None = None
    scale: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class PointLight(LightSource):
    """A point at ``from_``, m, of the intensity ``I``, W/sr.

    ``power``: W; ``lumens``: lm; ``candela``: cd, in every direction; ``range``: m, distance at which its light has decreased to 0.
    """

    KIND = "point"
    from_: Point = (0.0, 0.0, 0.0)
    I: Light | None = None
    power: Float | None = None
    lumens: Float | None = None
    candela: Float | None = None
    range: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class SpotLight(LightSource):
    """A cone of light from ``from_`` to ``to``, m, of the intensity ``I``, W/sr, along its axis.

    ``coneangle``, ``conedeltaangle``: degrees; ``power``: W; ``lumens``: lm; ``candela``: cd, along the axis.
    """

    KIND = "spot"
    from_: Point = (0.0, 0.0, 0.0)
    to: Point = (0.0, 0.0, 1.0)
    I: Light | None = None
    coneangle: Float | None = None
    conedeltaangle: Float | None = None
    power: Float | None = None
    lumens: Float | None = None
    candela: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class DistantLight(LightSource):
    """Parallel light in the direction from ``from_`` to ``to``, m.

    ``L``: irradiance of a surface that faces it, W/m2, or ``illuminance``: the same in lx; ``angle``: degrees, diameter of the disk on the sky
    that emits it.
    """

    KIND = "distant"
    from_: Point = (0.0, 0.0, 0.0)
    to: Point = (0.0, 0.0, 1.0)
    L: Light | None = None
    illuminance: Float | None = None
    angle: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class InfiniteLight(LightSource):
    """Light from all directions, constant or from a picture.

    ``L``: radiance, W/(m2 sr), a factor on the picture; ``illuminance``: lx, of a surface that faces z and sees half of all directions;
    ``portal``: m, four corners of a rectangle that it comes through.
    """

    KIND = "infinite"
    L: Light | None = None
    illuminance: Float | None = None
    filename: Path | None = None
    portal: Points | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class ProjectionLight(LightSource):
    """A projector of a picture, times the intensity ``I``, W/sr. ``fov``: degrees of its shorter side; ``power``: W."""

    KIND = "projection"
    filename: Path
    I: Light | None = None
    fov: Float | None = None
    power: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class GoniometricLight(LightSource):
    """A point with a picture of its intensity over all directions, times ``I``, W/sr. ``power``: W."""

    KIND = "goniometric"
    filename: Path | None = None
    I: Light | None = None
    power: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class SkyLight(LightSource):
    """The clear sky and its sun: of a place and time, or of the ``direction`` to the sun. z is up, x east and y north.

    ``latitude``, ``longitude``: degrees, north and east positive; ``time``: as in 2026-06-21T12:00:00+02:00; ``turbidity``: 1 to 10;
    ``albedo``: reflectance of the ground, 0 to 1.
    """

    KIND = "sky"
    latitude: Float | None = None
    longitude: Float | None = None
    time: String | None = None
    direction: Vector | None = None
    turbidity: Float | None = None
    albedo: Light | None = None
    sun: Bool | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class PhotometricLight(LightSource):
    """A luminaire from an IES or EULUMDAT file, or a ray file.

    ``from_``: m, its photometric centre; ``lumens``: lm, in place of the file's flux; ``tilt``: degrees.
    """

    KIND = "photometric"
    filename: Path
    from_: Point = (0.0, 0.0, 0.0)
    lumens: Float | None = None
    color: Light | None = None
    lamps: Integer | None = None
    tilt: Float | None = None
    as_: String | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class AreaLight:
    """Light that a shape emits from the side of its normal, or from both.

    ``L``: radiance, W/(m2 sr); ``nits``: luminance, cd/m2; ``power``: W, ``lumens``: lm, both of the whole shape; ``candela``: cd, along the normal
    of a flat shape or of a whole sphere.
    """

    KIND: ClassVar[str] = "diffuse"
    NAMES: ClassVar[Mapping[str, str]] = {}
    L: Light | None = None
    scale: Float | None = None
    twosided: Bool | None = None
    power: Float | None = None
    lumens: Float | None = None
    candela: Float | None = None
    nits: Float | None = None
    filename: Path | None = None

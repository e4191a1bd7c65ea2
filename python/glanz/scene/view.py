"""Camera, film, filter, sampler and integrator.

Parameters have the names and, but for the size of the film (640 x 480) and the number of samples (16 with every sampler), the defaults of the
scene language (docs/scene-format.md); None stands for the default.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ._statement import Bool, Float, Floats, Integer, Integers, Path, String
from .medium import Medium
from .transform import Transform


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera:
    """A camera at ``eye`` that looks at ``target`` with ``up`` upwards, m. Pictures are not mirrored.

    ``transform``, from the world to the camera (x to the right, y up, z forward), replaces these; ``medium`` is that around the camera.
    """

    KIND: ClassVar[str]
    #: Whether x of the camera is to the left of the direction of view in a right-handed world, so that pictures are mirrored.
    MIRROR: ClassVar[bool] = True
    eye: tuple[float, float, float] = (0.0, 0.0, 0.0)
    target: tuple[float, float, float] = (0.0, 0.0, 1.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    transform: Transform | None = None
    medium: Medium | None = None
    shutteropen: Float | None = None
    shutterclose: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class PerspectiveCamera(Camera):
    """A perspective camera. ``fov``: degrees over the shorter side; ``lensradius`` and ``focaldistance``: m."""

    KIND = "perspective"
    fov: Float = 90.0
    screenwindow: Floats | None = None
    frameaspectratio: Float | None = None
    lensradius: Float | None = None
    focaldistance: Float | None = None
    blades: Integer | None = None
    bladerotation: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class OrthographicCamera(Camera):
    """A parallel projection. ``screenwindow``: smallest and largest x, then y, m."""

    KIND = "orthographic"
    screenwindow: Floats | None = None
    frameaspectratio: Float | None = None
    lensradius: Float | None = None
    focaldistance: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class SphericalCamera(Camera):
    """All directions. ``mapping``: ``equalarea`` or ``equirectangular``."""

    KIND = "spherical"
    MIRROR = False
    mapping: String | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class FisheyeCamera(Camera):
    """A fish-eye. ``fov``: degrees over the diameter; ``projection``: ``equidistant``, ``equisolid`` or ``stereographic``."""

    KIND = "fisheye"
    fov: Float = 180.0
    projection: String | None = None
    screenwindow: Floats | None = None
    frameaspectratio: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class RealisticCamera(Camera):
    """A system of lenses from a file. ``aperturediameter``: mm; ``focusdistance``: m."""

    KIND = "realistic"
    lensfile: Path
    aperturediameter: Float | None = None
    focusdistance: Float | None = None
    aperture: String | None = None
    simpleweighting: Bool | None = None
    blades: Integer | None = None
    bladerotation: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Film:
    """The film: its size in pixels, the part to render, exposure and adaptation."""

    KIND: ClassVar[str] = "rgb"
    xresolution: Integer = 640
    yresolution: Integer = 480
    cropwindow: Floats | None = None
    pixelbounds: Integers | None = None
    diagonal: Float | None = None
    scale: Float | None = None
    iso: Float | None = None
    whitebalance: Float | None = None
    maxcomponentvalue: Float | None = None
    maxsampleluminance: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Filter:
    """The filter of pixels. ``kind``: ``gaussian``, ``box``, ``triangle``, ``mitchell``, ``sinc``, ``cylinder``, ``pyramid`` or ``cone``."""

    kind: str = "gaussian"
    xradius: Float | None = None
    yradius: Float | None = None
    sigma: Float | None = None
    B: Float | None = None
    C: Float | None = None
    tau: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Sampler:
    """The samples. ``kind``: ``sobol``, ``independent``, ``stratified``, ``regular`` or ``center``."""

    kind: str = "sobol"
    pixelsamples: Integer = 16
    seed: Integer | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Integrator:
    """The algorithm. ``kind``: ``path``, ``guided``, ``light``, ``sppm``, ``radiosity``, ``whitted`` or ``distributed``."""

    kind: str = "path"
    maxdepth: Integer = 5
    samplelights: Bool | None = None
    spectral: Bool | None = None
    branching: Integer | None = None
    guide: String | None = None
    radius: Float | None = None
    photonsperiteration: Integer | None = None

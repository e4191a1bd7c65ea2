"""Textures.

Parameters have the names and defaults of the scene language (docs/scene-format.md); None stands for the default. A texture is of colours or of numbers by
the parameter that it is given to, and so are its own textures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, TypeAlias, Union

from ._statement import Bool, Color, Float, Integer, Path, String, Value, Vector
from .transform import Transform


@dataclass(frozen=True, eq=False, kw_only=True)
class Texture:
    """A texture. ``transform``: from its space, for those of points in space and mappings in space."""

    KIND: ClassVar[str]
    transform: Transform | None = None


#: A colour, a number or another texture.
Input: TypeAlias = Annotated[Union[Color, Texture], "texture"]


@dataclass(frozen=True, eq=False, kw_only=True)
class MappedTexture(Texture):
    """A texture over two coordinates. ``mapping``: ``uv``, ``planar``, ``spherical`` or ``cylindrical``."""

    mapping: String | None = None
    uscale: Float | None = None
    vscale: Float | None = None
    udelta: Float | None = None
    vdelta: Float | None = None
    v1: Vector | None = None
    v2: Vector | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class ConstantTexture(Texture):
    """The same everywhere."""

    KIND = "constant"
    value: Input


@dataclass(frozen=True, eq=False, kw_only=True)
class ScaleTexture(Texture):
    """The product of two."""

    KIND = "scale"
    tex: Input
    scale: Value


@dataclass(frozen=True, eq=False, kw_only=True)
class MixTexture(Texture):
    """``tex1`` and ``tex2``, the second by ``amount``."""

    KIND = "mix"
    tex1: Input
    tex2: Input
    amount: Value = 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class CheckerboardTexture(MappedTexture):
    """Squares or cubes of side 1 in turns."""

    KIND = "checkerboard"
    tex1: Input = 1.0
    tex2: Input = 0.0
    dimension: Integer | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class ImageTexture(MappedTexture):
    """A picture file."""

    KIND = "imagemap"
    filename: Path
    wrap: String | None = None
    filter: String | None = None
    maxanisotropy: Float | None = None
    scale: Float | None = None
    invert: Bool | None = None
    encoding: String | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class DotsTexture(MappedTexture):
    """Dots at random places."""

    KIND = "dots"
    inside: Input = 1.0
    outside: Input = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class BilerpTexture(MappedTexture):
    """Linear along both coordinates between four values."""

    KIND = "bilerp"
    v00: Input = 0.0
    v01: Input = 1.0
    v10: Input = 0.0
    v11: Input = 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class FbmTexture(Texture):
    """Noise of several octaves over points in space."""

    KIND = "fbm"
    octaves: Integer | None = None
    roughness: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class WrinkledTexture(FbmTexture):
    """As `FbmTexture`, of absolute values."""

    KIND = "wrinkled"


@dataclass(frozen=True, eq=False, kw_only=True)
class MarbleTexture(FbmTexture):
    """Marble."""

    KIND = "marble"
    scale: Float | None = None
    variation: Float | None = None

"""Materials.

Parameters have the names and defaults of the scene language (docs/scene-format.md), with ``_`` for ``.``; None stands for the default.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ._statement import Bool, Float, Floats, Path, Reflectance, String, Value


@dataclass(frozen=True, eq=False, kw_only=True)
class Material:
    """A material. ``displacement``: heights above the surface, m, that change its normal; ``normalmap``: a picture of normals."""

    KIND: ClassVar[str]
    NAMES: ClassVar[Mapping[str, str]] = {}
    displacement: Value | None = None
    normalmap: Path | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Diffuse(Material):
    """A diffuse surface. ``sigma``: degrees, grooves after Oren and Nayar."""

    KIND = "diffuse"
    reflectance: Reflectance = 0.5
    sigma: Value | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class FinishedMaterial(Material):
    """A smooth material whose ``finish`` scatters light: "gaussian" (``sigma``, ``fraction``) or "abg" (``A``, ``B``, ``g``)."""

    finish: String | None = None
    sigma: Float | None = None
    fraction: Float | None = None
    A: Float | None = None
    B: Float | None = None
    g: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Mirror(FinishedMaterial):
    """A mirror of the reflectance ``Kr``, perfect without a ``finish``."""

    KIND = "mirror"
    Kr: Reflectance = 0.9


@dataclass(frozen=True, eq=False, kw_only=True)
class RoughMaterial(Material):
    """A material with microfacets, from smooth (0) to rough (1)."""

    roughness: Value | None = None
    uroughness: Value | None = None
    vroughness: Value | None = None
    remaproughness: Bool | None = None
    multiplescattering: Bool | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Conductor(RoughMaterial, FinishedMaterial):
    """Metal, of index ``eta`` and absorption ``k``, or of a ``reflectance``. Copper by default."""

    KIND = "conductor"
    eta: Reflectance | None = None
    k: Reflectance | None = None
    reflectance: Reflectance | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Dielectric(RoughMaterial):
    """Glass, of index ``eta``; ``cauchy``: two numbers instead."""

    KIND = "dielectric"
    eta: Reflectance | None = None
    cauchy: Floats | None = None
    Kr: Reflectance | None = None
    Kt: Reflectance | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class ThinDielectric(Material):
    """A thin pane of index ``eta`` (1.5), with factors on the light that it reflects and transmits."""

    KIND = "thindielectric"
    eta: Value | None = None
    Kr: Reflectance | None = None
    Kt: Reflectance | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class CoatedDiffuse(RoughMaterial):
    """A diffuse base under a clear coat."""

    KIND = "coateddiffuse"
    reflectance: Reflectance = 0.5
    eta: Value | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class CoatedConductor(Material):
    """Metal under a clear coat."""

    KIND = "coatedconductor"
    NAMES = {
        "conductor_eta": "conductor.eta",
        "conductor_k": "conductor.k",
        "conductor_roughness": "conductor.roughness",
        "interface_eta": "interface.eta",
        "interface_roughness": "interface.roughness",
    }
    conductor_eta: Reflectance | None = None
    conductor_k: Reflectance | None = None
    conductor_roughness: Value | None = None
    reflectance: Reflectance | None = None
    interface_eta: Value | None = None
    interface_roughness: Value | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class DiffuseTransmission(Material):
    """A diffuse surface that also transmits."""

    KIND = "diffusetransmission"
    reflectance: Reflectance = 0.25
    transmittance: Reflectance = 0.25
    scale: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Mix(Material):
    """One of two materials at each point, the second with the probability ``amount``."""

    KIND = "mix"
    first: Material
    second: Material
    amount: Value = 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Principled(Material):
    """Metallic-roughness, as of glTF."""

    KIND = "principled"
    NAMES = {
        "coat_roughness": "coat.roughness",
        "coat_eta": "coat.eta",
        "sheen_roughness": "sheen.roughness",
        "metal_eta": "metal.eta",
        "metal_k": "metal.k",
    }
    basecolor: Reflectance = 0.8
    metallic: Value | None = None
    roughness: Value | None = None
    uroughness: Value | None = None
    vroughness: Value | None = None
    eta: Value | None = None
    specular: Reflectance | None = None
    transmission: Value | None = None
    thin: Bool | None = None
    coat: Value | None = None
    coat_roughness: Value | None = None
    coat_eta: Value | None = None
    sheen: Reflectance | None = None
    sheen_roughness: Value | None = None
    metal_eta: Reflectance | None = None
    metal_k: Reflectance | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Phong(Material):
    """The model of Phong."""

    KIND = "phong"
    Kd: Reflectance = 0.5
    Ks: Reflectance = 0.5
    exponent: Value | None = None
    Ka: Reflectance | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Interface(Material):
    """No surface: a border of media, or a receiver that light passes."""

    KIND = "interface"

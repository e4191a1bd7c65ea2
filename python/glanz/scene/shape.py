"""Shapes, groups and instances.

Parameters have the names and defaults of the scene language (docs/scene-format.md), lengths in metres and angles in degrees; None stands for the default.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ._statement import Bool, Float, Floats, Integer, Integers, Normals, Path, Point, Points, Points2, String, Value
from .light import AreaLight
from .material import Material
from .medium import Medium
from .transform import Transform
from .trim import Trim


@dataclass(frozen=True, eq=False, kw_only=True)
class Shape:
    """A shape.

    Attributes
    ----------
    material : its material; diffuse by default.
    light : light that it emits.
    transform : from the shape's space to the world or group.
    reverse_orientation : whether the normal points to the other side.
    inside, outside : media on both sides; inside is opposite to the normal.
    trims : loops in the parameters u and v of the shape that cut parts away; ``trimside``: the side to keep, ``outside`` (the default: loops are holes) or
        ``inside``.
    receiver : name of a receiver of `Scene.illuminate`; ``cells``: numbers along u and v; ``receiverside``: ``front``, ``back`` or ``both``.
    alpha : opacity.
    solid : number of the solid that it bounds together with others.
    """

    KIND: ClassVar[str]
    material: Material | None = None
    light: AreaLight | None = None
    transform: Transform | None = None
    reverse_orientation: bool = False
    inside: Medium | None = None
    outside: Medium | None = None
    trims: Sequence[Trim] = ()
    trimside: String | None = None
    receiver: String | None = None
    cells: Integers | None = None
    receiverside: String | None = None
    alpha: Value | None = None
    solid: Integer | None = None

    def derived(self) -> dict[str, tuple[str, ArrayLike]]:
        """Parameters that follow from arrays: name to type and values."""
        return {}


@dataclass(frozen=True, eq=False, kw_only=True)
class Sphere(Shape):
    """A sphere about the origin, or the part from ``zmin`` to ``zmax``."""

    KIND = "sphere"
    radius: Float = 1.0
    zmin: Float | None = None
    zmax: Float | None = None
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Cylinder(Shape):
    """A cylinder about the z axis."""

    KIND = "cylinder"
    radius: Float = 1.0
    zmin: Float = -1.0
    zmax: Float = 1.0
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Cone(Shape):
    """A cone with its base of ``radius`` at z = 0 and its tip at ``height``."""

    KIND = "cone"
    radius: Float = 1.0
    height: Float = 1.0
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Paraboloid(Shape):
    """A paraboloid about the z axis, of ``radius`` at ``zmax``."""

    KIND = "paraboloid"
    radius: Float = 1.0
    zmin: Float = 0.0
    zmax: Float = 1.0
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Hyperboloid(Shape):
    """The line from ``p1`` to ``p2``, turned about the z axis."""

    KIND = "hyperboloid"
    p1: Point = (0.0, 0.0, 0.0)
    p2: Point = (1.0, 1.0, 1.0)
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class TwoSheetedHyperboloid(Shape):
    """z^2 / c^2 - (x^2 + y^2) / a^2 = 1."""

    KIND = "twosheetedhyperboloid"
    a: Float = 1.0
    c: Float = 1.0
    zmin: Float | None = None
    zmax: Float | None = None
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Disk(Shape):
    """A disk at z = ``height``."""

    KIND = "disk"
    height: Float = 0.0
    radius: Float = 1.0
    innerradius: Float | None = None
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Plane(Shape):
    """z = 0. ``x``, ``y``: the smallest and the largest; unbounded by default."""

    KIND = "plane"
    x: Floats | None = None
    y: Floats | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Torus(Shape):
    """A torus about the z axis."""

    KIND = "torus"
    majorradius: Float = 1.0
    minorradius: Float = 0.25
    phimax: Float | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Box(Shape):
    """A box between two corners."""

    KIND = "box"
    min: Point = (-0.5, -0.5, -0.5)
    max: Point = (0.5, 0.5, 0.5)


@dataclass(frozen=True, eq=False, kw_only=True)
class Polyhedron(Shape):
    """Where N . p <= d for all. ``N``: K x 3; ``d``: K."""

    KIND = "polyhedron"
    N: Normals
    d: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Algebraic(Shape):
    """Where a polynomial is zero. ``exponents``: K x 3; ``coefficients``: K; ``clip``: two corners of a box."""

    KIND = "algebraic"
    exponents: Integers
    coefficients: Floats
    clip: Points | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class TriangleMesh(Shape):
    """Triangles. ``P``: K x 3; ``indices``: M x 3; ``N``: K x 3; ``uv``: K x 2."""

    KIND = "trianglemesh"
    P: Points
    indices: Integers | None = None
    N: Normals | None = None
    uv: Points2 | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class BilinearMesh(Shape):
    """Bilinear patches. ``P``: K x 3; ``indices``: M x 4, the corners (0,0) (1,0) (0,1) (1,1)."""

    KIND = "bilinearmesh"
    P: Points
    indices: Integers | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class LoopSubdivision(Shape):
    """Loop's subdivision of a mesh."""

    KIND = "loopsubdiv"
    P: Points
    indices: Integers
    levels: Integer | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Curve(Shape):
    """A curve with a width. ``P``: control points, K x 3."""

    KIND = "curve"
    P: Points
    basis: String | None = None
    degree: Integer | None = None
    type: String | None = None
    width: Float | None = None
    width0: Float | None = None
    width1: Float | None = None
    N: Normals | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class FileShape(Shape):
    """The surfaces of a file."""

    filename: Path


@dataclass(frozen=True, eq=False, kw_only=True)
class PlyMesh(FileShape):
    """A PLY file."""

    KIND = "plymesh"


@dataclass(frozen=True, eq=False, kw_only=True)
class ObjFile(FileShape):
    """An OBJ file."""

    KIND = "obj"


@dataclass(frozen=True, eq=False, kw_only=True)
class StlFile(FileShape):
    """An STL file."""

    KIND = "stl"


@dataclass(frozen=True, eq=False, kw_only=True)
class GltfFile(FileShape):
    """A glTF file with its own materials."""

    KIND = "gltf"


@dataclass(frozen=True, eq=False, kw_only=True)
class StepFile(FileShape):
    """A STEP file or its ``part``. ``colors``: whether it has those of the file; in metres, whatever the unit of the file."""

    KIND = "step"
    part: String | None = None
    colors: Bool | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class IgesFile(StepFile):
    """An IGES file or its ``part``."""

    KIND = "iges"


def _grid(name: str, points: ArrayLike) -> tuple[int, int]:
    shape = np.shape(points)
    if len(shape) != 3 or shape[2] != 3:
        raise ValueError(f"{name} has the shape {shape}; it must be (v, u, 3)")
    return shape[0], shape[1]


def _points(points: ArrayLike, weights: ArrayLike | None) -> tuple[str, str, ArrayLike]:
    """Name, type and values of points, with weights if there are any."""
    if weights is None:
        return "P", "point3", points
    p, w = np.asarray(points, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    if w.shape != p.shape[:-1]:
        raise ValueError(f"weights has the shape {w.shape}; it must be {p.shape[:-1]}, that of the points")
    return "Pw", "float", np.concatenate([p * w[..., None], w[..., None]], axis=-1)


@dataclass(frozen=True, eq=False, kw_only=True)
class Nurbs(Shape):
    """A NURBS surface.

    ``P``: control points, nv x nu x 3 (u is the last index); ``weights``: nv x nu, positive; ``uknots``: nu plus order, ``vknots``: nv plus order; the degrees
    follow. ``u0``, ``u1``, ``v0``, ``v1``: the part to keep.
    """

    KIND = "nurbs"
    P: ArrayLike
    uknots: Floats
    vknots: Floats
    weights: ArrayLike | None = None
    u0: Float | None = None
    u1: Float | None = None
    v0: Float | None = None
    v1: Float | None = None

    def derived(self) -> dict[str, tuple[str, ArrayLike]]:
        nv, nu = _grid("P", self.P)
        name, kind, values = _points(self.P, self.weights)
        uorder, vorder = np.size(self.uknots) - nu, np.size(self.vknots) - nv
        numbers = {"nu": nu, "nv": nv, "uorder": uorder, "vorder": vorder}
        return {**{own: ("integer", value) for own, value in numbers.items()}, name: (kind, values)}


@dataclass(frozen=True, eq=False, kw_only=True)
class BezierPatch(Shape):
    """A Bézier patch. ``P``: control points, (degree in v + 1) x (degree in u + 1) x 3; ``weights``: the same without the 3."""

    KIND = "bezierpatch"
    P: ArrayLike
    weights: ArrayLike | None = None

    def derived(self) -> dict[str, tuple[str, ArrayLike]]:
        nv, nu = _grid("P", self.P)
        name, kind, values = _points(self.P, self.weights)
        return {"udegree": ("integer", nu - 1), "vdegree": ("integer", nv - 1), name: (kind, values)}


@dataclass(frozen=True, eq=False, kw_only=True)
class BezierTriangle(Shape):
    """A triangular Bézier patch. ``P``: control points by descending powers of r, then s, K x 3; ``weights``: K."""

    KIND = "beziertriangle"
    degree: Integer
    P: ArrayLike
    weights: ArrayLike | None = None

    def derived(self) -> dict[str, tuple[str, ArrayLike]]:
        name, kind, values = _points(self.P, self.weights)
        return {name: (kind, values)}


@dataclass(frozen=True, eq=False, kw_only=True)
class Group:
    """Shapes and instances that are placed together, as often as an `Instance` names the group."""

    shapes: Sequence[Shape | Instance]


@dataclass(frozen=True, eq=False, kw_only=True)
class Instance:
    """A group in a place."""

    group: Group
    transform: Transform = field(default_factory=Transform.identity)

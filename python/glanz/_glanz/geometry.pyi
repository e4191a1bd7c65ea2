"""Surfaces: evaluation, measures and intersection with rays."""

from collections.abc import Sequence
from typing import Literal, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

TrimCurve = ArrayLike | tuple[int, ArrayLike, ArrayLike | None, ArrayLike]
"""A polyline (k x 2), or degree, control points (k x 2), weights (k) or None, and knots (k + degree + 1) of a NURBS curve."""

TrimLoop = ArrayLike | Sequence[TrimCurve]
"""A polygon (k x 2), or curves of which each ends where the next starts, the last one at the start of the first."""

@final
class Curvature:
    """Curvatures at points, positive where the surface bends towards its normal; nan where there is no tangent plane."""

    @property
    def gaussian(self) -> NDArray[np.float64]:
        """Product of the principal curvatures, 1/m^2."""
    @property
    def mean(self) -> NDArray[np.float64]:
        """Mean of the principal curvatures, 1/m."""
    @property
    def principal(self) -> NDArray[np.float64]:
        """Smallest and largest curvature of a normal section, 1/m; ... x 2."""

@final
class Area:
    """An area with an estimate of its error; ``float(area)`` is the value."""

    @property
    def value(self) -> float:
        """Square metres."""
    @property
    def error(self) -> float:
        """Estimate of the error, square metres."""
    def __float__(self) -> float: ...

@final
class ClosestPoints:
    """The points of a surface nearest to given points."""

    @property
    def uv(self) -> NDArray[np.float64]:
        """Parameters; ... x 2."""
    @property
    def points(self) -> NDArray[np.float64]:
        """Positions, metres; ... x 3."""
    @property
    def distance(self) -> NDArray[np.float64]:
        """Distances, metres."""
    @property
    def lower_bound(self) -> NDArray[np.float64]:
        """Proven lower bounds on the distances, metres, up to rounding."""

@final
class Hits:
    """The closest hit of each of N rays."""

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Whether the ray meets the surface; N."""
    @property
    def distance(self) -> NDArray[np.float64]:
        """Distance in lengths of the direction: the hit is at origin + distance * direction. inf for a miss; N."""
    @property
    def uv(self) -> NDArray[np.float64]:
        """Parameters of the surface, nan for a miss; N x 2."""
    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals, nan for a miss; N x 3."""
    @property
    def undecided(self) -> NDArray[np.bool_]:
        """Whether the search gave up a part of the surface, so that a hit may be missing; N. Expected to be false everywhere."""

@final
class AllHits:
    """All hits of N rays: those of ray i are at ``offsets[i]`` to ``offsets[i + 1]`` of the other arrays, by ascending distance."""

    @property
    def offsets(self) -> NDArray[np.int64]:
        """Position of the first hit of each ray, and the number of hits M at the end; N + 1."""
    @property
    def ray(self) -> NDArray[np.int64]:
        """Number of the ray of each hit; M."""
    @property
    def distance(self) -> NDArray[np.float64]:
        """Distances in lengths of the direction; M."""
    @property
    def uv(self) -> NDArray[np.float64]:
        """Parameters of the surface; M x 2."""
    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals; M x 3."""
    @property
    def undecided(self) -> NDArray[np.bool_]:
        """Whether the search gave up a part of the surface, so that a hit may be missing; N."""

class Surface:
    """A surface with parameters u and v; the base of all classes of surfaces.

    Parameters outside of the domain are moved to its border; those that are nan give nan. Arrays u and v broadcast against each
    other.
    """

    def evaluate(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.float64]:
        """Points, metres; ... x 3.

        Raises
        ------
        ValueError
            If u and v do not broadcast.
        TypeError
            If they are no real numbers.
        """
    def derivatives(self, u: ArrayLike, v: ArrayLike, order: int = 1) -> NDArray[np.float64]:
        """Partial derivatives; ... x (order + 1) x (order + 1) x 3.

        The derivative of order k by u and l by v is at ``[..., k, l, :]``, the point itself at ``[..., 0, 0, :]``; entries with k + l
        above `order` are nan. At a knot they are those of the piece that starts there.

        Parameters
        ----------
        order
            Highest k + l: 0 to 16, or 0 to 1 for quadrics, planes and tori.

        Raises
        ------
        ValueError
            For an order out of its range, and if u and v do not broadcast.
        """
    def normals(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.float64]:
        """Unit normals; ... x 3. They point along dS/du x dS/dv.

        Where the derivatives vanish, as at the pole of a sphere, they are limits; nan where there is none.
        """
    def curvature(self, u: ArrayLike, v: ArrayLike) -> Curvature:
        """Gaussian, mean and principal curvatures."""
    def contains(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
        """Whether the parameters lie in the domain and, of a trimmed surface, in the kept part."""
    def area(self, tolerance: float = 1e-9) -> Area:
        """The area of the (kept part of the) surface.

        Parameters
        ----------
        tolerance
            Error to reach, square metres. One that cannot be reached is no exception: see `Area.error`.

        Raises
        ------
        ValueError
            If the tolerance is not positive and finite, and for an infinite plane.
        """
    def closest_point(self, points: ArrayLike, tolerance: float | None = None) -> ClosestPoints:
        """The points of the whole surface, trims aside, nearest to `points`.

        Parameters
        ----------
        points
            Metres; ... x 3.
        tolerance
            By how much another point of the surface may be nearer, metres; None for 1e-9 of the diagonal of its box.

        Raises
        ------
        ValueError
            For shapes, coordinates that are not finite, a tolerance that is not positive, and an infinite plane.
        """
    @overload
    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        all_roots: Literal[False] = False,
        t_max: ArrayLike | None = None,
    ) -> Hits: ...
    @overload
    def intersect(
        self, origins: ArrayLike, directions: ArrayLike, all_roots: Literal[True], t_max: ArrayLike | None = None
    ) -> AllHits: ...
    @overload
    def intersect(
        self, origins: ArrayLike, directions: ArrayLike, all_roots: bool, t_max: ArrayLike | None = None
    ) -> Hits | AllHits:
        """The closest hit, or all hits, of rays with the (kept part of the) surface, from both sides.

        Arrays of float64 in C order are read without copies. The result does not depend on the number of threads nor on the order of
        rays.

        Parameters
        ----------
        origins
            Metres; N x 3.
        directions
            Directions of any length above 0; N x 3. Distances are in units of this length.
        all_roots
            Whether to return all hits instead of the closest one; a tangential hit counts once.
        t_max
            Hits count if 0 < distance < t_max: a number, or one per ray; None for infinity.

        Returns
        -------
        Hits or AllHits

        Raises
        ------
        ValueError
            For shapes, numbers that are not finite and directions of length 0, with the number of the ray; for a surface without
            extent.
        TypeError
            For arrays that are not of real numbers.
        """
    @property
    def bounds(self) -> NDArray[np.float64]:
        """Smallest and largest corner of a box that contains the surface, metres; 2 x 3. Of splines it is that of the control points."""
    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges of u and of v; of a triangular patch, in addition, u + v <= 1."""
    @property
    def trimmed(self) -> bool:
        """Whether trims cut parts away."""

class Nurbs(Surface):
    """A NURBS surface; its normal points along dS/du x dS/dv.

    Parameters
    ----------
    control_points
        Metres; n x m x 3, the first index along u.
    weights
        Positive; n x m. None for a polynomial surface.
    knots_u, knots_v
        n + degree + 1 and m + degree + 1 numbers that do not decrease, clamped or not. The degrees, 1 to 25, follow from their counts.
    trims
        Closed loops in the parameter plane, which keep the points on their left: counter-clockwise loops keep their inside, clockwise
        ones cut it out. A loop is a polygon (k x 2), or a list of curves of which each ends where the next starts; a curve is a
        polyline (k x 2) or a tuple (degree, control points, weights or None, knots).

    Raises
    ------
    ValueError
        For shapes that do not match, numbers that are not finite, weights that are not positive, knots that decrease or repeat too
        often, and loops that are not closed.
    TypeError
        If knots are missing or something is no array of real numbers.
    """

    def __new__(
        cls,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        knots_u: ArrayLike | None = None,
        knots_v: ArrayLike | None = None,
        trims: Sequence[TrimLoop] | None = None,
    ) -> Nurbs: ...
    @property
    def control_points(self) -> NDArray[np.float64]:
        """Metres; n x m x 3."""
    @property
    def weights(self) -> NDArray[np.float64]:
        """1 without weights; n x m."""
    @property
    def knots_u(self) -> NDArray[np.float64]:
        """Knots in u."""
    @property
    def knots_v(self) -> NDArray[np.float64]:
        """Knots in v."""
    @property
    def degree(self) -> tuple[int, int]:
        """Degrees in u and in v."""
    def transposed(self) -> Nurbs:
        """The surface with u and v exchanged; its normal points to the other side.

        Raises
        ------
        ValueError
            If it is trimmed.
        """
    def restrict(self, u: tuple[float, float], v: tuple[float, float]) -> Nurbs:
        """The part over a rectangle of the domain, with clamped knots.

        Raises
        ------
        ValueError
            For ranges that are empty or leave the domain, and if it is trimmed.
        """

@final
class BezierPatch(Nurbs):
    """A Bézier patch over the unit square: a NURBS surface without inner knots.

    Parameters
    ----------
    control_points
        Metres; (degree in u + 1) x (degree in v + 1) x 3, degrees 1 to 25.
    weights
        Positive, as many; None for a polynomial patch.
    """

    def __new__(cls, control_points: ArrayLike, weights: ArrayLike | None = None) -> BezierPatch: ...

@final
class BezierTriangle(Surface):
    """A Bézier patch of degree n over the triangle u >= 0, v >= 0, u + v <= 1; the barycentric coordinates are r = 1 - u - v, s = u, t = v.

    Parameters
    ----------
    control_points
        Metres; (n + 1) (n + 2) / 2 x 3. Powers of r descending, then those of s: (n, 0, 0), (n - 1, 1, 0), (n - 1, 0, 1),
        (n - 2, 2, 0), ..., (0, 0, n).
    weights
        Positive, as many; None for a polynomial patch.
    """

    def __new__(cls, control_points: ArrayLike, weights: ArrayLike | None = None) -> BezierTriangle: ...
    @property
    def control_points(self) -> NDArray[np.float64]:
        """Metres; (n + 1) (n + 2) / 2 x 3."""
    @property
    def weights(self) -> NDArray[np.float64]:
        """1 without weights."""
    @property
    def degree(self) -> int:
        """The degree n."""

@final
class Sphere(Surface):
    """The part of a sphere about the origin with z in a range (None for all) and azimuth up to phi_max, as of all classes 2 pi by default.

    u is the azimuth and v the polar angle from the smallest z to the largest, as fractions of their ranges. The normal points outward.
    """

    def __new__(
        cls, radius: float = 1.0, z: tuple[float, float] | None = None, phi_max: float = ...
    ) -> Sphere: ...

@final
class Cylinder(Surface):
    """A cylinder about the z axis, open at both ends; u is the azimuth, v the height, as fractions. The normal points outward."""

    def __new__(
        cls, radius: float = 1.0, z: tuple[float, float] = (-1.0, 1.0), phi_max: float = ...
    ) -> Cylinder: ...

@final
class Cone(Surface):
    """A cone about the z axis, open at its base z = 0, with the apex at z = height; u is the azimuth, v the height, as fractions."""

    def __new__(cls, radius: float = 1.0, height: float = 1.0, phi_max: float = ...) -> Cone: ...

@final
class Paraboloid(Surface):
    """The paraboloid about the z axis with its vertex at the origin and `radius` at the larger z; u is the azimuth, v the height, as fractions."""

    def __new__(
        cls, radius: float = 1.0, z: tuple[float, float] = (0.0, 1.0), phi_max: float = ...
    ) -> Paraboloid: ...

@final
class Hyperboloid(Surface):
    """The surface that the segment from p1 to p2 sweeps about the z axis; u is the azimuth, v the position on the segment, as fractions."""

    def __new__(
        cls, p1: tuple[float, float, float], p2: tuple[float, float, float], phi_max: float = ...
    ) -> Hyperboloid: ...

@final
class TwoSheetedHyperboloid(Surface):
    """The hyperboloid of two sheets about the z axis with the half axes a (radial) and c (along z), in a range of z."""

    def __new__(cls, a: float, c: float, z: tuple[float, float], phi_max: float = ...) -> TwoSheetedHyperboloid: ...

@final
class Disk(Surface):
    """A disk, or a ring, at z = height; u is the azimuth as a fraction of its range, v is 0 at the outer radius and 1 at the inner one."""

    def __new__(
        cls, radius: float = 1.0, inner_radius: float = 0.0, height: float = 0.0, phi_max: float = ...
    ) -> Disk: ...

@final
class Plane(Surface):
    """The plane z = 0, or a rectangle of it; u and v are x and y as fractions of their ranges (default: infinite), or in metres along an
    axis without end. The normal is +z.
    """

    def __new__(cls, x: tuple[float, float] = ..., y: tuple[float, float] = ...) -> Plane: ...

@final
class Torus(Surface):
    """A torus about the z axis: a tube of radius `minor` around a circle of radius `major`, minor < major. The normal points outward."""

    def __new__(cls, major: float = 1.0, minor: float = 0.25, phi_max: float = ...) -> Torus: ...

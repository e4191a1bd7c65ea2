"""Surfaces alone: NURBS, Bézier patches and quadrics, evaluated, measured and intersected with rays, on numpy arrays.

Lengths are metres and angles radians. Arrays of float64 in C order are read without copies; whatever else numpy converts to real
numbers is converted. Long calls let other Python threads run; those on many points or rays
use all processors and end with Ctrl-C.

>>> import numpy as np
>>> from glanz.geometry import Sphere
>>> hits = Sphere(2.0).intersect(np.array([[-5.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]))
>>> float(hits.distance[0])
3.0
"""

from ._glanz.geometry import (
    AllHits,
    Area,
    BezierPatch,
    BezierTriangle,
    ClosestPoints,
    Cone,
    Curvature,
    Cylinder,
    Disk,
    Hits,
    Hyperboloid,
    Nurbs,
    Paraboloid,
    Plane,
    Sphere,
    Surface,
    Torus,
    TwoSheetedHyperboloid,
)

__all__ = [
    "AllHits",
    "Area",
    "BezierPatch",
    "BezierTriangle",
    "ClosestPoints",
    "Cone",
    "Curvature",
    "Cylinder",
    "Disk",
    "Hits",
    "Hyperboloid",
    "Nurbs",
    "Paraboloid",
    "Plane",
    "Sphere",
    "Surface",
    "Torus",
    "TwoSheetedHyperboloid",
]

"""Surfaces with known answers, for tests."""

import math

import numpy as np
from numpy.typing import NDArray

from glanz.geometry import Nurbs

Floats = NDArray[np.float64]


def clamped(degree: int, count: int) -> Floats:
    """Clamped knots over [0, 1] at equal distances."""
    inner = np.linspace(0.0, 1.0, count - degree + 1)
    return np.concatenate([np.zeros(degree), inner, np.ones(degree)])


def net(seed: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Control points, weights and knots of a hilly surface over about the unit square."""
    random = np.random.default_rng(seed)
    degrees = random.integers(1, 5, 2)
    n, m = degrees + random.integers(2, 6, 2)
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, m), indexing="ij")
    points = np.stack([x, y, random.uniform(-0.2, 0.2, (n, m))], axis=-1)
    weights = random.uniform(0.5, 2.0, (n, m))
    return points, weights, clamped(int(degrees[0]), int(n)), clamped(int(degrees[1]), int(m))


def hills(seed: int) -> Nurbs:
    """The surface of `net`."""
    points, weights, knots_u, knots_v = net(seed)
    return Nurbs(points, weights, knots_u, knots_v)


def nurbs_sphere() -> Nurbs:
    """The unit sphere as a rational biquadratic surface."""
    w = math.sqrt(0.5)
    circle = [(1, 0, 1), (1, 1, w), (0, 1, 1), (-1, 1, w), (-1, 0, 1), (-1, -1, w), (0, -1, 1), (1, -1, w), (1, 0, 1)]
    profile = [(0, -1, 1), (1, -1, w), (1, 0, 1), (1, 1, w), (0, 1, 1)]
    points = np.array([[(r * x, r * y, z) for r, z, _ in profile] for x, y, _ in circle], dtype=float)
    weights = np.array([[a * b for _, _, b in profile] for _, _, a in circle])
    knots_u = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]) / 4
    return Nurbs(points, weights, knots_u, np.array([0, 0, 0, 1, 1, 2, 2, 2]) / 2)


def rays(seed: int, count: int, center: Floats, radius: float) -> tuple[Floats, Floats]:
    """Lines between random points of a sphere of 3 radii and of a ball, with directions of any length."""
    random = np.random.default_rng(seed)
    start = random.normal(size=(count, 3))
    origins = center + 3 * radius * start / np.linalg.norm(start, axis=1, keepdims=True)
    target = center + radius * random.uniform(-0.6, 0.6, (count, 3))
    return origins, (target - origins) * random.uniform(0.1, 3.0, (count, 1))

"""Transformations of space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._statement import numbers


@dataclass(frozen=True, eq=False)
class Transform:
    """An affine transformation. ``matrix``: 4 x 4, applied to columns (x, y, z, 1); ``a @ b`` applies b first.

    Raises
    ------
    ValueError
        If the matrix is not 4 x 4.
    """

    matrix: ArrayLike

    def __post_init__(self) -> None:
        matrix = np.array(self.matrix, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise ValueError(f"the matrix of a transformation has the shape {matrix.shape}; it must be (4, 4)")
        object.__setattr__(self, "matrix", matrix)

    @staticmethod
    def identity() -> Transform:
        """The transformation that changes nothing."""
        return Transform(np.eye(4))

    @staticmethod
    def translate(x: float, y: float, z: float) -> Transform:
        """A translation, m."""
        matrix = np.eye(4)
        matrix[:3, 3] = x, y, z
        return Transform(matrix)

    @staticmethod
    def scale(x: float, y: float | None = None, z: float | None = None) -> Transform:
        """A scale along the axes; by ``x`` along all, if it is the only one."""
        return Transform(np.diag([x, x if y is None else y, x if z is None else z, 1.0]))

    @staticmethod
    def rotate(degrees: float, axis: ArrayLike) -> Transform:
        """A rotation about an axis through the origin, counterclockwise where the axis points to the viewer."""
        x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        angle = np.radians(degrees)
        matrix = np.eye(4)
        matrix[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
        return Transform(matrix)

    def __matmul__(self, other: Transform) -> Transform:
        return Transform(self.array @ other.array)

    @property
    def array(self) -> NDArray[np.float64]:
        """The matrix as an array."""
        return np.asarray(self.matrix, dtype=np.float64)

    def statement(self, directive: str = "ConcatTransform") -> str:
        """The transformation in the scene language."""
        return f"{directive} [ {numbers(self.array.T)} ]"

"""Densities that are fitted to their own samples, and integrals with them."""

from collections.abc import Callable, Sequence
from typing import Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Basis = Literal[
    "haar", "spline0", "spline1", "spline2", "spline3", "spline4", "spline5", "spline6", "spline7"
]
"""Haar's box functions, or B-splines of a degree."""

Pattern = Literal["independent", "stratified", "sobol"]
"""Independent uniform numbers; one point per cell of a grid (their number is rounded up); Owen-scrambled Sobol' points."""

Method = Literal["own", "own-constant", "all"]
"""Coefficients from the samples of their own functions, with the mean of neighbours, or the integral, for functions without samples;
or from all samples."""

Weighting = Literal["samples", "variance"]
"""Passes weigh as their numbers of samples, or as their inverse variances (less variance, but a small bias)."""

Integrand = Callable[[NDArray[np.float64]], ArrayLike]
"""A function of N x D points in the unit cube that returns N values."""

@final
class DensitySamples:
    """Points drawn from a density, with their densities."""

    def __new__(cls, points: ArrayLike, pdf: ArrayLike, functions: ArrayLike | None = None) -> DensitySamples: ...
    @property
    def points(self) -> NDArray[np.float64]:
        """Points in the unit cube; N x D."""
    @property
    def pdf(self) -> NDArray[np.float64]:
        """Densities at the points; N."""
    @property
    def functions(self) -> NDArray[np.int64] | None:
        """Numbers of the basis functions from which they were drawn; N. None if unknown."""
    def __len__(self) -> int: ...

@final
class Integral:
    """An integral estimated from samples."""

    @property
    def mean(self) -> float:
        """The integral."""
    @property
    def standard_error(self) -> float:
        """Standard deviation of the mean; inf if it cannot be estimated: patterns other than "independent" need repetitions."""
    @property
    def primary_variance(self) -> float:
        """Variance of integrand / density of a single sample."""
    @property
    def samples(self) -> int:
        """Number of values of the integrand."""

@final
class AdaptiveIntegral:
    """An integral in passes."""

    @property
    def total(self) -> Integral:
        """The integral from all passes."""
    @property
    def passes(self) -> list[Integral]:
        """The integrals from the samples of the single passes."""
    @property
    def density(self) -> AdaptiveDensity:
        """The density after the last pass."""

@final
class AdaptiveDensity:
    """A density on the unit cube that is fitted to an integrand from its own samples, from coarse to fine.

    It starts as the constant 1. Integrate with it (`integrate`, or `sample` and `record`), `fit` it to what was recorded, `refine` its
    levels, and so on. The estimator integrand / pdf is unbiased in every pass.

    Parameters
    ----------
    dimension
        1 to 4.
    basis
        Basis functions: one name, or one per axis.
    levels
        Levels of the basis, which has 2^level segments per axis: one, or one per axis.
    max_level
        Finest level for `refine`, 0 to 16.
    method
        Method of fitting.

    Raises
    ------
    ValueError
        For each argument out of its range, and for more than 2^24 functions.
    """

    def __new__(
        cls,
        dimension: int,
        basis: Basis | Sequence[Basis] | None = None,
        levels: int | Sequence[int] | None = None,
        *,
        max_level: int = 8,
        method: Method = "own",
    ) -> AdaptiveDensity: ...
    @property
    def dimension(self) -> int:
        """Dimension D of the unit cube."""
    @property
    def levels(self) -> tuple[int, ...]:
        """Levels of the basis, one per axis."""
    @property
    def max_level(self) -> int:
        """Finest possible level."""
    @property
    def coefficients(self) -> NDArray[np.float64]:
        """Coefficients of the density in the tensor product basis, an axis per dimension."""
    @property
    def recorded(self) -> int:
        """Number of samples recorded since the last fit."""
    def sample(self, xi: ArrayLike) -> DensitySamples:
        """Points drawn from the density by uniform numbers.

        Parameters
        ----------
        xi
            Numbers in [0, 1); N x D. Each point follows from its own numbers, so that stratified or quasi-random ones stay so.

        Raises
        ------
        ValueError
            For shapes and numbers outside of [0, 1).
        """
    def pdf(self, x: ArrayLike) -> NDArray[np.float64]:
        """The density at points x, N x D; 0 outside of the unit cube."""
    def record(self, samples: DensitySamples, values: ArrayLike) -> int:
        """Records values of the integrand at samples of this density; returns the number of those that are accepted.

        Values that are not finite, and samples whose density is not positive or whose function does not exist, are not. With the method "all", samples may come from any density and need no functions.

        Raises
        ------
        ValueError
            For shapes, points outside of the unit cube, samples without functions, and functions that are not whole numbers from 0.
        """
    def integrate(
        self,
        integrand: Integrand,
        samples: int = 4096,
        *,
        repetitions: int = 1,
        pattern: Pattern = "independent",
        seed: int = 1,
    ) -> Integral:
        """The integral of a function by samples of this density, which are recorded for `fit`.

        The function is called with up to 4096 points at once. Values that are not finite count as 0. If the function raises, nothing is
        recorded; changes that it makes to this density are lost.

        Raises
        ------
        ValueError
            For arguments, and if the function does not return one number per point. Exceptions of the function go through.
        """
    def fit(self, floor: float = 0.1, weighting: Weighting = "samples") -> NDArray[np.float64] | None:
        """Fits the density to the recorded samples, combined with those of earlier fits on the same levels.

        Parameters
        ----------
        floor
            Lower bound on the density, 0 to 1, nearly everywhere: with 0 it may vanish where the integrand does not.

        Returns
        -------
        Coefficients of the approximation of the integrand, or None, and no change, if all values were 0 or there were no samples.

        Raises
        ------
        ValueError
            For the floor and for the values, if their sum is not finite.
        """
    def refine(self, levels: int | Sequence[int]) -> None:
        """Converts the density to finer levels: one, or one per axis. Samples that were not fitted are dropped.

        Raises
        ------
        ValueError
            If a level is coarser than now or finer than `max_level`, and for more than 2^24 functions.
        """
    def copy(self) -> AdaptiveDensity:
        """A copy that changes on its own."""

def integrate(
    integrand: Integrand,
    dimension: int,
    passes: Sequence[tuple[int | Sequence[int], int]],
    *,
    basis: Basis | Sequence[Basis] | None = None,
    max_level: int = 8,
    repetitions: int = 1,
    pattern: Pattern = "independent",
    seed: int = 1,
    floor: float = 0.1,
    method: Method = "own",
    weighting: Weighting = "samples",
    progress: Callable[[int, int], object] | None = None,
) -> AdaptiveIntegral:
    """The integral of a function over the unit cube, in passes, each with a density fitted to the samples of those before it.

    Parameters
    ----------
    integrand
        Function of up to 4096 x D points that returns their values. Those that are not finite count as 0.
    passes
        Levels (one, or one per axis) and number of samples of each pass; levels must not become coarser.
    repetitions
        Number of repetitions of each pass with other random numbers. Patterns other than "independent" need several to estimate an
        error.
    progress
        Function that is called with the numbers of samples done and to be done.

    Raises
    ------
    ValueError
        For arguments. Exceptions of the functions, and KeyboardInterrupt, go through.
    """

def sobol(count: int, dimension: int = 2, seed: int = 1, first: int = 0) -> NDArray[np.float64]:
    """Points of an Owen-scrambled Sobol' sequence in the unit cube, [0, 1); count x dimension.

    Each group of four dimensions is a sequence with a scrambling of its own. `first`: number of the first point, 0 to 2^32 - 1.
    """

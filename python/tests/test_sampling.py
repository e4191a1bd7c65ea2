"""Densities and integrals with known answers; significance levels are stated at the statistical tests."""

import importlib
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from glanz import sampling as s

Floats = NDArray[np.float64]
chisquare: Any = importlib.import_module("scipy.stats").chisquare


def ridge(x: Floats) -> Floats:
    """A ridge over the unit square; its integral is RIDGE."""
    return (1 + x[:, 1] ** 2) / (1 + 400 * (x[:, 0] - 1 / 3) ** 2)


RIDGE = 4 / 3 * (math.atan(40 / 3) + math.atan(20 / 3)) / 20


def fitted() -> s.AdaptiveDensity:
    density = s.AdaptiveDensity(2, ["haar", "spline2"], [2, 0])
    for levels in ([2, 0], [3, 0], [4, 1], [5, 1]):
        density.refine(levels)
        density.integrate(ridge, 4096, pattern="sobol")
        assert density.recorded == 4096
        assert density.fit(floor=0.05) is not None
    return density


def test_a_new_density_is_constant() -> None:
    for dimension in range(1, 5):
        density = s.AdaptiveDensity(dimension)
        x = np.random.default_rng(1).uniform(0, 1, (100, dimension))
        np.testing.assert_allclose(density.pdf(x), 1, rtol=1e-13)
        np.testing.assert_allclose(density.sample(x).pdf, 1, rtol=1e-13)
        assert density.coefficients.shape == (2,) * dimension and density.dimension == dimension
        assert density.levels == (0,) * dimension


def test_samples_of_a_fitted_density_follow_its_pdf() -> None:
    density = fitted()
    drawn = density.sample(np.random.default_rng(2).uniform(0, 1, (200_000, 2)))
    assert len(drawn) == 200_000
    np.testing.assert_array_equal(density.pdf(drawn.points), drawn.pdf)
    # Midpoints of 10 x 10 in each of 32 x 8 cells: the density is a polynomial of degree 0 times 2 in each of them.
    cells, fine = (32, 8), 10
    x = (np.arange(32 * fine) + 0.5) / (32 * fine)
    y = (np.arange(8 * fine) + 0.5) / (8 * fine)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    masses = density.pdf(grid).reshape(32, fine, 8, fine).mean(axis=(1, 3)) / 256
    assert abs(masses.sum() - 1) < 1e-3
    observed, _, _ = np.histogram2d(drawn.points[:, 0], drawn.points[:, 1], bins=cells, range=[[0, 1]] * 2)
    # Significance 1e-4.
    assert chisquare(observed.ravel(), masses.ravel() / masses.sum() * 200_000).pvalue > 1e-4


@pytest.mark.parametrize("basis", ["haar", "spline0", "spline1", "spline3"])
def test_pdfs_integrate_to_one(basis: Any) -> None:
    density = s.AdaptiveDensity(1, basis, 3)
    density.integrate(lambda x: np.exp(3 * x[:, 0]), 2000)
    density.fit()
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x = np.concatenate([(k + (nodes + 1) / 2) / 8 for k in range(8)])
    assert abs(np.sum(density.pdf(x[:, None]) * np.tile(weights / 16, 8)) - 1) < 1e-12
    np.testing.assert_array_equal(density.pdf([[-0.1], [1.1]]), [0, 0])


def test_adaptive_passes_reduce_the_variance_of_a_ridge() -> None:
    passes = [([2, 0], 1024), ([3, 0], 2048), ([4, 1], 4096), ([5, 1], 20_000)]
    calls: list[tuple[int, int]] = []
    found = s.integrate(ridge, 2, passes, basis=["haar", "spline2"], floor=0.05, progress=lambda a, b: calls.append((a, b)))
    assert calls[-1] == (27_168, 27_168) and found.total.samples == 27_168
    # 4.5 standard errors: significance 1e-5.
    assert abs(found.total.mean - RIDGE) < 4.5 * found.total.standard_error
    assert found.passes[-1].primary_variance < found.passes[0].primary_variance / 20
    assert found.density.levels == (5, 1)


def test_the_linear_density_of_sine_has_the_published_variance() -> None:
    found = s.integrate(
        lambda x: np.sin(np.pi / 2 * x[:, 0]), 1, [(0, 20_000), (1, 20_000), (2, 20_000), (2, 20_000)], max_level=2, floor=0.01
    )
    assert abs(found.total.mean - 2 / math.pi) < 4.5 * found.total.standard_error
    # Of uniform samples: 1/2 - 4/pi^2.
    assert abs(found.passes[0].primary_variance - (0.5 - 4 / math.pi**2)) < 0.005
    assert found.passes[3].primary_variance < found.passes[0].primary_variance / 200


def test_own_samples_can_be_recorded() -> None:
    density = s.AdaptiveDensity(1, "spline1", 2)
    drawn = density.sample(s.sobol(4096, 1))
    assert density.record(drawn, np.where(drawn.points[:, 0] < 0.5, 1.0, math.nan)) < 4096
    whole = s.AdaptiveDensity(1, "haar", 1, method="all")
    x = s.sobol(4096, 1)
    assert whole.record(s.DensitySamples(x, np.ones(4096)), (x[:, 0] < 0.5).astype(np.float32)) == 4096
    approximation = whole.fit(floor=0)
    assert approximation is not None
    np.testing.assert_allclose(approximation, [1 / math.sqrt(2), 0], atol=1e-12)
    np.testing.assert_allclose(whole.pdf([[0.25], [0.75]]), [2, 0])
    with pytest.raises(ValueError, match="functions"):
        density.record(s.DensitySamples(x, np.ones(4096)), x[:, 0])


def test_a_copy_changes_on_its_own_and_zero_changes_nothing() -> None:
    density = s.AdaptiveDensity(1, "spline1", 2)
    other = density.copy()
    other.integrate(lambda x: x[:, 0], 1000)
    other.fit()
    assert density.recorded == 0 and float(density.pdf([[0.9]])[0]) != float(other.pdf([[0.9]])[0])
    density.integrate(lambda x: 0 * x[:, 0], 100)
    assert density.fit() is None
    np.testing.assert_allclose(density.pdf([[0.1], [0.9]]), 1)


def test_sobol_points_are_stratified_and_depend_on_their_numbers_alone() -> None:
    points = s.sobol(1024, 6, seed=3)
    assert points.shape == (1024, 6) and points.min() >= 0 and points.max() < 1
    for axis in range(6):
        assert (np.bincount((points[:, axis] * 1024).astype(int), minlength=1024) == 1).all()
    np.testing.assert_array_equal(s.sobol(24, 6, seed=3, first=1000), points[1000:])
    assert (s.sobol(1024, 6, seed=4) != points).any()


def test_an_integrand_may_use_its_density_and_records_nothing_if_it_raises() -> None:
    density = s.AdaptiveDensity(1)
    density.integrate(lambda x: density.pdf(x), 5000)
    assert density.recorded == 5000
    with pytest.raises(ZeroDivisionError):
        density.integrate(lambda x: x[:, 0] if len(x) == 4096 else 1 // 0 * x, 5000)
    assert density.recorded == 5000


def test_samples_without_density_or_function_are_not_accepted() -> None:
    density = s.AdaptiveDensity(1, "spline1", 2)
    drawn = density.sample(s.sobol(16, 1))
    assert drawn.functions is not None and density.record(drawn, np.ones(16)) == 16
    for pdf, functions in [(-drawn.pdf, drawn.functions), (0 * drawn.pdf, drawn.functions), (drawn.pdf, drawn.functions + 1000)]:
        assert density.record(s.DensitySamples(drawn.points, pdf, functions), np.ones(16)) == 0
    for value in (math.nan, -3.7, 1.9):
        with pytest.raises(ValueError, match="functions contain"):
            density.record(s.DensitySamples(drawn.points, drawn.pdf, [value] * 16), np.ones(16))


def test_progress_of_stratified_samples_ends_at_its_total() -> None:
    calls: list[tuple[int, int]] = []
    s.integrate(lambda x: x[:, 0], 4, [(0, 17)], pattern="stratified", progress=lambda a, b: calls.append((a, b)))
    assert calls[-1] == (81, 81)


def test_exceptions_of_the_integrand_go_through() -> None:
    def interrupted(x: Floats) -> Floats:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        s.integrate(interrupted, 1, [(0, 100)])
    with pytest.raises(ZeroDivisionError):
        s.AdaptiveDensity(1).integrate(lambda x: np.full(len(x), 1 // (len(x) - len(x))), 10)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: s.AdaptiveDensity(0), "dimension is 0"),
        (lambda: s.AdaptiveDensity(5), "dimension is 5"),
        (lambda: s.AdaptiveDensity(-1), "whole number"),
        (lambda: s.AdaptiveDensity(1, max_level=-1), "whole number"),
        (lambda: s.AdaptiveDensity(1, levels=-1), "whole number"),
        (lambda: s.AdaptiveDensity(2, levels=[0, -1]), "whole number"),
        (lambda: s.AdaptiveDensity(1).integrate(lambda x: x[:, 0], -5), "whole number"),
        (lambda: s.AdaptiveDensity(1).integrate(lambda x: x[:, 0], seed=-1), "whole number"),
        (lambda: s.integrate(lambda x: x[:, 0], 1, [(0, -1)]), "whole number"),
        (lambda: s.sobol(-1), "whole number"),
        (lambda: s.sobol(1, first=2**32), "first is 4294967296"),
        (lambda: s.AdaptiveDensity(1, "cosine"), "basis"),  # pyright: ignore[reportArgumentType]
        (lambda: s.AdaptiveDensity(2, ["haar"]), "basis has 1 entries"),
        (lambda: s.AdaptiveDensity(1, levels=9), "level is 9"),
        (lambda: s.AdaptiveDensity(1, max_level=17), "level is 17"),
        (lambda: s.AdaptiveDensity(4, "haar", 8), "functions"),
        (lambda: s.AdaptiveDensity(2).sample([[0.5, 1.0]]), "xi contains 1"),
        (lambda: s.AdaptiveDensity(2).sample([[0.5, math.nan]]), "xi contains NaN"),
        (lambda: s.AdaptiveDensity(2).sample([0.5, 0.5]), "xi has shape"),
        (lambda: s.AdaptiveDensity(2).pdf([[0.5]]), "x has shape"),
        (lambda: s.AdaptiveDensity(1, levels=2).refine(1), "level"),
        (lambda: s.AdaptiveDensity(1).fit(floor=-1), "floor is -1"),
        (lambda: s.integrate(lambda x: x, 1, [(0, 10)]), "values of the integrand has shape|one number per point"),
        (lambda: s.integrate(lambda x: x[:, 0], 1, []), "passes"),
        (lambda: s.integrate(lambda x: x[:, 0], 1, [(0, 0)]), "samples"),
        (lambda: s.integrate(lambda x: x[:, 0], 1, [(2, 10), (1, 10)]), "level"),
        (lambda: s.AdaptiveDensity(1).integrate(lambda x: x[:, 0], 0), "samples is 0"),
        (lambda: s.sobol(10, 0), "dimension is 0"),
        (lambda: s.sobol(10, 2, first=2**32 - 1), "2\\^32"),
    ],
)
def test_bad_arguments_are_value_errors(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()

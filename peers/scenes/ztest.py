"""Whether two programs estimate the same picture, from independent renders of each."""

from typing import NamedTuple

import numpy
from scipy import stats


class Level(NamedTuple):
    """Tests at one size of blocks: of every block and channel whether both means agree (Welch's t-test)."""

    block: int
    tests: int
    smallest_p: float
    """Of the family: Sidak's correction for the number of tests."""
    beyond: float
    """Fraction of |z| above 2.576; 1 % is expected."""
    variance: float
    """Of z; 1 is expected."""
    z: numpy.ndarray


def blocks(pictures: numpy.ndarray, size: int) -> numpy.ndarray:
    """Means over blocks of `size` x `size` pixels of pictures (n, h, w, 3)."""
    n, h, w, c = pictures.shape
    return pictures.reshape(n, h // size, size, w // size, size, c).mean(axis=(2, 4))


def level(first: numpy.ndarray, second: numpy.ndarray, size: int) -> Level:
    a, b = blocks(first, size), blocks(second, size)
    va, vb = a.var(axis=0, ddof=1) / len(a), b.var(axis=0, ddof=1) / len(b)
    difference, error2 = a.mean(axis=0) - b.mean(axis=0), va + vb
    # Without noise (black, or a light seen alone) the means must agree up to single precision.
    scale = numpy.abs(a.mean(axis=0)) + numpy.abs(b.mean(axis=0))
    still = error2 <= (2e-6 * scale) ** 2
    freedom = error2**2 / numpy.maximum(va**2 / (len(a) - 1) + vb**2 / (len(b) - 1), 1e-300)
    t = difference / numpy.sqrt(numpy.where(still, 1, error2))
    p = numpy.where(still, numpy.where(numpy.abs(difference) <= 2e-5 * scale, 1.0, 0.0), 2 * stats.t.sf(numpy.abs(t), numpy.maximum(freedom, 1)))
    # The normal number of the same probability, so that few renders do not widen the distribution.
    z = numpy.where(still, 0, numpy.sign(difference) * stats.norm.isf(numpy.clip(p, 1e-300, 1) / 2))
    tests, noisy = p.size, numpy.abs(z[~still])
    smallest = -numpy.expm1(tests * numpy.log1p(-min(p.min(), 1 - 1e-16)))
    return Level(size, tests, float(smallest), float((noisy > 2.576).mean()) if noisy.size else 0.0,
                 float((noisy**2).mean()) if noisy.size else 0.0, z)


def variance_ratio(first: numpy.ndarray, second: numpy.ndarray) -> dict[str, float]:
    """Variance of single renders, first over second: of the relative errors of all pixels together, without the worst 1 % of each, and the median over the pixels with noise."""
    mean2 = second.mean(axis=0) ** 2
    relative = [p.var(axis=0, ddof=1) / (mean2 + 1e-2 * mean2.mean()) for p in (first, second)]
    noisy = (relative[0] > 1e-9) & (relative[1] > 1e-9)
    kept = [numpy.sort(r.ravel())[: int(0.99 * r.size)].mean() for r in relative]
    return {"mean": float(relative[0].mean() / relative[1].mean()), "without_worst_percent": float(kept[0] / kept[1]), "median": float(numpy.median(relative[0][noisy] / relative[1][noisy]))}


def compare(first: numpy.ndarray, second: numpy.ndarray) -> dict[str, object]:
    """Tests pixels, blocks of 8 x 8 and the whole picture, each family at a third of 1 %: agreement is rejected by mistake in 1 % of all cases."""
    height = first.shape[1]
    levels = [level(first, second, size) for size in (1, 8, height)]
    a, b = first.mean(axis=(1, 2, 3)), second.mean(axis=(1, 2, 3))
    ratio = a.mean() / b.mean()
    error = ratio * numpy.sqrt(a.var(ddof=1) / len(a) / a.mean() ** 2 + b.var(ddof=1) / len(b) / b.mean() ** 2)
    return {"levels": levels, "ratio": float(ratio), "ratio_error": float(error), "variance_ratio": variance_ratio(first, second),
            "passes": min(l.smallest_p for l in levels) > 0.01 / 3}

"""Densities on the unit cube that are fitted to an integrand from their own samples, and integrals with them.

>>> import numpy as np
>>> from glanz.sampling import integrate
>>> found = integrate(lambda x: np.sin(np.pi * x[:, 0] / 2), 1, [(0, 1000), (1, 1000), (2, 10000)])
>>> abs(found.total.mean - 2 / np.pi) < 5 * found.total.standard_error
True
"""

from ._glanz.sampling import (
    AdaptiveDensity,
    AdaptiveIntegral,
    DensitySamples,
    Integral,
    integrate,
    sobol,
)

__all__ = ["AdaptiveDensity", "AdaptiveIntegral", "DensitySamples", "Integral", "integrate", "sobol"]

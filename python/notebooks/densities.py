# %% [markdown]
# # Adaptive densities on one's own integrand
#
# A Monte Carlo integral has less variance if points are drawn where the integrand is large. An adaptive density learns where that is
# from its own samples, from coarse to fine, and the integral stays unbiased.

# %%
import importlib
from typing import Any

import numpy as np

from glanz.sampling import AdaptiveDensity, integrate

plt: Any = importlib.import_module("matplotlib.pyplot")
dblquad: Any = importlib.import_module("scipy.integrate").dblquad

# %% [markdown]
# The integrand: a ring with a bright side. It may be any function of N x D points that returns N values.


# %%
def ring(x: Any) -> Any:
    """A ring of radius 0.3 around the middle of the unit square."""
    dx, dy = x[:, 0] - 0.5, x[:, 1] - 0.5
    return np.exp(-(((np.hypot(dx, dy) - 0.3) / 0.05) ** 2)) * (1.2 + dx / 0.3)


def polar(phi: float, r: float) -> float:
    """The same in polar coordinates, with their area element; beyond r = 0.5 it vanishes up to 1e-7."""
    return r * float(np.exp(-(((r - 0.3) / 0.05) ** 2))) * (1.2 + r * float(np.cos(phi)) / 0.3)


exact = float(dblquad(polar, 0, 0.5, 0, 2 * np.pi)[0])
print(f"the integral is {exact:.6f}")

# %% [markdown]
# ## In passes, with a call

# %%
passes = [(2, 2_000), (3, 4_000), (4, 16_000), (5, 64_000), (5, 100_000)]
found = integrate(ring, 2, passes, basis="spline1", floor=0.1, progress=lambda done, total: None)
uniform = AdaptiveDensity(2).integrate(ring, 100_000)
print(f"{'':12} {'samples':>8} {'integral':>10} {'standard error':>15} {'variance':>10}")
for name, estimate in [("uniform", uniform)] + [
    (f"level {level}", estimate) for (level, _), estimate in zip(passes, found.passes, strict=True)
]:
    print(
        f"{name:12} {estimate.samples:8} {estimate.mean:10.6f} {estimate.standard_error:15.6f} {estimate.primary_variance:10.5f}"
    )
print(f"{'all passes':12} {found.total.samples:8} {found.total.mean:10.6f} {found.total.standard_error:15.6f}")
gain = uniform.primary_variance / found.passes[-1].primary_variance
print(f"the last pass has a variance {gain:.0f} times smaller than uniform samples")
assert gain > 8
assert abs(found.total.mean - exact) < 5 * found.total.standard_error

# %% [markdown]
# ## By hand: draw, record, fit, refine

# %%
density = AdaptiveDensity(2, "spline1", 2, max_level=5)
random = np.random.default_rng(1)
history = [density.copy()]
variances: list[float] = []
for level in (2, 3, 4, 5):
    density.refine(level)
    drawn = density.sample(random.uniform(0, 1, (30_000, 2)))
    values = ring(drawn.points)
    variances.append(float(np.var(values / drawn.pdf)))
    density.record(drawn, values)
    density.fit()
    history.append(density.copy())

# %% [markdown]
# Density and integrand, with some samples of the density.

# %%
grid = (np.arange(256) + 0.5) / 256
at = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
figure, axes = plt.subplots(1, 4, figsize=(15, 3.8), layout="constrained")
panels = [
    ("integrand / integral", ring(at) / exact),
    ("density, level 3", history[2].pdf(at)),
    ("density, level 5", history[4].pdf(at)),
]
top = float(panels[0][1].max())
image = None
for axis, (title, values) in zip(axes, panels, strict=False):
    image = axis.imshow(values.reshape(256, 256), origin="lower", extent=(0, 1, 0, 1), vmin=0, vmax=top)
    axis.set(title=title, xlabel="x", ylabel="y")
if image is not None:
    figure.colorbar(image, ax=axes[2], label="probability per unit square")
some = density.sample(random.uniform(0, 1, (400, 2))).points
axes[2].plot(some[:, 0], some[:, 1], "w.", markersize=1.5)
axes[3].semilogy([2, 3, 4, 5], variances, "o-", label="adaptive")
axes[3].axhline(uniform.primary_variance, color="gray", linestyle="--", label="uniform")
axes[3].set(title="Variance of a sample", xlabel="level", ylabel="variance", xticks=[2, 3, 4, 5])
axes[3].legend()
plt.show()

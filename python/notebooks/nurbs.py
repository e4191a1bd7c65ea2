# %% [markdown]
# # NURBS surfaces
#
# A NURBS surface is evaluated, measured and met by rays, without triangles. Values and derivatives are those of scipy and geomdl; the
# table shows how long each takes.

# %%
import importlib
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from glanz.geometry import Nurbs

plt: Any = importlib.import_module("matplotlib.pyplot")
NdBSpline: Any = importlib.import_module("scipy.interpolate").NdBSpline

# %% [markdown]
# A bicubic surface of 7 x 6 control points with weights.

# %%
random = np.random.default_rng(1)
n, m, degree = 7, 6, 3
x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, m), indexing="ij")
points = np.stack([x, y, random.uniform(-0.2, 0.2, (n, m))], axis=-1)
weights = random.uniform(0.5, 2, (n, m))


def clamped(count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Clamped knots over [0, 1] at equal distances."""
    return np.concatenate([np.zeros(degree), np.linspace(0, 1, count - degree + 1), np.ones(degree)])


knots_u, knots_v = clamped(n), clamped(m)
surface = Nurbs(points, weights, knots_u, knots_v)
print(surface, "of degree", surface.degree, "and area", surface.area())

# %% [markdown]
# ## Agreement and speed
#
# scipy's B-splines are polynomial: the surface is their quotient in homogeneous coordinates. geomdl is written in Python.

# %%
homogeneous = np.concatenate([points * weights[..., None], weights[..., None]], axis=-1)
peer: Any = importlib.import_module("geomdl.NURBS").Surface()
peer.degree_u = peer.degree_v = degree
peer.ctrlpts_size_u, peer.ctrlpts_size_v = n, m
peer.ctrlptsw = homogeneous.reshape(-1, 4).tolist()
peer.knotvector_u, peer.knotvector_v = knots_u.tolist(), knots_v.tolist()
spline: Any = NdBSpline((knots_u, knots_v), homogeneous, degree)


def with_scipy(uv: Any) -> Any:
    """Points and first derivatives, by the rule for quotients."""
    a, by_u, by_v = (spline(uv, nu=order) for order in [(0, 0), (1, 0), (0, 1)])
    point = a[:, :3] / a[:, 3:]
    return np.stack([point] + [(d[:, :3] - d[:, 3:] * point) / a[:, 3:] for d in (by_u, by_v)], axis=1)


def with_geomdl(uv: Any) -> Any:
    """Points and first derivatives."""
    found = np.array([peer.derivatives(u, v, 1) for u, v in uv])
    return np.stack([found[:, 0, 0], found[:, 1, 0], found[:, 0, 1]], axis=1)


def with_glanz(uv: Any) -> Any:
    """Points and first derivatives."""
    found = surface.derivatives(uv[:, 0], uv[:, 1])
    return np.stack([found[:, 0, 0], found[:, 1, 0], found[:, 0, 1]], axis=1)


ways: list[tuple[str, Callable[[Any], Any], int]] = [
    ("glanz", with_glanz, 500_000),
    ("scipy", with_scipy, 100_000),
    ("geomdl", with_geomdl, 1_000),
]
uv = random.uniform(0, 1, (500_000, 2))
expected = with_glanz(uv)
print(f"{'':8} {'points/s':>12} {'largest difference':>20}")
for name, way, count in ways:
    start = time.perf_counter()
    values = way(uv[:count])
    seconds = time.perf_counter() - start
    difference = np.abs(values - expected[:count]).max()
    print(f"{name:8} {count / seconds:12.0f} {difference:20.1e}")
    assert difference < 1e-11

# %% [markdown]
# ## Curvature, rays and nearest points

# %%
grid = np.linspace(0, 1, 200)
u, v = np.meshgrid(grid, grid, indexing="ij")
curvature = surface.curvature(u, v)

side = 400
px, py = np.meshgrid(np.linspace(-0.1, 1.1, side), np.linspace(-0.1, 1.1, side))
origins = np.stack([px, py - 2.0, np.full_like(px, 2.0)], axis=-1).reshape(-1, 3)
directions = np.broadcast_to([0.0, 1.0, -1.0], origins.shape)
start = time.perf_counter()
hits = surface.intersect(origins, directions)
seconds = time.perf_counter() - start
print(f"{hits.hit.sum()} hits of {len(origins)} rays in {1e3 * seconds:.0f} ms; {hits.undecided.sum()} undecided")
light = np.array([0.3, -0.5, 0.8])
shade = np.abs(hits.normal @ (light / np.linalg.norm(light))).reshape(side, side)

query = np.array([0.5, 0.5, 0.6])
near = surface.closest_point(query)
print(f"the surface is {float(near.distance):.6f} m from {query}, at u, v = {near.uv}")

figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
bound = float(np.quantile(np.abs(curvature.gaussian), 0.98))
image = axes[0].imshow(
    curvature.gaussian.T, origin="lower", extent=(0, 1, 0, 1), cmap="RdBu_r", vmin=-bound, vmax=bound
)
figure.colorbar(image, ax=axes[0], label="Gaussian curvature, 1/m²")
axes[0].plot(*near.uv, "k+", markersize=12, label="nearest to the query")
axes[0].set(xlabel="u", ylabel="v", title="Curvature over the parameters")
axes[0].legend()
axes[1].imshow(shade, origin="lower", extent=(-0.1, 1.1, -0.1, 1.1), cmap="gray", vmin=0, vmax=1)
axes[1].set(xlabel="x of the ray, m", ylabel="y + 2 m of the ray, m", title="Normals at the hits of parallel rays")
plt.show()

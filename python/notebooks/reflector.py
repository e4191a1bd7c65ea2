# %% [markdown]
# # A reflector for an even wall
# A small lamp shines at a mirror, which lights a wall behind the lamp. The mirror is a Bézier patch; an optimiser moves its control points until the wall is
# even: until U0, the smallest over the mean illuminance, is at least twice that of the flat mirror. Lengths are metres.
#
# `method="integrate"` computes direct light and light after one reflection without noise, so that the objective has none.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize

from glanz import LuxMap
from glanz.scene import (
    AreaLight,
    BezierPatch,
    BilinearMesh,
    Diffuse,
    Disk,
    Film,
    Mirror,
    PerspectiveCamera,
    SceneDescription,
    Transform,
)

# %% [markdown]
# ## The design
# The wall is the plane y = 0, 3 m x 3 m, the lamp 1.2 m in front of it, the mirror of 1 m x 1 m about 15 cm behind the lamp. The mirror is a biquadratic
# patch, symmetric in x and z: free are the depths of its control points in the middle, at the sides and at the corners. By symmetry a quarter of the wall is enough.

# %%
WALL = 1.5
MIRROR = 0.5


def depths_of(free: ArrayLike) -> NDArray[np.float64]:
    """The y of the nine control points: middle, sides, corners behind 1.35 m."""
    middle, side, corner = np.asarray(free, dtype=np.float64)
    return 1.35 + np.array([[corner, side, corner], [side, middle, side], [corner, side, corner]])


def mirror(free: ArrayLike) -> BezierPatch:
    """The mirror with these depths."""
    x, z = np.meshgrid([-MIRROR, 0.0, MIRROR], [-MIRROR, 0.0, MIRROR])
    return BezierPatch(P=np.stack([x, depths_of(free), z], axis=-1), material=Mirror(Kr=0.95))


LAMP = Disk(
    radius=0.03,
    material=Diffuse(reflectance=0.0),
    light=AreaLight(lumens=1000),
    transform=Transform.translate(0, 1.2, 0) @ Transform.rotate(-90, (1, 0, 0)),
)


def wall(low: float, cells: int, reflectance: float) -> BilinearMesh:
    """The wall from (low, low) on, as a receiver."""
    corners = [(low, 0, low), (WALL, 0, low), (low, 0, WALL), (WALL, 0, WALL)]
    material = Diffuse(reflectance=reflectance)
    return BilinearMesh(P=corners, material=material, receiver="wall", receiverside="back", cells=[cells, cells])


def lit(free: ArrayLike, low: float = 0.0, cells: int = 6, tolerance: float = 0.05) -> LuxMap:
    """The illuminance of the wall, or of its quarter."""
    scene = SceneDescription(shapes=[wall(low, cells, 0.0), LAMP, mirror(free)]).load()
    return scene.illuminate(method="integrate", tolerance=tolerance)["wall"]


# %% [markdown]
# ## Optimisation
# The objective is the relative standard deviation of the illuminance, less U0.

# %%
history: list[float] = []


def unevenness(free: NDArray[np.float64]) -> float:
    """Small where the wall is even."""
    lux_map = lit(free)
    history.append(lux_map.u0)
    return float(lux_map.lux.std() / lux_map.mean) - lux_map.u0


start = np.zeros(3)
first_steps = [start, (0.0, 0.3, 0.0), (0.0, 0.3, 0.15), (-0.15, 0.3, 0.1)]
found = minimize(unevenness, start, method="Nelder-Mead", options={"maxfev": 28, "initial_simplex": first_steps})
best = np.asarray(found.x, dtype=np.float64)

# %% [markdown]
# Both are computed once more, on more cells and more precisely than in the search.

# %%
before, after = lit(start, cells=8, tolerance=0.01), lit(best, cells=8, tolerance=0.01)
print(f"depths (m) {np.round(best, 3)} after {len(history)} designs")
print(f"before: {before}\nafter:  {after}")
assert after.u0 >= 2 * before.u0

# %% [markdown]
# ## The result

# %%
figure, axes = plt.subplots(1, 4, figsize=(16, 3.8), layout="constrained")
largest = max(before.maximum, after.maximum)
shown = None
for axis, lux_map, title in zip(axes, (before, after), ("Flat mirror", "Found mirror"), strict=False):
    # Columns run towards -x on the back of the wall: the cells are sorted by their centres.
    x, _, z = lux_map.positions.T
    quarter = lux_map.lux.ravel()[np.lexsort((x, z))].reshape(lux_map.lux.shape)
    whole = np.block([[quarter[::-1, ::-1], quarter[::-1]], [quarter[:, ::-1], quarter]])
    shown = axis.imshow(whole, origin="lower", extent=(-WALL, WALL, -WALL, WALL), vmin=0, vmax=largest, cmap="inferno")
    axis.set(title=f"{title}: mean {lux_map.mean:.0f} lx, U0 {lux_map.u0:.2f}", xlabel="x (m)", ylabel="z (m)")
figure.colorbar(shown, ax=axes[1], label="illuminance (lx)")  # pyright: ignore[reportUnknownMemberType, reportArgumentType]

t = np.linspace(0, 1, 101)
bernstein = np.array([(1 - t) ** 2, 2 * t * (1 - t), t**2])
for free, label in ((start, "flat"), (best, "found")):
    points = depths_of(free)
    for row, style in ((0.5, "-"), (0.0, "--")):
        weights = np.array([(1 - row) ** 2, 2 * row * (1 - row), row**2])
        axes[2].plot(MIRROR * (2 * t - 1), weights @ points @ bernstein, style, label=f"{label}, {'middle' if row else 'edge'}")
axes[2].set(title="Sections of the mirror", xlabel="x (m)", ylabel="y (m)")
axes[2].legend()
axes[3].plot(range(1, len(history) + 1), history, "o-")
axes[3].set(title="Search", xlabel="design", ylabel="U0")

# %% [markdown]
# The lit wall, seen from the side of the mirror.

# %%
view = SceneDescription(
    camera=PerspectiveCamera(eye=(2.2, 4.2, 1.4), target=(0, 0.5, 0), up=(0, 0, 1), fov=48),
    film=Film(xresolution=320, yresolution=240, iso=2000),
    shapes=[wall(-WALL, 4, 0.6), LAMP, mirror(best)],
)
image = view.load().render(samples=24, integrator="sppm")
image  # pyright: ignore[reportUnusedExpression]

# %%
folder = Path(tempfile.mkdtemp())
figure.savefig(folder / "reflector-plots.png")  # pyright: ignore[reportUnknownMemberType]
image.save(folder / "reflector.png")
print(folder)

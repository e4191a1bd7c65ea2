# %% [markdown]
# # A first picture
# A scene of objects, its picture, and the illuminance on its floor. Lengths are metres; z is up.

# %%
import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import glanz
from glanz.scene import (
    AreaLight,
    CheckerboardTexture,
    Dielectric,
    Diffuse,
    Disk,
    Film,
    InfiniteLight,
    Mirror,
    PerspectiveCamera,
    Plane,
    SceneDescription,
    Sphere,
    Torus,
    Transform,
)

# %% [markdown]
# ## Objects
# Every number is a parameter of the scene language; what is left out has the engine's default.

# %%
tiles = CheckerboardTexture(tex1=(0.7, 0.7, 0.7), tex2=(0.15, 0.2, 0.3), uscale=8, vscale=8)
floor = Plane(x=[-3, 3], y=[-3, 3], material=Diffuse(reflectance=tiles), receiver="floor", cells=[48, 48])
lamp = Disk(radius=0.6, transform=Transform.translate(0, 0, 3), reverse_orientation=True, light=AreaLight(lumens=8000))
design = SceneDescription(
    camera=PerspectiveCamera(eye=(0, -6, 2.6), target=(0, 0, 0.5), up=(0, 0, 1), fov=32),
    film=Film(xresolution=320, yresolution=200),
    lights=[InfiniteLight(L=(0.25, 0.3, 0.4))],
    shapes=[
        floor,
        lamp,
        Sphere(radius=0.6, material=Dielectric(eta=1.5), transform=Transform.translate(-1.3, -0.4, 0.6)),
        Sphere(radius=0.6, material=Mirror(), transform=Transform.translate(1.3, 0.2, 0.6)),
        Torus(
            majorradius=0.5,
            minorradius=0.18,
            material=Diffuse(reflectance=(0.8, 0.25, 0.1)),
            transform=Transform.translate(0, 0.3, 0.18),
        ),
    ],
)
scene = design.load()
print(scene)

# %% [markdown]
# ## Picture
# `Image` shows itself in a notebook; its array is linear light.

# %%
image = scene.render(samples=32, aovs=["Z"], variance=True)
image  # pyright: ignore[reportUnusedExpression]

# %%
error = image.standard_error
assert error is not None
print(f"{image}: mean {image.array.mean():.3f}, mean standard error {error.mean():.4f}, farthest point {image.aovs['Z'].max():.1f} m")

# %% [markdown]
# ## Illuminance
# The floor is a receiver. A parameter study is a loop: the lamp is moved down.

# %%
heights = np.array([3.0, 2.5, 2.0])
maps: list[glanz.LuxMap] = []
for height in heights:
    moved = replace(lamp, transform=Transform.translate(0, 0, float(height)))
    study = replace(design, lights=[], shapes=[floor, moved, *design.shapes[2:]]).load()
    maps.append(study.illuminate(particles=400_000)["floor"])
print([f"{height} m: {lux_map.mean:.0f} lx on average, at most {lux_map.maximum:.0f} lx" for height, lux_map in zip(heights, maps, strict=True)])

# %%
figure, axes = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
axes[0].imshow(np.clip(image.array, 0, 1) ** (1 / 2.2))
axes[0].set(title="32 samples per pixel", xticks=[], yticks=[])
brightest = float(np.quantile(maps[0].lux, 0.98))
shown = axes[1].imshow(maps[0].lux, origin="lower", extent=(-3, 3, -3, 3), vmax=brightest, cmap="inferno")
axes[1].set(title="Floor, lamp at 3 m", xlabel="x (m)", ylabel="y (m)")
figure.colorbar(shown, label="illuminance (lx)", extend="max")  # pyright: ignore[reportUnknownMemberType]

# %% [markdown]
# ## Files

# %%
folder = Path(tempfile.mkdtemp())
image.save(folder / "first.exr")
image.save(folder / "first.png", exposure=0.5)
design.save(folder / "first.pbrt")
figure.savefig(folder / "first-plots.png")  # pyright: ignore[reportUnknownMemberType]
comparison = glanz.compare(folder / "first.exr", image)
assert comparison.max == 0.0
print(sorted(path.name for path in folder.iterdir()), folder)

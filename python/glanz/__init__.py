"""Exact light for exact surfaces: a renderer and light simulator for trimmed NURBS, Bézier patches and quadrics.

`load` reads a scene or model, `loads` a text, `glanz.scene` builds scenes in Python. A `Scene` has three jobs: `Scene.render` gives an
`Image`, `Scene.illuminate` lux maps, `Scene.bake` light maps. `glanz.geometry` has surfaces alone, `glanz.sampling` adaptive densities.
Lengths are metres; light is linear red, green and blue.
"""

from . import geometry as geometry
from . import sampling as sampling
from . import scene as scene
from ._errors import Diagnostic as Diagnostic
from ._errors import GlanzError as GlanzError
from ._errors import GlanzWarning as GlanzWarning
from ._errors import SceneError as SceneError
from ._glanz import Illumination as Illumination
from ._glanz import Image as Image
from ._glanz import LightMaps as LightMaps
from ._glanz import Scene as Scene
from ._glanz import __version__ as __version__
from ._glanz import compare as compare
from ._glanz import merge as merge
from ._glanz import merge_checkpoints as merge_checkpoints
from ._glanz import read_image as read_image
from ._load import load as load
from ._load import loads as loads
from ._progress import Progress as Progress
from ._results import Comparison as Comparison
from ._results import FluxBalance as FluxBalance
from ._results import LightChart as LightChart
from ._results import LuxMap as LuxMap
from ._results import RenderStatistics as RenderStatistics

__all__ = [
    "Comparison",
    "Diagnostic",
    "FluxBalance",
    "GlanzError",
    "GlanzWarning",
    "Illumination",
    "Image",
    "LightChart",
    "LightMaps",
    "LuxMap",
    "Progress",
    "RenderStatistics",
    "Scene",
    "SceneError",
    "__version__",
    "compare",
    "geometry",
    "load",
    "loads",
    "merge",
    "merge_checkpoints",
    "read_image",
    "sampling",
    "scene",
]

"""Exact light for exact surfaces: a renderer and light simulator for trimmed NURBS, Bézier patches and quadrics."""

from ._glanz import __version__ as __version__

__all__ = ["__version__"]

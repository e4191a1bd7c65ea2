"""Reading of scenes and models."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from ._glanz import Scene
from ._glanz import load as _load
from ._glanz import loads as _loads


def load(
    path: str | os.PathLike[str],
    *,
    strict: bool = False,
    edges: bool = False,
    view: str | None = None,
    up: str | None = None,
    background: str | None = None,
    ground: bool | None = None,
    material: str | None = None,
    section: str | None = None,
    limits: Mapping[str, str | float] | None = None,
) -> Scene:
    """Reads a scene file in pbrt's language, or a model, and all files that it names.

    Parameters
    ----------
    path
        A scene (.pbrt), or a model: .step, .igs, .glb, .gltf, .obj, .stl, .ply, .rib. The content decides.
    strict
        Whether parts that have to be repaired or replaced are errors instead of warnings.
    edges
        Whether the edges of CAD models are read, for ``Scene.render(edges=True)``.
    view, up, background, ground, material, section
        Picture of a model, which has no camera and light of its own: ``view`` front, back, left, right, top, bottom or iso; ``up``
        y or z; ``background`` #rrggbb or the name of a colour; ``ground`` whether it stands on one; ``material`` instead of its own,
        such as ``steel`` or ``plastic:#3366cc``; ``section`` a plane that cuts it open, such as ``x=50%``.
    limits
        What reading and preparing the scene may use, for files from others: ``{"memory": "2G", "time": "30s", "tokens": 1e9}``. The names are
        memory, bytes, files, depth, tokens, objects, pixels and time; the defaults allow what fits the machine (docs/scene-format.md).

    Raises
    ------
    SceneError
        With file, line and column of the faults, or of the place where a limit was reached.
    OSError
        If the file cannot be read; FileNotFoundError if it does not exist.
    ValueError
        For an argument without meaning.
    """
    arguments = _arguments(strict, edges, view, up, background, ground, material, section, limits)
    return _load(os.fspath(path), arguments)


def loads(
    text: str,
    *,
    name: str = "scene",
    folder: str | os.PathLike[str] | None = None,
    strict: bool = False,
    limits: Mapping[str, str | float] | None = None,
    origins: Sequence[tuple[int, str]] = (),
) -> Scene:
    """Reads a scene from a text in pbrt's language.

    Parameters
    ----------
    text
        The scene.
    name
        Its name in messages and reports.
    folder
        Folder of the files that it names; without one they are not found.
    strict, limits
        As for `load`.
    origins
        First lines, ascending from 1, and names of the objects that wrote them, for ``SceneError.object``.

    Raises
    ------
    SceneError
        With line and column of the faults.
    """
    arguments = _arguments(strict, False, None, None, None, None, None, None, limits)
    folder = None if folder is None else os.fspath(folder)
    return _loads(text, name, folder, list(origins), arguments)


def _arguments(
    strict: bool,
    edges: bool,
    view: str | None,
    up: str | None,
    background: str | None,
    ground: bool | None,
    material: str | None,
    section: str | None,
    limits: Mapping[str, str | float] | None,
) -> dict[str, object]:
    return {
        "strict": strict,
        "edges": edges,
        "view": view,
        "up": up,
        "background": background,
        "ground": ground,
        "material": material,
        "section": section,
        "limits": {name: str(value) for name, value in (limits or {}).items()},
    }

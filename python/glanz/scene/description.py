"""Scenes that are built in Python."""

from __future__ import annotations

import os
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from .._glanz import Scene
from .._load import loads
from ._statement import Writer, numbers, parameter, parameters_of, quoted
from .light import LightSource
from .material import Material, Mix
from .medium import Medium
from .shape import Group, Instance, Shape
from .trim import Trim, TrimLoops, trim_parameters
from .view import Camera, Film, Filter, Integrator, PerspectiveCamera, Sampler


@dataclass(frozen=True, eq=False, kw_only=True)
class SceneDescription:
    """A scene of objects.

    The engine checks them: `load` gives a `Scene`, or a `SceneError` that names the object at fault. Objects may be used several times, and
    ``dataclasses.replace`` makes variants.
    """

    camera: Camera = field(default_factory=PerspectiveCamera)
    film: Film = field(default_factory=Film)
    filter: Filter | None = None
    sampler: Sampler = field(default_factory=Sampler)
    integrator: Integrator = field(default_factory=Integrator)
    lights: Sequence[LightSource] = ()
    shapes: Sequence[Shape | Instance] = ()

    def to_pbrt(self) -> str:
        """The scene in the scene language, which ``glanz render`` takes.

        Raises
        ------
        TypeError, ValueError
            For values that the language cannot express; the message names the object.
        """
        return _written(self)[0]

    def load(self, *, name: str = "scene", folder: str | os.PathLike[str] | None = None, strict: bool = False) -> Scene:
        """The scene for rendering and illuminating.

        Parameters
        ----------
        name
            Its name in messages and reports.
        folder
            Folder of the files that it names.
        strict
            Whether parts that have to be repaired or replaced are errors.

        Raises
        ------
        SceneError
            For what is not a scene; ``object`` names the object.
        TypeError, ValueError
            As `to_pbrt`.
        """
        text, origins = _written(self)
        return loads(text, name=name, folder=folder, strict=strict, origins=origins)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene as a scene file (.pbrt); files that it names are those beside it."""
        Path(path).write_text(self.to_pbrt(), encoding="utf-8")


def _written(scene: SceneDescription) -> tuple[str, list[tuple[int, str]]]:
    """The text, with first lines and names of the objects."""
    writer = Writer()
    _write_view(writer, scene)
    writer.origin("scene")
    writer.lines.append("WorldBegin")
    for number, light in enumerate(scene.lights):
        name = _name(f"lights[{number}]", light)
        writer.origin(name)
        with _place(name):
            _write_light(writer, light)
    for number, shape in enumerate(scene.shapes):
        _write_placed(writer, f"shapes[{number}]", shape)
    return "\n".join(writer.lines) + "\n", writer.origins


class _PlacedError(Exception):
    """Marks messages that name their object already."""


@contextmanager
def _place(name: str) -> Generator[None]:
    """Names the object at fault in exceptions about its values."""
    try:
        yield
    except (TypeError, ValueError) as error:
        if isinstance(error.__cause__, _PlacedError):
            raise
        raise type(error)(f"{name}: {error}") from _PlacedError(name)


def _name(path: str, value: object) -> str:
    return f"{path}: {type(value).__name__}"


def _write_view(writer: Writer, scene: SceneDescription) -> None:
    camera = scene.camera
    name = _name("camera", camera)
    writer.origin(name)
    with _place(name):
        if camera.medium is not None:
            # Before the camera's transformation: a grid is in the frame of its directive.
            medium = _medium(writer, camera.medium)
            writer.lines.append(f"MediumInterface {medium}")
        if camera.transform is not None:
            writer.lines.append(camera.transform.statement("Transform"))
        else:
            if camera.MIRROR:
                writer.lines.append("Scale -1 1 1")
            writer.lines.append(f"LookAt {numbers([camera.eye, camera.target, camera.up])}")
        writer.lines.append(_statement(writer, "Camera", camera.KIND, camera))
    filters = [] if scene.filter is None else [("filter", "PixelFilter", scene.filter.kind, scene.filter)]
    for path, directive, kind, value in (
        ("film", "Film", scene.film.KIND, scene.film),
        *filters,
        ("sampler", "Sampler", scene.sampler.kind, scene.sampler),
        ("integrator", "Integrator", scene.integrator.kind, scene.integrator),
    ):
        name = _name(path, value)
        writer.origin(name)
        with _place(name):
            writer.lines.append(_statement(writer, directive, kind, value))

def _statement(writer: Writer, directive: str, kind: str, value: object) -> str:
    return f"{directive} {quoted(kind)}{''.join(parameters_of(writer, value))}"


def _write_light(writer: Writer, light: LightSource) -> None:
    line = _statement(writer, "LightSource", light.KIND, light)
    if light.transform is None:
        writer.lines.append(line)
    else:
        writer.lines += ["AttributeBegin", light.transform.statement(), line, "AttributeEnd"]


def _medium(writer: Writer, medium: Medium | None) -> str:
    """The name of a medium in quotation marks, which is defined if it is new."""
    if medium is None:
        return '""'
    name, is_new = writer.name(medium, "medium")
    if is_new:
        parameters = "".join(parameters_of(writer, medium))
        writer.lines.append(f'MakeNamedMedium {quoted(name)} "string type" {quoted(medium.KIND)}{parameters}')
    return quoted(name)


def _material(writer: Writer, material: Material) -> str:
    """The name of a material in quotation marks, which is defined if it is new."""
    name, is_new = writer.name(material, "material")
    if is_new:
        parts = ""
        if isinstance(material, Mix):
            first, second = _material(writer, material.first), _material(writer, material.second)
            parts = f' "string materials" [ {first} {second} ]'
        parameters = "".join(parameters_of(writer, material))
        line = f'MakeNamedMaterial {quoted(name)} "string type" {quoted(material.KIND)}{parts}{parameters}'
        writer.lines.append(line)
    return quoted(name)


def _write_placed(writer: Writer, path: str, placed: Shape | Instance) -> None:
    name = _name(path, placed)
    if isinstance(placed, Instance):
        group = _group(writer, f"{path}.group", placed.group)
        writer.origin(name)
        with _place(name):
            place = placed.transform.statement()
        writer.lines += ["AttributeBegin", place, f"ObjectInstance {group}", "AttributeEnd"]
    else:
        writer.origin(name)
        with _place(name):
            _write_shape(writer, name, path, placed)


def _group(writer: Writer, path: str, group: Group) -> str:
    """The name of a group in quotation marks, which is defined if it is new, after the groups that it contains."""
    name, is_new = writer.name(group, "group")
    if is_new:
        parts = [(f"{path}.shapes[{number}]", part) for number, part in enumerate(group.shapes)]
        for own, part in parts:
            if isinstance(part, Instance):
                _group(writer, f"{own}.group", part.group)
        writer.origin(_name(path, group))
        writer.lines.append(f"ObjectBegin {quoted(name)}")
        for own, part in parts:
            _write_placed(writer, own, part)
        writer.origin(_name(path, group))
        writer.lines.append("ObjectEnd")
    return quoted(name)


def _write_shape(writer: Writer, name: str, path: str, shape: Shape) -> None:
    writer.lines.append("AttributeBegin")
    if shape.inside is not None or shape.outside is not None:
        inside, outside = _medium(writer, shape.inside), _medium(writer, shape.outside)
        writer.lines.append(f"MediumInterface {inside} {outside}")
    if shape.material is not None:
        writer.origin(_name(f"{path}.material", shape.material))
        writer.lines.append(f"NamedMaterial {_material(writer, shape.material)}")
    if shape.light is not None:
        writer.origin(_name(f"{path}.light", shape.light))
        writer.lines.append(_statement(writer, "AreaLightSource", shape.light.KIND, shape.light))
    writer.origin(name)
    # Before the shape's transformation: a texture is in the frame of its directive.
    line = _statement(writer, "Shape", shape.KIND, shape)
    if shape.transform is not None:
        writer.lines.append(shape.transform.statement())
    if shape.reverse_orientation:
        writer.lines.append("ReverseOrientation")
    # The language has one set of loops per shape.
    loops = [loop for trim in shape.trims if isinstance(trim, TrimLoops) for loop in trim.loops]
    trims: list[Trim] = [trim for trim in shape.trims if not isinstance(trim, TrimLoops)]
    if loops:
        trims.append(TrimLoops(loops))
    further = [shape.derived(), *map(trim_parameters, trims)]
    for parameters in further:
        for own, (kind, value) in parameters.items():
            line += parameter(writer, kind, own, value, "spectrum")
    writer.lines += [line, "AttributeEnd"]

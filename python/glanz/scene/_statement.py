"""Statements of the scene language, written from dataclasses.

A field is a parameter: its annotation has the type of the scene language, its name is that of the parameter, with ``_`` at the end where Python has the
name itself, and with ``_`` for ``.``. Fields that are None are left out, so that defaults are those of the engine.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from .texture import Texture


@dataclass(frozen=True)
class Blackbody:
    """Light of a black body. ``temperature``: K; ``scale``: a factor, where the light has none of its own."""

    temperature: float
    scale: float | None = None


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Values at wavelengths, linear between them. ``wavelengths``: nm, N; ``values``: N."""

    wavelengths: ArrayLike
    values: ArrayLike


@dataclass(frozen=True)
class Named:
    """A spectrum by its name, such as ``metal-Al-eta`` or ``stdillum-D65``, or its file."""

    name: str


#: Red, green and blue; one number for grey; a black body; a spectrum or its name.
Color: TypeAlias = Union[float, tuple[float, float, float], Sequence[float], Blackbody, Spectrum, Named]

Float: TypeAlias = Annotated[float, "float"]
Integer: TypeAlias = Annotated[int, "integer"]
Bool: TypeAlias = Annotated[bool, "bool"]
String: TypeAlias = Annotated[str, "string"]
Path: TypeAlias = Annotated[Union[str, "os.PathLike[str]"], "path"]
Floats: TypeAlias = Annotated[ArrayLike, "float"]
Integers: TypeAlias = Annotated[ArrayLike, "integer"]
Point: TypeAlias = Annotated[Union[tuple[float, float, float], ArrayLike], "point3"]
Points: TypeAlias = Annotated[ArrayLike, "point3"]
Points2: TypeAlias = Annotated[ArrayLike, "point2"]
Vector: TypeAlias = Annotated[Union[tuple[float, float, float], ArrayLike], "vector3"]
Normals: TypeAlias = Annotated[ArrayLike, "normal"]
Light: TypeAlias = Annotated[Color, "color"]
Reflectance: TypeAlias = Annotated[Union[Color, "Texture"], "color"]
Value: TypeAlias = Annotated[Union[float, "Texture"], "value"]


def numbers(values: ArrayLike, integer: bool = False) -> str:
    """The values in order with all their digits.

    Raises
    ------
    TypeError, ValueError
        For what is not an array of numbers, or has numbers that are not finite, or not whole where they must be.
    """
    try:
        array = np.asarray(values, dtype=np.float64).ravel()
    except (TypeError, ValueError) as error:
        raise type(error)(f"{error}: these are not numbers") from None
    if not np.isfinite(array).all():
        raise ValueError("a number is infinite or not a number")
    if not integer:
        return repr(array.tolist())[1:-1].replace(",", "")
    if (array != np.rint(array)).any():
        raise ValueError("a number is not whole")
    if (np.abs(array) >= 2**31).any():
        raise ValueError("a whole number does not fit into 32 bits")
    return " ".join(map(str, array.astype(np.int64).tolist()))


def quoted(text: str) -> str:
    """The text in quotation marks.

    Raises
    ------
    ValueError
        If the scene language cannot hold it.
    """
    if not isinstance(text, str):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"{text!r} is not a text")
    if not text.isprintable():
        raise ValueError(f"{text!r} has characters that a name or path in a scene cannot have")
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


class Writer:
    """Lines of a scene, with the objects that wrote them and the textures that were defined."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.origins: list[tuple[int, str]] = []
        self.names: dict[tuple[int, str], str] = {}
        # Objects are known by their identity, which lasts as long as they do.
        self._alive: list[object] = []

    def origin(self, name: str) -> None:
        """Lines from here on are of the object ``name``."""
        line = len(self.lines) + 1
        if self.origins and self.origins[-1][0] == line:
            self.origins.pop()
        self.origins.append((line, name))

    def name(self, value: object, kind: str) -> tuple[str, bool]:
        """The name of an object, and whether it is new."""
        key = (id(value), kind)
        is_new = key not in self.names
        if is_new:
            self._alive.append(value)
            self.names[key] = f"{kind} {len(self.names) + 1}"
        return self.names[key], is_new

    def texture(self, value: Texture, kind: str) -> str:
        """The name of a texture, which is defined if it is new; ``kind``: spectrum or float."""
        name, is_new = self.name(value, kind)
        if is_new:
            parameters = "".join(parameters_of(self, value, kind))
            line = f"Texture {quoted(name)} {quoted(kind)} {quoted(value.KIND)}{parameters}"
            if value.transform is None:
                self.lines.append(line)
            else:
                self.lines += ["TransformBegin", value.transform.statement(), line, "TransformEnd"]
        return name


def color(writer: Writer, name: str, value: Any) -> str:
    """A parameter that is a colour."""
    if isinstance(value, (bool, str)):
        raise TypeError(f"{name} is {value!r}; a colour is a number, three numbers, Blackbody, Spectrum or Named")
    if hasattr(value, "KIND"):
        return f' "texture {name}" {quoted(writer.texture(value, "spectrum"))}'
    if isinstance(value, Blackbody):
        scale = [] if value.scale is None else [value.scale]
        return f' "blackbody {name}" [ {numbers([value.temperature, *scale])} ]'
    if isinstance(value, Named):
        return f' "spectrum {name}" {quoted(value.name)}'
    if isinstance(value, Spectrum):
        pairs = np.broadcast_arrays(np.ravel(value.wavelengths), np.ravel(value.values))
        return f' "spectrum {name}" [ {numbers(np.column_stack(pairs))} ]'
    if np.ndim(value) == 0:
        value = (value, value, value)
    return f' "rgb {name}" [ {numbers(value)} ]'


def parameter(writer: Writer, kind: str, name: str, value: Any, texture_kind: str) -> str:
    """A parameter of a type of the scene language."""
    try:
        if kind == "color" or (kind == "texture" and texture_kind == "spectrum"):
            return color(writer, name, value)
        if kind in ("value", "texture"):
            if hasattr(value, "KIND"):
                return f' "texture {name}" {quoted(writer.texture(value, "float"))}'
            kind = "float"
        if kind == "bool":
            return f' "bool {name}" {"true" if value else "false"}'
        if kind == "path":
            return f' "string {name}" {quoted(cast(str, os.fspath(value)))}'
        if kind == "string":
            return f' "string {name}" {quoted(value)}'
        return f' "{kind} {name}" [ {numbers(value, kind == "integer")} ]'
    except (TypeError, ValueError) as error:
        raise type(error)(f"{name}: {error}") from None


def _types(annotation: Any) -> Iterator[str]:
    if get_origin(annotation) is Annotated:
        yield get_args(annotation)[1]
    else:
        for part in get_args(annotation):
            yield from _types(part)


@cache
def _fields(cls: type[Any]) -> list[tuple[str, str, str]]:
    """Fields that are parameters: name of the field, type and name of the parameter."""
    hints = get_type_hints(cls, localns=_hint_names(), include_extras=True)
    found: list[tuple[str, str, str]] = []
    for field in dataclasses.fields(cls):
        kinds = list(_types(hints[field.name]))
        if kinds:
            dotted: Mapping[str, str] = getattr(cls, "NAMES", {})
            found.append((field.name, kinds[0], dotted.get(field.name, field.name.rstrip("_"))))
    return found


def _hint_names() -> dict[str, Any]:
    from .texture import Texture

    return {"Texture": Texture, "os": os}


def parameters_of(writer: Writer, value: Any, texture_kind: str = "spectrum") -> list[str]:
    """The parameters of an object that are not None."""
    texts: list[str] = []
    for field, kind, name in _fields(cast(type[Any], type(value))):
        own = getattr(value, field)
        if own is not None:
            texts.append(parameter(writer, kind, name, own, texture_kind))
    return texts

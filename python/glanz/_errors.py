"""Exceptions and warnings of the package."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Diagnostic:
    """One message about a scene, with its place.

    Attributes
    ----------
    severity : ``"error"`` or ``"warning"``.
    file : name of the file or text; empty if the place is not known.
    line, column : from 1, columns in characters; None if the place is not known.
    message : the fault, one sentence.
    help : the remedy, if there is a short one.
    text : everything with the line at fault, as the command line prints it.
    object : for a scene built in Python, the object that wrote the line, such as ``shapes[2]: Sphere``.
    """

    severity: str
    file: str
    line: int | None
    column: int | None
    message: str
    help: str | None
    text: str
    object: str | None

    def __str__(self) -> str:
        text = self.text.rstrip()
        return text if self.object is None else f"{text}\n  object: {self.object}"


class GlanzError(RuntimeError):
    """Failure of a job or of a file's content; base class of `SceneError`."""


class SceneError(GlanzError):
    """A scene that was refused.

    Attributes
    ----------
    diagnostics : all errors and warnings, in order.
    file, line, column, object : place of the first error, see `Diagnostic`.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        errors = [one for one in self.diagnostics if one.severity == "error"] or self.diagnostics
        first = errors[0] if errors else None
        self.file = first.file if first else ""
        self.line = first.line if first else None
        self.column = first.column if first else None
        self.object = first.object if first else None
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return "\n".join(str(one) for one in self.diagnostics)


class GlanzWarning(UserWarning):
    """Something that was repaired, left out or not decided."""

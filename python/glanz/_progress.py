"""Progress of jobs."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

#: Steps of a progress bar.
_STEPS = 1000


@dataclass(frozen=True)
class Progress:
    """Progress of a job, about twice a second.

    Attributes
    ----------
    phase : name of the phase.
    step, steps : number of the phase, from 1, and the number of phases.
    fraction : share of the phase that is done, 0 to 1.
    elapsed : seconds since the phase began.
    remaining : estimated seconds until the phase ends; None while not known.
    error : largest relative standard error so far, if the job estimates it.
    done, wanted, unit : a count of completed work and its goal, if the phase counts anything.
    """

    phase: str
    step: int
    steps: int
    fraction: float
    elapsed: float
    remaining: float | None
    error: float | None
    done: int | None
    wanted: int | None
    unit: str

    def __str__(self) -> str:
        parts = [f"{self.phase} {100 * self.fraction:.0f} %"]
        if self.error is not None:
            parts.append(f"error {100 * self.error:.2g} %")
        if self.remaining is not None:
            parts.append(f"{self.remaining:.0f} s left")
        return ", ".join(parts)


class _TextProgress:
    """Progress as a line on the standard error."""

    def __init__(self) -> None:
        self._width = 0

    def __call__(self, progress: Progress) -> None:
        text = str(progress)
        print(f"\r{text:<{self._width}}", end="", file=sys.stderr, flush=True)
        self._width = len(text)

    def close(self) -> None:
        """Ends the line."""
        if self._width:
            print(file=sys.stderr)


class _BarProgress:
    """Progress as a bar of tqdm, one for each phase."""

    def __init__(self, tqdm: Callable[..., Any]) -> None:
        self._tqdm = tqdm
        self._bar: Any = None
        self._step = 0

    def __call__(self, progress: Progress) -> None:
        if self._bar is None or progress.step != self._step:
            self.close()
            layout = "{desc}: {percentage:3.0f} %|{bar}| {elapsed}<{remaining}{postfix}"
            self._bar = self._tqdm(total=_STEPS, desc=progress.phase, bar_format=layout)
            self._step = progress.step
        if progress.error is not None:
            self._bar.set_postfix_str(f"error {100 * progress.error:.2g} %", refresh=False)
        self._bar.update(round(progress.fraction * _STEPS) - self._bar.n)

    def close(self) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def _no_close() -> None:
    pass


def reporter(progress: object) -> tuple[Callable[[Progress], object], Callable[[], None]]:
    """The function that receives the progress, and the one that ends its display."""
    if progress is True:
        try:
            shown = _BarProgress(importlib.import_module("tqdm.auto").tqdm)
        except ImportError:
            shown = _TextProgress()
        return shown, shown.close
    if callable(progress):
        return progress, _no_close
    raise TypeError(f"progress is {progress!r}; it must be True, False, None or a function of one argument")

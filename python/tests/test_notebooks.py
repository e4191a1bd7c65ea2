"""The notebooks run from beginning to end."""

import runpy
from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"


@pytest.mark.parametrize("name", ["densities", "first_picture", "nurbs", "reflector"])
def test_notebook_runs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = runpy.run_path(str(NOTEBOOKS / f"{name}.py"))
    if name == "reflector":
        assert names["after"].u0 >= 2 * names["before"].u0

"""The package as a whole."""

import ast
import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import glanz


def test_version_is_that_of_the_workspace() -> None:
    manifest = (Path(__file__).resolve().parents[2] / "Cargo.toml").read_text(encoding="utf-8")
    found = re.search(r'^version = "(.+)"$', manifest, re.MULTILINE)
    assert found is not None and glanz.__version__ == found[1]


def test_modules_are_attributes_of_the_package() -> None:
    assert glanz.geometry.Nurbs and glanz.sampling.AdaptiveDensity and glanz.scene.Sphere


def test_native_module_has_the_signatures_and_docstrings_of_its_stub() -> None:
    native = importlib.import_module("glanz._glanz")
    stub = ast.parse((Path(glanz.__file__).parent / "_glanz" / "__init__.pyi").read_text(encoding="utf-8"))
    members: list[tuple[Any, ast.stmt]] = [(native, node) for node in stub.body]
    for node in stub.body:
        if isinstance(node, ast.ClassDef):
            members += [(getattr(native, node.name), member) for member in node.body]
    compared = 0
    for owner, node in members:
        if not isinstance(node, (ast.FunctionDef, ast.ClassDef)) or node.name.startswith("__"):
            continue
        member, stated = getattr(owner, node.name), ast.get_docstring(node)
        if stated is not None:
            found = inspect.getdoc(member)
            # Those of jobs end after the first paragraph.
            assert found and stated.startswith(found), node.name
            compared += 1
        if isinstance(node, ast.FunctionDef) and callable(member):
            arguments = node.args
            names = [argument.arg for argument in (*arguments.args, *arguments.kwonlyargs) if argument.arg != "self"]
            defaults = [ast.literal_eval(value) for value in (*arguments.defaults, *arguments.kw_defaults) if value is not None]
            parameters = [parameter for parameter in inspect.signature(member).parameters.values() if parameter.name != "self"]
            assert [parameter.name for parameter in parameters] == names, node.name
            assert [parameter.default for parameter in parameters if parameter.default is not parameter.empty] == defaults, node.name
    assert compared > 40

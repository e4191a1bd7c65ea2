"""Arguments without meaning: results or documented exceptions, never a crash."""

import math
import os
import random
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import glanz
from glanz import sampling
from glanz.scene import BezierPatch, Box, Diffuse, Disk, Film, Nurbs, PerspectiveCamera, PointLight, SceneDescription, Sphere, TriangleMesh

#: Number of calls; GLANZ_FUZZ_CALLS sets another.
CALLS = int(os.environ.get("GLANZ_FUZZ_CALLS", "100000"))

#: MemoryError for more numbers than fit; ZeroDivisionError is that of an integrand.
DOCUMENTED = (glanz.GlanzError, ValueError, TypeError, OSError, MemoryError, ZeroDivisionError)

SCENE = SceneDescription(
    film=Film(xresolution=2, yresolution=2),
    lights=[PointLight(I=1)],
    shapes=[Disk(height=1, receiver="disk", cells=[1, 1])],
).load()

VALUES: list[Any] = [
    None, True, False, 0, 1, 2, 3, -1, 2**31, 2**32, 2**64, -(2**70), 0.0, 0.5, -0.0, 1e-300, 1e300, math.nan, math.inf, -math.inf,
    "", "path", "trace", "all", "K/N", "1/2", "3/2", "x" * 300, "a\0b", "\ud800", b"bytes", (), (1, 1), (2, 1), (-1, 3), (0, 1), (1, 2, 3), [1.0, math.nan, 2.0],
    [[0, 0, 0]], {}, {"a": 1}, object(), np.zeros((0, 3)), np.zeros((2, 2)), np.full((2, 2, 3), np.nan), np.ones((2, 2, 3), np.float32)[::-1, ::-1],
    np.ones((3, 3), np.uint8), np.ones((2, 2, 3), complex), np.array(["a"]), Path("missing/file.exr"), range(3),
]  # fmt: skip

#: Values that often have a meaning.
USUAL: list[Any] = [None, 1, 2, 0.5, (1, 1, 1), np.ones((2, 2, 3)), np.zeros((4, 4, 3), np.uint8), [0, 0, 1, 1], [0, 1, 2], np.eye(3)]

RENDER = [
    "size", "integrator", "sampler", "seed", "noise", "sample_range", "part", "time_limit", "light_sampling", "spectral", "branching", "guide",
    "guide_input", "light_input", "aovs", "variance", "edges", "threads", "checkpoint", "resume", "progress", "unknown",
]  # fmt: skip
ILLUMINATE = ["method", "time_limit", "error", "tolerance", "room", "cells", "texel", "far_field", "resolution", "ray_file", "title", "seed", "max_depth", "part", "threads", "progress"]
BAKE = ["density", "method", "interpolation", "threads", "checkpoint", "resume", "progress"]
#: Values that would only take long, or files: not for these.
LONG = {"noise", "time_limit", "branching", "density", "error", "max_depth", "texel", "cells", "size", "tolerance", "threads"}


def chosen(random_: random.Random, names: list[str]) -> dict[str, Any]:
    """Some arguments with random values."""
    arguments: dict[str, Any] = {}
    for name in random_.sample(names, random_.randint(1, 3)):
        value = random_.choice(VALUES)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if name in LONG and is_number and value not in (0, -1, -(2**70)) and not (isinstance(value, float) and not math.isfinite(value)):
            value = 1
        arguments[name] = value
    if isinstance(arguments.get("checkpoint"), (str, Path)):
        arguments["checkpoint"] = "missing/state"
    if any(isinstance(arguments.get(name), int) and arguments[name] == 1 for name in ("noise", "time_limit")):
        arguments.pop("noise", None)
        arguments.pop("time_limit", None)
    return arguments


def value_of(random_: random.Random) -> Any:
    """Any value, or a usual one."""
    return random_.choice(random_.choice([USUAL, USUAL, VALUES]))


def shape(random_: random.Random) -> Any:
    """A shape with random values."""

    def value() -> Any:
        return value_of(random_)

    kinds: list[Any] = [
        lambda: Sphere(radius=value(), zmin=value()),
        lambda: Box(min=value(), max=value()),
        lambda: TriangleMesh(P=value(), indices=value()),
        lambda: BezierPatch(P=value(), weights=value()),
        lambda: Nurbs(P=np.zeros((2, 2, 3)), uknots=value(), vknots=value()),
        lambda: Disk(material=Diffuse(reflectance=value()), receiver=value(), cells=value()),
    ]
    return random_.choice(kinds)()


#: Numbers of samples and seeds.
COUNTS: list[Any] = [1, 2, 7, 64, 0, -1, 2**32, 2**64, None, 1.5, "x"]

#: Integrands, some of which are none.
INTEGRANDS: list[Callable[[Any], Any] | int | None] = [
    lambda x: x[:, 0],
    lambda x: 0 * x[:, 0] + math.nan,
    lambda x: -x[:, 0],
    lambda x: x,
    lambda x: 1,
    lambda x: 1 // 0,
    lambda x: "x",
    lambda x: np.full(len(x), 1e300),
    None,
    1,
]  # fmt: skip


def density_call(random_: random.Random) -> Callable[[], object]:
    """A random call of the adaptive densities."""
    choice: Any = random_.choice

    module: Any = sampling

    def count() -> Any:
        return choice(COUNTS)

    def levels() -> Any:
        return choice([0, 1, 2, [1, 0], (2, 2, 2), -1, 17, 2**40, None, "x", [0.5], []])

    def points() -> Any:
        return choice([np.linspace(0, 0.9, 6).reshape(-1, choice([1, 2, 3, 6])), value_of(random_)])

    def pdf() -> Any:
        return choice([np.ones(6), np.zeros(3), np.full(2, math.nan), -np.ones(1), value_of(random_)])

    if random_.random() < 0.1:
        return lambda: module.sobol(count(), choice([1, 2, 5, 64, 65, 0, "x"]), count(), count())
    if random_.random() < 0.2:
        passes: Any = choice([[(levels(), count())], [(0, 16), (levels(), 16)], [], None, [1], [(0,)]])
        return lambda: module.integrate(choice(INTEGRANDS), choice([1, 2, 3, 4, 5]), passes, basis=choice(["haar", "spline1", "x"]))

    def work() -> object:
        basis = choice([None, "haar", "spline1", "spline7", ["haar", "spline2"], "x", 1])
        density = module.AdaptiveDensity(
            choice([1, 1, 2, 2, 3, 4, 0, None]), basis, choice([None, levels()]), max_level=choice([0, 2, 4, 99]), method=choice(["own", "own-constant", "all"])
        )
        uses: list[Callable[[], Any]] = [
            lambda: density.integrate(choice(INTEGRANDS), count(), repetitions=choice([1, 2, 0]), pattern=choice(["independent", "stratified", "sobol", "x"])),
            lambda: density.fit(choice([0, 0.1, 1, -1, math.nan, 1e300]), choice(["samples", "variance", "x"])),
            lambda: density.refine(levels()),
            lambda: density.sample(points()),
            lambda: density.pdf(points()),
            lambda: density.record(module.DensitySamples(points(), pdf(), choice([None, np.arange(6), pdf()])), pdf()),
            lambda: density.record(density.sample(np.full((6, density.dimension), 0.5)), pdf()),
            density.copy,
            lambda: repr(density) + str(density.coefficients),
        ]
        first, second, third = random_.choices(uses, k=3)
        for use in (first, second):
            # What comes after an exception must work, too.
            try:
                use()
            except DOCUMENTED:
                pass
        return third()

    return work


def call(random_: random.Random) -> Callable[[], object]:
    """One random call, with its arguments."""

    def value() -> Any:
        return value_of(random_)

    kind = random_.random()
    if kind < 0.02:
        arguments: dict[str, Any] = {"samples": 1, "threads": 1}
        arguments |= chosen(random_, RENDER)
        return lambda: SCENE.render(**arguments)
    if kind < 0.025:
        arguments: dict[str, Any] = {"particles": 10, "cells": 1, "threads": 1}
        arguments |= chosen(random_, ILLUMINATE)
        return lambda: SCENE.illuminate(**arguments)
    if kind < 0.03:
        arguments: dict[str, Any] = {"density": 1, "rays": 16, "threads": 1}
        arguments |= chosen(random_, BAKE)
        return lambda: SCENE.bake(**arguments)
    if kind < 0.15:
        return density_call(random_)
    a, b, c, d = value(), value(), value(), value()
    if kind < 0.3:
        return lambda: SceneDescription(shapes=[shape(random_)], camera=PerspectiveCamera(eye=a, fov=b)).load().bounds()
    if kind < 0.5:
        return lambda: SceneDescription(film=Film(xresolution=a, yresolution=2), shapes=[shape(random_)]).load()
    if kind < 0.6:
        words = ["WorldBegin", "Shape", '"sphere"', '"float radius"', "[", "]", "1", "-1", "nan", '"', "\n", "Material", '"diffuse"', "\0", "é"]
        text = " ".join(random_.choices(words, k=random_.randint(0, 12)))
        return lambda: glanz.loads(text)
    if kind < 0.7:
        uses: list[Callable[[glanz.Image], object]] = [
            lambda image: image.array,
            lambda image: image.aovs,
            lambda image: image.to_png(),
            repr,
            np.asarray,
            lambda image: image.save_checkpoint(b),
            lambda image: image.save_guide(b),
        ]
        use = random_.choice(uses)
        return lambda: use(glanz.Image(a))
    if kind < 0.8:
        return lambda: glanz.compare(a, b)
    if kind < 0.83:
        return lambda: glanz.merge(a)
    if kind < 0.85:
        return lambda: glanz.merge_checkpoints(a, "missing/whole")
    if kind < 0.9:
        return lambda: glanz.read_image(a)
    if kind < 0.95:
        return lambda: glanz.load(a)
    path = random_.choice(["missing/a.exr", "a.tiff", b])
    return lambda: glanz.Image(np.ones((2, 2))).save(path, exposure=c, tone=d)


def test_random_calls_give_results_or_documented_exceptions(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    random_ = random.Random(20)
    outcomes = {"results": 0, "exceptions": 0}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(CALLS):
            work = call(random_)
            try:
                work()
                outcomes["results"] += 1
            except DOCUMENTED:
                outcomes["exceptions"] += 1
    print(outcomes)
    # Neither is rare.
    assert min(outcomes.values()) > CALLS // 100

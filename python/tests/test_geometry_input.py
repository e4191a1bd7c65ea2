"""Bad input: a documented exception, or the right result."""

import math
import os
import signal
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from surfaces import hills, net, nurbs_sphere, rays

from glanz import geometry as g

POINTS, WEIGHTS, KNOTS_U, KNOTS_V = net(2)


def trimmed() -> g.Nurbs:
    return g.Nurbs(POINTS, WEIGHTS, KNOTS_U, KNOTS_V, trims=[[(0.1, 0.1), (0.9, 0.1), (0.5, 0.9)]])


def with_value(array: Any, value: float) -> Any:
    changed = np.array(array)
    changed.flat[changed.size // 2] = value
    return changed


@pytest.mark.parametrize(
    ("error", "message", "call"),
    [
        (ValueError, "control_points has shape", lambda: g.Nurbs(POINTS[..., :2], None, KNOTS_U, KNOTS_V)),
        (ValueError, "control_points has shape", lambda: g.Nurbs(POINTS[0], None, KNOTS_U, KNOTS_V)),
        (ValueError, "weights has shape", lambda: g.Nurbs(POINTS, WEIGHTS[1:], KNOTS_U, KNOTS_V)),
        (ValueError, "knots_u has", lambda: g.Nurbs(POINTS, WEIGHTS, KNOTS_U[:3], KNOTS_V)),
        (ValueError, "less than", lambda: g.Nurbs(POINTS, WEIGHTS, KNOTS_U[::-1], KNOTS_V)),
        (ValueError, "finite", lambda: g.Nurbs(with_value(POINTS, math.nan), WEIGHTS, KNOTS_U, KNOTS_V)),
        (ValueError, "finite", lambda: g.Nurbs(POINTS, WEIGHTS, KNOTS_U, with_value(KNOTS_V, math.inf))),
        (ValueError, "weight is 0", lambda: g.Nurbs(POINTS, with_value(WEIGHTS, 0), KNOTS_U, KNOTS_V)),
        (ValueError, "weight is -1", lambda: g.Nurbs(POINTS, with_value(WEIGHTS, -1), KNOTS_U, KNOTS_V)),
        (ValueError, None, lambda: g.Nurbs(np.zeros((0, 0, 3)), None, [], [])),
        (ValueError, None, lambda: g.BezierPatch(np.zeros((1, 1, 3)))),
        (ValueError, "25", lambda: g.BezierPatch(np.random.default_rng(1).uniform(0, 1, (40, 40, 3)))),
        (ValueError, "points", lambda: g.BezierTriangle(np.zeros((4, 3)))),
        (ValueError, None, lambda: g.BezierTriangle(np.zeros((0, 3)))),
        (ValueError, "loops", lambda: g.Nurbs(POINTS, None, KNOTS_U, KNOTS_V, trims=[])),
        (TypeError, "knots_u and knots_v are missing", lambda: g.Nurbs(POINTS)),
        (TypeError, "real numbers", lambda: g.Nurbs(POINTS + 1j, None, KNOTS_U, KNOTS_V)),
        (TypeError, "real numbers", lambda: hills(1).evaluate("a", 0)),
        (ValueError, "broadcast", lambda: hills(1).evaluate([0.1, 0.2], [0.1, 0.2, 0.3])),
        (ValueError, "order is 17", lambda: hills(1).derivatives(0, 0, 17)),
        (ValueError, "order is 2", lambda: g.Sphere().derivatives(0, 0, 2)),
        (ValueError, "whole", lambda: hills(1).derivatives(0, 0, -1)),
        (ValueError, "tolerance", lambda: hills(1).area(0)),
        (ValueError, "tolerance", lambda: trimmed().area(-1)),
        (ValueError, "tolerance", lambda: g.Sphere().area(math.nan)),
        (ValueError, "tolerance", lambda: hills(1).closest_point([0, 0, 0], math.nan)),
        (ValueError, "point 0 has the coordinate", lambda: hills(1).closest_point([0, 0, math.nan])),
        (ValueError, "points", lambda: hills(1).closest_point([0, 0])),
        (ValueError, "extent|finite", lambda: g.Plane().area()),
        (ValueError, "extent|finite", lambda: g.Plane().closest_point([0, 0, 1])),
        (ValueError, "radius is -1", lambda: g.Sphere(-1)),
        (ValueError, "radius is NaN", lambda: g.Cylinder(math.nan)),
        (ValueError, "minor", lambda: g.Torus(1, 2)),
        (ValueError, "origins has shape", lambda: hills(1).intersect([0, 0, 0], [0, 0, 1])),
        (ValueError, "directions has shape", lambda: hills(1).intersect([[0, 0, 0]], [[0, 1]])),
        (ValueError, "1 origins and 2 directions", lambda: hills(1).intersect([[0, 0, 0]], [[0, 0, 1]] * 2)),
        (ValueError, "ray 1 has", lambda: hills(1).intersect([[0, 0, 0]] * 2, [[0, 0, 1], [0, 0, 0]])),
        (ValueError, "ray 0 has", lambda: hills(1).intersect([[0, 0, math.inf]], [[0, 0, 1]], all_roots=True)),
        (ValueError, "ray 0 has", lambda: hills(1).intersect([[0, 0, 0]], [[0, 0, 1]], t_max=math.nan)),
        (ValueError, "t_max has shape", lambda: hills(1).intersect([[0, 0, 0]], [[0, 0, 1]], t_max=[1, 2])),
        (ValueError, "coincide", lambda: g.BezierPatch(np.ones((2, 2, 3))).intersect([[0, 0, 0]], [[0, 0, 1]])),
        (MemoryError, None, lambda: hills(1).evaluate(np.broadcast_to(0.5, (1 << 50,)), 0.5)),
        (MemoryError, None, lambda: hills(1).evaluate(np.broadcast_to(np.float32(0.5), (1 << 50,)), 0.5)),
    ],
)
def test_bad_arguments_are_exceptions(error: type[Exception], message: str | None, call: Callable[[], object]) -> None:
    with pytest.raises(error, match=message):
        call()


def test_arrays_of_any_layout_give_the_same_results() -> None:
    surface = hills(5)
    origins, directions = rays(1, 1000, np.array([0.5, 0.5, 0]), 0.8)
    origins, directions = (a.astype(np.float32).astype(np.float64) for a in (origins, directions))
    expected = surface.intersect(origins, directions)

    def read_only(a: Any) -> Any:
        a = a.copy()
        a.flags.writeable = False
        return a

    def unaligned(a: Any) -> Any:
        raw = np.zeros(a.nbytes + 1, np.uint8)[1:].view(np.float64).reshape(a.shape)
        raw[:] = a
        return raw

    layouts: list[Callable[[Any], Any]] = [
        np.asfortranarray,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1].copy()[::-1],
        lambda a: a.astype(np.float32),
        lambda a: a.astype(">f8"),
        read_only,
        unaligned,
        lambda a: a.tolist(),
        np.ma.masked_array,
    ]
    for layout in layouts:
        found = surface.intersect(layout(origins), layout(directions))
        np.testing.assert_array_equal(found.distance, expected.distance)
    integers = surface.intersect(np.array([[0, 0, 5]]), np.array([[1, 1, -10]]))
    np.testing.assert_array_equal(integers.distance, surface.intersect([[0.0, 0, 5]], [[1.0, 1, -10]]).distance)


def test_empty_arrays_give_empty_results() -> None:
    none = np.zeros((0, 3))
    for all_roots in (False, True):
        found = hills(1).intersect(none, none, all_roots)
        assert found.distance.shape == (0,) and found.uv.shape == (0, 2) and found.normal.shape == (0, 3)
    assert hills(1).closest_point(none).points.shape == (0, 3)
    assert hills(1).curvature(np.zeros((0, 4)), 0.5).principal.shape == (0, 4, 2)


def test_results_are_arrays_of_the_caller() -> None:
    hits = hills(1).intersect([[0.5, 0.5, 5]], [[0, 0, -1]])
    for array in (hits.distance, hits.uv, hits.normal, hits.hit, hits.undecided):
        assert array.flags.writeable and array.flags.c_contiguous


def test_ctrl_c_ends_a_long_call() -> None:
    surface = nurbs_sphere()
    origins, directions = rays(1, 1 << 22, np.zeros(3), 1.0)
    start = time.monotonic()
    surface.intersect(origins, directions, all_roots=True)
    whole = time.monotonic() - start
    timer = threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT))
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        surface.intersect(origins, directions, all_roots=True)
    # Signals are handled after each eighth of the rays.
    assert time.monotonic() - start < 0.7 * whole


def test_the_nearest_points_of_surfaces_without_extent_or_of_any_size_need_no_tolerance() -> None:
    for size in (0.0, 1e-200, 1e200):
        corners = [[[0.0, 0, 0], [0, size, 0]], [[size, 0, 0], [size, size, 0]]]
        assert np.isfinite(g.BezierPatch(corners).closest_point([0, 0, 0]).distance)


def test_other_threads_run_during_a_long_call() -> None:
    surface = nurbs_sphere()
    origins, directions = rays(1, 1 << 18, np.zeros(3), 1.0)
    counts = [0]
    done = threading.Event()

    def count() -> None:
        while not done.is_set():
            counts[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    before = counts[0]
    surface.intersect(origins, directions, all_roots=True)
    during = counts[0] - before
    done.set()
    thread.join()
    assert during > 3


def random_argument(random: np.random.Generator) -> Any:
    """A number or array that may be anything."""
    kind = random.integers(0, 12)
    values: Any = random.choice([0.0, 1.0, -1.0, 0.5, math.nan, math.inf, 1e300, -1e300, 5e-324, 1e-160, 3.0])
    shape = [(), (3,), (1, 3), (2, 3), (5, 3), (0, 3), (2, 2, 3), (3, 3), (4,), (6, 3)][random.integers(0, 10)]
    if kind < 7:
        return random.uniform(-2, 2, shape)
    if kind < 9:
        array = random.uniform(-1, 1, shape)
        return np.where(random.uniform(0, 1, shape) < 0.3, values, array)
    others: list[Any] = [None, "x", values, [[1], [2, 3]], {}, random.uniform(-1, 1, shape).astype(np.float32)]
    return others[random.integers(0, 6)]


def random_surface(random: np.random.Generator) -> g.Surface:
    """A surface of random, mostly valid, arguments; ValueError or TypeError if they are not."""
    kind = int(random.integers(0, 9))
    numbers = random.choice([0.0, 0.5, 1.0, 2.0, -1.0, 1e-3, 1e150, math.nan], 3, p=[0.05, 0.3, 0.3, 0.2, 0.05, 0.05, 0.03, 0.02])
    x, y, z = (float(number) for number in numbers)
    match kind:
        case 0:
            return g.Sphere(x, (-y, z))
        case 1:
            return g.Cylinder(x, (y, z))
        case 2:
            return g.Cone(x, y, z)
        case 3:
            return g.Torus(x, y, z)
        case 4:
            return g.Disk(x, y, z)
        case 5:
            return g.BezierTriangle(random_argument(random))
        case 6:
            return g.BezierPatch(random_argument(random))
        case 7:
            knots = np.sort(random.uniform(0, 1, 5))
            return g.Nurbs(random.uniform(-1, 1, (3, 3, 3)), None, knots, knots if x else knots[::-1])
        case _:
            return g.BezierPatch(random.uniform(-1, 1, (2, 3, 3)) * (1e100 if x == 2.0 else 1.0))


def test_random_calls_end_in_a_result_or_an_exception() -> None:
    calls = int(os.environ.get("GLANZ_RANDOM_CALLS", "5000"))
    random = np.random.default_rng(6)
    surfaces: list[g.Surface] = [hills(1), nurbs_sphere(), g.Sphere(), g.Torus(), g.Plane()]
    ends: list[Any] = [None, 1.0, math.nan]
    results = 0
    for i in range(calls):
        try:
            if i % 20 == 0:
                surfaces.append(random_surface(random))
                surfaces = surfaces[-40:]
            surface: Any = surfaces[random.integers(0, len(surfaces))]
            a, b = random_argument(random), random_argument(random)
            match int(random.integers(0, 8)):
                case 0:
                    surface.evaluate(a, b)
                case 1:
                    surface.derivatives(a, b, int(random.integers(-1, 4)))
                case 2:
                    surface.normals(a, b)
                case 3:
                    surface.curvature(a, b)
                case 4:
                    surface.contains(a, b)
                case 5:
                    surface.closest_point(a, 1e-3)
                case _:
                    surface.intersect(a, b, bool(random.integers(0, 2)), ends[random.integers(0, 3)])
            results += 1
        except (ValueError, TypeError):
            pass
    assert results > calls / 10

"""Surfaces: values against scipy, geomdl and closed forms; nearest points and hits."""

import importlib
import math
from typing import Any

import numpy as np
import pytest
from surfaces import Floats, hills, net, nurbs_sphere, rays

from glanz import geometry as g

NdBSpline: Any = importlib.import_module("scipy.interpolate").NdBSpline
minimize: Any = importlib.import_module("scipy.optimize").minimize


def homogeneous_derivatives(seed: int, u: Floats, v: Floats, order: tuple[int, int]) -> Floats:
    points, weights, knots_u, knots_v = net(seed)
    n, m = weights.shape
    homogeneous = np.concatenate([points * weights[..., None], weights[..., None]], axis=-1)
    spline: Any = NdBSpline((knots_u, knots_v), homogeneous, (len(knots_u) - n - 1, len(knots_v) - m - 1))
    return spline(np.stack([u, v], axis=-1), nu=order)


@pytest.mark.parametrize("seed", range(10))
def test_values_and_derivatives_are_those_of_scipy(seed: int) -> None:
    u, v = np.random.default_rng(seed).uniform(0, 1, (2, 200))
    a = {(k, l): homogeneous_derivatives(seed, u, v, (k, l)) for k in range(3) for l in range(3 - k)}
    w = {key: value[:, 3:] for key, value in a.items()}
    b = {key: value[:, :3] for key, value in a.items()}
    # Leibniz' rule for the quotient.
    s = {(0, 0): b[0, 0] / w[0, 0]}
    s[1, 0] = (b[1, 0] - w[1, 0] * s[0, 0]) / w[0, 0]
    s[0, 1] = (b[0, 1] - w[0, 1] * s[0, 0]) / w[0, 0]
    s[2, 0] = (b[2, 0] - 2 * w[1, 0] * s[1, 0] - w[2, 0] * s[0, 0]) / w[0, 0]
    s[0, 2] = (b[0, 2] - 2 * w[0, 1] * s[0, 1] - w[0, 2] * s[0, 0]) / w[0, 0]
    s[1, 1] = (b[1, 1] - w[1, 0] * s[0, 1] - w[0, 1] * s[1, 0] - w[1, 1] * s[0, 0]) / w[0, 0]
    found = hills(seed).derivatives(u, v, order=2)
    assert found.shape == (200, 3, 3, 3)
    for (k, l), expected in s.items():
        scale = max(1.0, float(np.abs(expected).max()))
        np.testing.assert_allclose(found[:, k, l], expected, rtol=0, atol=1e-12 * scale)
    assert np.isnan(found[:, 2, 1]).all() and np.isnan(found[:, 2, 2]).all()
    np.testing.assert_array_equal(hills(seed).evaluate(u, v), found[:, 0, 0])


def test_values_are_those_of_geomdl() -> None:
    points, weights, knots_u, knots_v = net(3)
    n, m = weights.shape
    peer: Any = importlib.import_module("geomdl.NURBS").Surface()
    peer.degree_u, peer.degree_v = len(knots_u) - n - 1, len(knots_v) - m - 1
    peer.ctrlpts_size_u, peer.ctrlpts_size_v = n, m
    peer.ctrlptsw = np.concatenate([points * weights[..., None], weights[..., None]], -1).reshape(-1, 4).tolist()
    peer.knotvector_u, peer.knotvector_v = knots_u.tolist(), knots_v.tolist()
    surface = hills(3)
    assert surface.degree == (peer.degree_u, peer.degree_v)
    for u, v in np.random.default_rng(1).uniform(0, 1, (20, 2)):
        expected = np.array(peer.derivatives(u, v, 1))
        found = surface.derivatives(u, v, 1)
        np.testing.assert_allclose(found[0, 0], expected[0, 0], atol=1e-12)
        np.testing.assert_allclose(found[1, 0], expected[1, 0], atol=1e-11)
        np.testing.assert_allclose(found[0, 1], expected[0, 1], atol=1e-11)


def test_shapes_broadcast_and_parameters_are_clamped() -> None:
    surface = hills(1)
    u, v = np.linspace(0, 1, 4)[:, None], np.linspace(0, 1, 5)
    grid = surface.evaluate(u, v)
    assert grid.shape == (4, 5, 3)
    np.testing.assert_array_equal(grid[2, 3], surface.evaluate(u[2, 0], v[3]))
    np.testing.assert_array_equal(surface.evaluate(-1, 2), surface.evaluate(0, 1))
    assert np.isnan(surface.evaluate(math.nan, 0.5)).all()
    assert surface.evaluate([], []).shape == (0, 3)
    assert surface.derivatives(0.5, 0.5, 0).shape == (1, 1, 3)


def test_bezier_triangle_of_a_paraboloid() -> None:
    net_points = [[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [1, 0, 1], [0.5, 0.5, 0], [0, 1, 1]]
    patch = g.BezierTriangle(net_points)
    assert patch.degree == 2
    u, v = 0.4 * np.random.default_rng(2).uniform(0, 1, (2, 100))
    np.testing.assert_allclose(patch.evaluate(u, v), np.stack([u, v, u * u + v * v], -1), atol=1e-15)
    derivatives = patch.derivatives(u, v, 2)
    np.testing.assert_allclose(derivatives[:, 1, 0], np.stack([1 + 0 * u, 0 * u, 2 * u], -1), atol=1e-14)
    np.testing.assert_allclose(derivatives[:, 2, 0], np.broadcast_to([0, 0, 2.0], (100, 3)), atol=1e-14)
    # The graph z = f: K = (fuu fvv - fuv^2) / (1 + fu^2 + fv^2)^2.
    expected = 4 / (1 + 4 * (u * u + v * v)) ** 2
    np.testing.assert_allclose(patch.curvature(u, v).gaussian, expected, rtol=1e-12)
    hits = patch.intersect(np.stack([u, v, 5 + 0 * u], -1), np.broadcast_to([0, 0, -1.0], (100, 3)))
    assert hits.hit.all() and not hits.undecided.any()
    np.testing.assert_allclose(hits.uv, np.stack([u, v], -1), atol=1e-12)
    np.testing.assert_allclose(hits.distance, 5 - u * u - v * v, atol=1e-13)
    near = patch.closest_point(patch.evaluate(u, v))
    np.testing.assert_allclose(near.uv, np.stack([u, v], -1), atol=1e-7)


def test_bezier_patch_is_a_nurbs_surface_without_inner_knots() -> None:
    points = np.random.default_rng(4).uniform(-1, 1, (4, 3, 3))
    patch = g.BezierPatch(points)
    assert isinstance(patch, g.Nurbs) and patch.degree == (3, 2) and patch.domain == ((0, 1), (0, 1))
    np.testing.assert_array_equal(patch.knots_v, [0, 0, 0, 1, 1, 1])
    np.testing.assert_array_equal(patch.control_points, points)
    np.testing.assert_array_equal(patch.weights, np.ones((4, 3)))
    np.testing.assert_allclose(patch.evaluate([0, 1], [0, 1]), points[[0, 3], [0, 2]], atol=1e-15)
    np.testing.assert_allclose(patch.transposed().evaluate(0.3, 0.6), patch.evaluate(0.6, 0.3), atol=1e-14)
    part = patch.restrict((0.2, 0.7), (0.1, 0.4))
    np.testing.assert_allclose(part.evaluate(0.5, 0.2), patch.evaluate(0.5, 0.2), atol=1e-14)


def test_quadrics_have_the_points_curvatures_and_areas_of_their_equations() -> None:
    u, v = np.random.default_rng(5).uniform(0.05, 0.95, (2, 200))
    phi = 2 * math.pi * u
    sphere = g.Sphere(2.0)
    theta = math.pi * (1 - v)
    at = 2 * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    np.testing.assert_allclose(sphere.evaluate(u, v), at, atol=1e-14)
    np.testing.assert_allclose(sphere.normals(u, v), at / 2, atol=1e-14)
    np.testing.assert_allclose(sphere.curvature(u, v).principal, -0.5, atol=1e-7)
    np.testing.assert_allclose(sphere.curvature(u, v).gaussian, 0.25, rtol=1e-10)
    cylinder = g.Cylinder(0.5, (0, 3))
    at = np.stack([0.5 * np.cos(phi), 0.5 * np.sin(phi), 3 * v], -1)
    np.testing.assert_allclose(cylinder.evaluate(u, v), at, atol=1e-14)
    np.testing.assert_allclose(cylinder.curvature(u, v).principal, [[-2.0, 0.0]] * 200, atol=1e-7)
    derivative = 2 * math.pi * np.stack([-0.5 * np.sin(phi), 0.5 * np.cos(phi), 0 * u], -1)
    np.testing.assert_allclose(cylinder.derivatives(u, v)[:, 1, 0], derivative, atol=1e-13)
    torus = g.Torus(2.0, 0.5)
    p = torus.evaluate(u, v)
    np.testing.assert_allclose((np.hypot(p[:, 0], p[:, 1]) - 2) ** 2 + p[:, 2] ** 2, 0.25, rtol=1e-13)
    paraboloid = g.Paraboloid(1.0, (0, 4)).evaluate(u, v)
    np.testing.assert_allclose(paraboloid[:, 0] ** 2 + paraboloid[:, 1] ** 2, paraboloid[:, 2] / 4, rtol=1e-12)
    hyperboloid = g.Hyperboloid((1, 0, -1), (1, 1, 1)).evaluate(u, v)
    t = (hyperboloid[:, 2] + 1) / 2
    np.testing.assert_allclose(hyperboloid[:, 0] ** 2 + hyperboloid[:, 1] ** 2, 1 + t * t, rtol=1e-12)
    for surface, area in [
        (sphere, 16 * math.pi),
        (g.Sphere(3.0, (-1, 2), math.pi), 9 * math.pi),
        (cylinder, 3 * math.pi),
        (g.Cone(1.0, 2.0), math.pi * math.sqrt(5)),
        (g.Disk(2.0, 0.5), math.pi * 3.75),
        (g.Plane((-1, 3), (0, 2)), 8.0),
        (torus, 4 * math.pi**2),
        (nurbs_sphere(), 4 * math.pi),
    ]:
        found = surface.area(1e-9)
        assert abs(float(found) - area) < 1e-8 and found.error < 1e-8, (surface, found)


def test_nearest_points_are_those_of_a_search_of_a_grid_and_its_refinement() -> None:
    surface = hills(7)
    points = np.random.default_rng(8).uniform(-0.3, 1.3, (20, 3))
    found = surface.closest_point(points)
    u, v = np.meshgrid(np.linspace(0, 1, 101), np.linspace(0, 1, 101))
    grid = surface.evaluate(u, v).reshape(-1, 3)
    for i, point in enumerate(points):
        start = int(np.argmin(np.linalg.norm(grid - point, axis=1)))

        def distance(x: Floats, point: Floats = point) -> float:
            return float(np.linalg.norm(surface.evaluate(x[0], x[1]) - point))

        best = minimize(distance, [u.flat[start], v.flat[start]], bounds=[(0, 1)] * 2, tol=1e-14)
        assert found.distance[i] <= best.fun + 1e-12
        assert found.distance[i] >= best.fun - 1e-4
    at = surface.evaluate(found.uv[:, 0], found.uv[:, 1])
    np.testing.assert_allclose(at, found.points, atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(found.points - points, axis=1), found.distance, atol=1e-14)
    assert (found.lower_bound <= found.distance + 1e-14).all()
    # Outside of a sphere the nearest point is in the direction of the centre.
    away = g.Sphere(2.0).closest_point([[[3.0, 4.0, 0.0], [0.0, 0.0, 9.0]]])
    np.testing.assert_allclose(away.distance, [[3, 7]], atol=1e-9)
    np.testing.assert_allclose(away.points, [[[1.2, 1.6, 0], [0, 0, 2]]], atol=1e-6)
    assert away.uv.shape == (1, 2, 2)


@pytest.mark.parametrize("surface", [hills(11), nurbs_sphere(), g.Torus(1.0, 0.4), g.Cone(1.0, 2.0)])
def test_hits_lie_on_the_ray_and_on_the_surface(surface: g.Surface) -> None:
    bounds = surface.bounds
    origins, directions = rays(1, 20_000, bounds.mean(axis=0), float(np.linalg.norm(bounds[1] - bounds[0])) / 2)
    hits = surface.intersect(origins, directions)
    assert 0.1 < hits.hit.mean() < 1 and not hits.undecided.any()
    on_ray = (origins + hits.distance[:, None] * directions)[hits.hit]
    at = surface.evaluate(hits.uv[hits.hit, 0], hits.uv[hits.hit, 1])
    np.testing.assert_allclose(at, on_ray, atol=1e-10)
    np.testing.assert_allclose(np.linalg.norm(hits.normal[hits.hit], axis=1), 1, atol=1e-12)
    miss = ~hits.hit
    assert np.isinf(hits.distance[miss]).all() and np.isnan(hits.uv[miss]).all() and np.isnan(hits.normal[miss]).all()
    every = surface.intersect(origins, directions, all_roots=True)
    count = np.diff(every.offsets)
    np.testing.assert_array_equal(count > 0, hits.hit)
    first = every.offsets[:-1][hits.hit]
    np.testing.assert_array_equal(every.distance[first], hits.distance[hits.hit])
    np.testing.assert_array_equal(every.ray, np.repeat(np.arange(len(origins)), count))
    cut = surface.intersect(origins, directions, t_max=hits.distance)
    assert not cut.hit.any()


def test_a_line_meets_a_torus_four_times_and_a_sphere_twice() -> None:
    origins, directions = np.array([[-5.0, 0.1, 0.1], [0, 0, 5]]), np.array([[2.0, 0, 0], [0, 0, -1]])
    torus = g.Torus(1.0, 0.4).intersect(origins, directions, all_roots=True)
    np.testing.assert_array_equal(torus.offsets, [0, 4, 4])
    ring = np.array([-1, -1, 1, 1]) * np.sqrt((1 + np.array([1, -1, -1, 1]) * math.sqrt(0.15)) ** 2 - 0.01)
    np.testing.assert_allclose(torus.distance, (5 + ring) / 2, atol=1e-13)
    ball = nurbs_sphere().intersect(origins, directions, all_roots=True)
    # Along the axis, the ray meets the poles, where an edge of every patch is one point.
    assert ball.offsets[1] == 2
    x = math.sqrt(0.98)
    np.testing.assert_allclose(ball.distance[:2], [(5 - x) / 2, (5 + x) / 2], atol=1e-12)


def test_a_ray_within_a_flat_patch_is_undecided_or_missed_but_never_hangs() -> None:
    flat = g.BezierPatch([[[0.0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]])
    found = flat.intersect([[-1.0, 0.5, 0], [0.5, 0.5, 1]], [[1.0, 0, 0], [0, 0, -1]])
    assert not found.undecided[1] and found.distance[1] == 1.0


def test_trims_keep_the_inside_of_counter_clockwise_loops_and_cut_out_clockwise_ones() -> None:
    points = np.zeros((2, 2, 3))
    points[1, :, 0] = points[:, 1, 1] = 1
    knots = [0.0, 0, 1, 1]
    w = math.sqrt(0.5)
    circle = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0.0]])
    hole = 0.5 + 0.2 * circle[::-1]
    circle_knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]
    weights = [1, w, 1, w, 1, w, 1, w, 1]
    square = np.array([[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]])
    plate = g.Nurbs(points, None, knots, knots, trims=[square, [(2, hole, weights, circle_knots)]])
    assert plate.trimmed
    xy = np.random.default_rng(3).uniform(0, 1, (5000, 2))
    inside = (np.abs(xy - 0.5).max(axis=1) < 0.4) & (np.linalg.norm(xy - 0.5, axis=1) > 0.2)
    np.testing.assert_array_equal(plate.contains(xy[:, 0], xy[:, 1]), inside)
    origins = np.concatenate([xy, np.ones((5000, 1))], axis=1)
    hits = plate.intersect(origins, np.broadcast_to([0, 0, -1.0], (5000, 3)))
    np.testing.assert_array_equal(hits.hit, inside)
    area = plate.area()
    assert abs(area.value - (0.64 - 0.04 * math.pi)) < 1e-9 and area.error < 1e-9
    with pytest.raises(ValueError, match="trimmed"):
        plate.transposed()
    polylines = [[square[:3], square[[2, 3, 0]]]]
    assert g.Nurbs(points, None, knots, knots, trims=polylines).contains(0.5, 0.5)
    with pytest.raises(ValueError, match="ends at"):
        g.Nurbs(points, None, knots, knots, trims=[[square[:3], square[[3, 0]]]])


def test_areas_of_small_triangles_of_a_square_are_found() -> None:
    knots = [0.0, 0, 1, 1]
    for w in (0.1, 0.01, 0.001, 1e-6):
        triangle = [[0.537, 0.537], [0.537 + w, 0.537], [0.537, 0.537 + w]]
        plate = g.Nurbs([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]], None, knots, knots, trims=[triangle])
        area = plate.area()
        assert abs(area.value - w * w / 2) < 1e-9 * w and area.error < 1e-9 * w, (w, area)


@pytest.mark.parametrize("plane", [g.Plane(), g.Plane((0, 4), (-math.inf, 1)), g.Plane((-1, 3), (0, 2))])
def test_parameters_of_hits_on_planes_are_those_of_their_points(plane: g.Plane) -> None:
    xy = np.random.default_rng(1).uniform(0.1, 0.9, (50, 2))
    origins = np.column_stack([xy, np.ones(50)])
    hits = plane.intersect(origins, np.broadcast_to([0, 0, -1.0], (50, 3)))
    u, v = hits.uv.T
    assert plane.contains(u, v).all()
    np.testing.assert_allclose(plane.evaluate(u, v), origins - [0, 0, 1], atol=1e-14)
    np.testing.assert_array_equal(plane.normals(u, v), hits.normal)
    np.testing.assert_allclose(plane.curvature(u, v).gaussian, 0)


def test_results_do_not_depend_on_the_order_of_rays() -> None:
    surface = hills(2)
    origins, directions = rays(3, 10_000, np.array([0.5, 0.5, 0]), 0.8)
    order = np.random.default_rng(1).permutation(10_000)
    one, other = surface.intersect(origins, directions), surface.intersect(origins[order], directions[order])
    np.testing.assert_array_equal(one.distance[order], other.distance)
    np.testing.assert_array_equal(one.uv[order], other.uv)

"""Closest hits against OpenCascade (cadquery-ocp), if it is installed: 1000 rays, or GLANZ_OCC_RAYS."""

import importlib
import os
from typing import Any

import numpy as np
import pytest
from surfaces import Floats, hills, net, rays

RAYS = int(os.environ.get("GLANZ_OCC_RAYS", "1000"))
SURFACES = 10


def occ(module: str, name: str) -> Any:
    """A class of OpenCascade."""
    return getattr(importlib.import_module(f"OCP.{module}"), name)


def opencascade_face(seed: int) -> Any:
    """The face of `hills(seed)`."""
    points, weights, knots_u, knots_v = net(seed)
    n, m = weights.shape
    poles: Any = occ("collections", "Array2_gp_Pnt")(1, n, 1, m)
    factors: Any = occ("collections", "Array2_double")(1, n, 1, m)
    for i, j in np.ndindex(n, m):
        poles.SetValue(i + 1, j + 1, occ("gp", "gp_Pnt")(*map(float, points[i, j])))
        factors.SetValue(i + 1, j + 1, float(weights[i, j]))

    def vector(knots: Floats) -> tuple[Any, Any]:
        values, counts = np.unique(knots, return_counts=True)
        reals: Any = occ("collections", "Array1_double")(1, len(values))
        integers: Any = occ("collections", "Array1_int")(1, len(values))
        for i, (value, count) in enumerate(zip(values, counts, strict=True)):
            reals.SetValue(i + 1, float(value))
            integers.SetValue(i + 1, int(count))
        return reals, integers

    (ku, mu), (kv, mv) = vector(knots_u), vector(knots_v)
    degrees = len(knots_u) - n - 1, len(knots_v) - m - 1
    surface: Any = occ("Geom", "Geom_BSplineSurface")(poles, factors, ku, kv, mu, mv, *degrees, False, False)
    return occ("BRepBuilderAPI", "BRepBuilderAPI_MakeFace")(surface, 1e-7).Face()


def test_closest_hits_are_those_of_opencascade() -> None:
    pytest.importorskip("OCP")
    agree, largest, differ = 0, 0.0, list[str]()
    for seed in range(SURFACES):
        surface = hills(seed)
        origins, directions = rays(seed, RAYS // SURFACES, np.array([0.5, 0.5, 0]), 0.8)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        hits = surface.intersect(origins, directions)
        intersector: Any = occ("IntCurvesFace", "IntCurvesFace_Intersector")(opencascade_face(seed), 1e-9)
        for i, (o, d) in enumerate(zip(origins.tolist(), directions.tolist(), strict=True)):
            intersector.Perform(occ("gp", "gp_Lin")(occ("gp", "gp_Pnt")(*o), occ("gp", "gp_Dir")(*d)), 0.0, 100.0)
            count = intersector.NbPnt() if intersector.IsDone() else 0
            t = min((intersector.WParameter(k + 1) for k in range(count)), default=np.inf)
            found = float(hits.distance[i])
            if t == found or abs(t - found) < 1e-6:
                agree += 1
                largest = max(largest, abs(t - found) if np.isfinite(t) else 0.0)
            else:
                uv = hits.uv[i] if np.isfinite(found) else np.full(2, np.nan)
                cosine = abs(float(hits.normal[i] @ directions[i]))
                # Ours is a point of the ray and of the surface.
                apart = float(np.linalg.norm(surface.evaluate(*uv) - origins[i] - found * directions[i]))
                assert not np.isfinite(found) or apart < 1e-9
                border = float(np.nanmin(np.minimum(uv, 1 - uv))) if np.isfinite(found) else np.nan
                differ.append(f"surface {seed} ray {i}: {t} {found} apart {apart:.1e} cosine {cosine:.1e} border {border:.1e}")
    print(f"{agree} of {RAYS} agree, largest difference {largest:.2e}; others:", *differ, sep="\n")
    # OpenCascade's tolerance at borders and silhouettes.
    assert agree >= 0.999 * (RAYS // SURFACES * SURFACES), differ

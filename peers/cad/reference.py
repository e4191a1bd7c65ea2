#!/usr/bin/env python3
"""What OpenCascade says of a STEP or IGES file: faces, solids, and all intersections of random rays.

    python3 -m venv VENV && VENV/bin/pip install cadquery-ocp numpy
    VENV/bin/python peers/cad/reference.py FILE.step ... -o FOLDER|REF.json [--rays 10000] [--seed 1]

Units are metres. The result, as JSON:

    file, seed, seconds (of reading, faces, solids, rays)
    entities      numbers of all faces in the file
    uncertainty   distance accuracy of the file: the largest of its contexts; units: length units of its contexts
    bounds        [min, max] of everything
    misread       [entity, area] of the faces of a file of models.py whose area was another one before it was written: the shape from
                  before, which models.py has stored beside it, takes the place of what OpenCascade has read, in everything that follows
    moved         whether OpenCascade moved the shape by an axis placement of its representation, which is undone here
    faces         one per face of the file, in the coordinates of its part, not per occurrence:
                  entity (null if unknown), kind, area, area_error (relative), area_adaptive and area_gauss (of BRepGProp), bounds,
                  centroid, forward (orientation in its shell), tolerance (largest of its edges and vertices), occurrences, status
                  ("read", or why not)
    solids        one per occurrence: entity, volume, volume_adaptive (of BRepGProp), area, bounds, closed, faces (number)
    rays          [x, y, z, dx, dy, dz, length]: directions have unit length, hits lie within 0 .. length
    hits          per ray [t, face (index in faces), distance to the nearest edge or vertex of the face, cosine to its normal] ascending
    odd           rays that cross the boundary of some closed solid an odd number of times: OpenCascade contradicts itself

Where the two quadratures of BRepGProp differ, areas and volumes are integrated here, over the surfaces and parameter curves of
OpenCascade (integral.py): BRepGProp is wrong by up to 2e-2 on extruded splines.

Rays are chords of the sphere around the bounds (half of its diagonal, times 1.01): the first half goes through two points that are
uniform on it, the second half through a point that is uniform in the bounds, in a uniform direction. Generator: PCG64 of numpy,
`default_rng(seed)`, directions as normalised normal deviates.

Intersector: IntCurvesFace_Intersector (the one that IntCurvesFace_ShapeIntersector holds per face) with its tolerance 1e-7 mm, on the
faces whose bounding box the ray hits. Distances to edges below 2e-3 of the size are those of BRepExtrema, others within 1e-4 of the size.

A file is read in a process of its own. A face at which it crashes or stands still is left out, and its status says so.
"""

import argparse
import json
import math
import multiprocessing
import pathlib
import time

import numpy

from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire, BRepBuilderAPI_NurbsConvert
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepPrimAPI import (BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism, BRepPrimAPI_MakeSphere,
                             BRepPrimAPI_MakeTorus)
from OCP.collections import Array1_gp_Pnt
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IntCurvesFace import IntCurvesFace_Intersector
from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance
from OCP.TopAbs import TopAbs_FACE, TopAbs_FORWARD, TopAbs_SHELL
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

from edge_integral import EdgeIntegral, area_from_edges
from edges import Boundary
from iges import open_file
from integral import FaceIntegral
from step import FAILURES, METRE, explore

# Relative error of areas and volumes that the integration aims at.
INTEGRATION = 1e-7

# Relative difference of both quadratures of BRepGProp up to which they are believed.
AGREEMENT = 1e-9

# Tolerance of the intersector, mm.
INTERSECTION = 1e-7

# Deflection of the polylines of edges, of the size.
DEFLECTION = 1e-4

# Seconds without progress after which a face counts as hanging.
PATIENCE = 150

KINDS = {"BSplineSurface": "spline", "BezierSurface": "spline", "SurfaceOfRevolution": "revolution", "SurfaceOfExtrusion": "extrusion",
         "OffsetSurface": "offset", "OtherSurface": "other"}


def bounds_of(shape, optimal=True):
    """Minimum and maximum in metres, or None."""
    box = Bnd_Box()
    if optimal:
        BRepBndLib.AddOptimal_s(shape, box, False, False)
        box.SetGap(0)
    else:
        BRepBndLib.Add_s(shape, box, False)
    if box.IsVoid():
        return None
    low, high = box.CornerMin(), box.CornerMax()
    return [[x * METRE for x in (p.X(), p.Y(), p.Z())] for p in (low, high)]


def bounds_of_solid(solid):
    """Minimum and maximum in metres, also of its triangles: the optimal box of a hemisphere may be smaller."""
    low, high = (numpy.array(end) for end in bounds_of(solid))
    BRepMesh_IncrementalMesh(solid, numpy.linalg.norm(high - low) / METRE * DEFLECTION / 2, False, 0.5)
    for face in explore(solid, TopAbs_FACE):
        location = TopLoc_Location()
        triangles = BRep_Tool.Triangulation_s(TopoDS.Face(face), location)
        for number in range(1, triangles.NbNodes() + 1 if triangles else 1):
            node = triangles.Node(number).Transformed(location.Transformation())
            node = METRE * numpy.array([node.X(), node.Y(), node.Z()])
            low, high = numpy.minimum(low, node), numpy.maximum(high, node)
    return [low.tolist(), high.tolist()]


def kind_of(face):
    name = BRepAdaptor_Surface(face).GetType().name.removeprefix("GeomAbs_")
    return KINDS.get(name, name.lower())


def integral_of(face):
    """Area and volume of the cone from the origin, metres, and relative error."""
    area, volume, error = FaceIntegral(TopoDS.Face(face)).converged(INTEGRATION)
    return area * METRE**2, volume * METRE**3, error


def describe_face(face, entity, occurrences):
    """The entry of a face; `status` tells what did not work."""
    face = TopoDS.Face(face.Located(TopLoc_Location()))
    entry = {"entity": entity, "kind": kind_of(face), "area": None, "occurrences": occurrences, "status": "read",
             "forward": face.Orientation() == TopAbs_FORWARD}
    try:
        adaptive, gauss = GProp_GProps(), GProp_GProps()
        entry["area_error"] = BRepGProp.SurfaceProperties_s(face, adaptive, INTEGRATION)
        BRepGProp.SurfaceProperties_s(face, gauss)
        entry["area_adaptive"], entry["area_gauss"] = (p.Mass() * METRE**2 for p in (adaptive, gauss))
        entry["area"] = entry["area_adaptive"]
        if abs(entry["area_gauss"] - entry["area"]) > AGREEMENT * abs(entry["area"]):
            entry["area"], _, entry["area_error"] = integral_of(face)
        centre = adaptive.CentreOfMass()
        entry["centroid"] = [x * METRE for x in (centre.X(), centre.Y(), centre.Z())]
        entry["bounds"] = bounds_of(face)
        entry["tolerance"] = ShapeAnalysis_ShapeTolerance().Tolerance(face, 1) * METRE
        if not entry["area"] > 0:
            entry["status"] = f"area is {entry['area']}"
    except FAILURES as error:
        entry["status"] = f"failed: {error}"
    return entry


def describe_solid(solid, entity):
    entry = {"entity": entity, "volume": None, "area": None, "faces": sum(1 for _ in explore(solid, TopAbs_FACE))}
    try:
        entry["closed"] = all(BRep_Tool.IsClosed_s(shell) for shell in explore(solid, TopAbs_SHELL))
        entry["bounds"] = bounds_of_solid(solid)
        measures = []
        for measure in (BRepGProp.VolumeProperties_s, BRepGProp.SurfaceProperties_s):
            for accuracy in ((INTEGRATION,), ()):
                properties = GProp_GProps()
                measure(solid, properties, *accuracy)
                measures.append(properties.Mass())
        entry["volume_adaptive"] = entry["volume"] = measures[0] * METRE**3
        entry["area"] = measures[2] * METRE**2
        if any(abs(one - other) > AGREEMENT * abs(one) for one, other in (measures[:2], measures[2:])):
            parts = [(integral_of(face), face.Orientation() == TopAbs_FORWARD)
                     for face in explore(solid.Located(TopLoc_Location()), TopAbs_FACE)]
            entry["volume"] = sum(volume if forward else -volume for (_, volume, _), forward in parts)
            entry["area"] = sum(area for (area, _, _), _ in parts)
    except FAILURES as error:
        entry["failed"] = str(error)
    return entry


def random_rays(bounds, count, seed):
    """Rays (count, 7) as the top of the file describes."""
    random = numpy.random.default_rng(seed)
    low, high = numpy.array(bounds)
    centre, radius = (low + high) / 2, 0.505 * numpy.linalg.norm(high - low)

    def directions(number):
        deviates = random.standard_normal((number, 3))
        return deviates / numpy.linalg.norm(deviates, axis=1, keepdims=True)

    half = count // 2
    start, end = centre + radius * directions(half), centre + radius * directions(half)
    length = numpy.linalg.norm(end - start, axis=1)
    through, direction = random.uniform(low, high, (count - half, 3)), directions(count - half)
    middle = ((through - centre) * direction).sum(1)
    reach = numpy.sqrt(middle**2 + radius**2 - ((through - centre)**2).sum(1))
    origin = through - (middle + reach)[:, None] * direction
    return numpy.vstack([numpy.column_stack([start, (end - start) / length[:, None], length]),
                         numpy.column_stack([origin, direction, 2 * reach])])


def rays_of_box(rays, bounds, margin):
    """Indices of the rays that hit the box."""
    low, high = numpy.array(bounds[0]) - margin, numpy.array(bounds[1]) + margin
    with numpy.errstate(divide="ignore", invalid="ignore"):
        one, other = (low - rays[:, :3]) / rays[:, 3:6], (high - rays[:, :3]) / rays[:, 3:6]
    near, far = numpy.fmin(one, other).max(1), numpy.fmax(one, other).min(1)
    return numpy.flatnonzero((near <= far) & (far >= 0) & (near <= rays[:, 6]))


def hits_of_face(face, rays, indices):
    """(ray, t, cosine) of all hits on one face, metres."""
    intersector = IntCurvesFace_Intersector(face, INTERSECTION)
    surface, point, u_vector, v_vector = BRepAdaptor_Surface(face), gp_Pnt(), gp_Vec(), gp_Vec()
    result = []
    for index in indices.tolist():
        ray = rays[index].tolist()
        direction = gp_Dir(*ray[3:6])
        intersector.Perform(gp_Lin(gp_Pnt(*(x / METRE for x in ray[:3])), direction), 0.0, ray[6] / METRE)
        if not intersector.IsDone():
            continue
        for k in range(1, intersector.NbPnt() + 1):
            surface.D1(intersector.UParameter(k), intersector.VParameter(k), point, u_vector, v_vector)
            normal = u_vector.Crossed(v_vector)
            size = normal.Magnitude()
            cosine = abs(normal.Dot(gp_Vec(direction))) / size if size > 0 else 0.0
            result.append((index, intersector.WParameter(k) * METRE, cosine))
    return result


class FileReference:
    """Everything about one file, in steps that a crash may interrupt; `at` stores the current one."""

    def __init__(self, path, count, seed, skip, at):
        self.count, self.seed, self.skip, self.at, self.seconds = count, seed, skip, at, {}
        self.path = path
        start = time.perf_counter()
        self.file = open_file(path)
        self.occurrences = [TopoDS.Face(face) for face in self.file.faces()]
        self.order = {}
        for face in self.occurrences:
            self.order.setdefault(face.TShape(), []).append(face)
        self.index = {shape: i for i, shape in enumerate(self.order)}
        self.seconds["read"] = time.perf_counter() - start

    def timed(self, name, work):
        start = time.perf_counter()
        result = work()
        self.seconds[name] = time.perf_counter() - start
        return result

    def steps(self, stage, items):
        """Pairs of index and item without those that crashed before."""
        for index, item in enumerate(items):
            with self.at.get_lock():
                self.at[:] = (stage, index, self.at[2] + 1)
            yield index, None if (stage, index) in self.skip else item

    def faces(self):
        result = []
        for index, same in self.steps(0, self.order.values()):
            if same is None:
                face = list(self.order.values())[index][0]
                result.append({"entity": self.file.entity(face), "kind": None, "area": None, "occurrences": 1,
                               "status": self.skip[(0, index)]})
            else:
                result.append(describe_face(same[0], self.file.entity(same[0]), len(same)))
        return result

    def solids(self):
        return [{"entity": None, "failed": self.skip[(1, index)]} if solid is None
                else describe_solid(solid, self.file.entity(solid)) for index, solid in self.steps(1, self.file.solids())]

    def hits(self, rays, size):
        """Hits of all rays, and per face occurrence whether OpenCascade failed on it."""
        hits, failed = [[] for _ in rays], {}
        self.crossings = {}
        for number, face in self.steps(2, self.occurrences):
            if face is None:
                failed[number] = self.skip[(2, number)]
                continue
            bounds = bounds_of(face, False)
            if bounds is None:
                continue
            try:
                found = hits_of_face(face, rays, rays_of_box(rays, bounds, 1e-6 * size))
            except FAILURES as error:
                failed[number] = f"no intersection: {error}"
                continue
            points = [rays[ray, :3] + t * rays[ray, 3:6] for ray, t, _ in found]
            distances = Boundary(face, DEFLECTION * size / METRE).distances(numpy.array(points) / METRE) * METRE
            for (ray, t, cosine), distance in zip(found, distances.tolist()):
                hits[ray].append([t, self.index[face.TShape()], float(f"{distance:.6g}"), round(cosine, 6)])
            self.crossings[number] = [ray for ray, _, _ in found]
        for ray in hits:
            ray.sort()
        return hits, failed

    def odd(self, solids):
        """Rays with an odd number of hits of a closed solid."""
        numbers = {}
        for number, face in enumerate(self.occurrences):
            numbers.setdefault((face.TShape(), face.Location().HashCode()), []).append(number)
        result = set()
        for solid, entry in zip(self.file.solids(), solids):
            if not entry.get("closed"):
                continue
            parity = numpy.zeros(self.count, dtype=int)
            for face in explore(solid, TopAbs_FACE):
                for number in numbers.get((face.TShape(), face.Location().HashCode()), [])[:1]:
                    numpy.add.at(parity, self.crossings.get(number, []), 1)
            result.update(numpy.flatnonzero(parity % 2).tolist())
        return sorted(result)

    def everything(self):
        bounds = bounds_of(self.file.shape) if self.occurrences else None
        result = {"file": self.path.name, "seed": self.seed, "entities": self.file.faces_of_file,
                  "uncertainty": max(self.file.uncertainties, default=None), "units": self.file.units, "bounds": bounds,
                  "moved": self.file.moved, "misread": list(self.file.misread.items())}
        result["faces"] = self.timed("faces", self.faces)
        result["solids"] = self.timed("solids", self.solids)
        rays, hits, failed, odd = numpy.zeros((0, 7)), [], {}, []
        if bounds is not None and self.count:
            rays = random_rays(bounds, self.count, self.seed)
            hits, failed = self.timed("rays", lambda: self.hits(rays, math.dist(*bounds)))
            odd = self.odd(result["solids"])
        for number, why in failed.items():
            result["faces"][self.index[self.occurrences[number].TShape()]]["status"] = why
        result |= {"rays": rays.tolist(), "hits": hits, "odd": odd, "seconds": self.seconds}
        return result


def work(path, out, count, seed, skip, at):
    result = FileReference(path, count, seed, skip, at).everything()
    out.write_text(json.dumps(result, separators=(",", ":"), allow_nan=False) + "\n")


def refer(path, out, count, seed):
    """Runs `work` until it ends, without the steps that crash or hang. Returns what was left out."""
    skip = {}
    while True:
        at = multiprocessing.Array("q", [-1, -1, 0])
        process = multiprocessing.Process(target=work, args=(path, out, count, seed, skip, at))
        process.start()
        seen, why = -1, None
        while process.is_alive():
            process.join(PATIENCE)
            if process.is_alive() and at[2] == seen:
                process.kill()
                process.join()
                why = f"no result within {PATIENCE} s"
            seen = at[2]
        if process.exitcode == 0:
            return skip
        where = (at[0], at[1])
        if where in skip or where == (-1, -1) or process.exitcode > 0:
            raise RuntimeError(f"{path}: ended with {process.exitcode} at step {where}")
        skip[where] = why or f"crashed (signal {-process.exitcode})"


def summary(result):
    faces = result["faces"]
    areas = [face["area"] for face in faces if face["area"]]
    hits = sum(map(len, result["hits"]))
    missing = set(result["entities"]) - {face["entity"] for face in faces}
    odd = [f"#{face['entity']} {face['status']}" for face in faces if face["status"] != "read"]
    volumes = sum(solid.get("volume") or 0 for solid in result["solids"])
    return (f"{result['file']}: {len(result['entities'])} face entities, {len(faces)} faces, "
            f"{sum(face['occurrences'] for face in faces)} occurrences, {len(result['solids'])} solids, area {sum(areas):.9g} m2, "
            f"volume {volumes:.9g} m3, {hits} hits, {len(result['odd'])} odd rays, "
            + ", ".join(f"{name} {seconds:.2f} s" for name, seconds in result["seconds"].items())
            + (f" | not in the shape: {sorted(missing)}" if missing else "") + (f" | {odd}" if odd else ""))


def edge_test(shape, expected):
    """The areas from the edges alone against the area of a whole shape, mm2."""
    area = sum(area_from_edges(TopoDS.Face(face))[0] for face in explore(shape, TopAbs_FACE)) / METRE**2
    assert abs(area / expected - 1) < INTEGRATION, (area, expected)


def self_test():
    """The integrals of integral.py and edge_integral.py against closed forms: a ball, a slanted prism of a closed spline, primitives."""
    ball = next(explore(BRepPrimAPI_MakeSphere(2).Shape(), TopAbs_FACE))
    points = Array1_gp_Pnt(1, 25)
    for i in range(25):
        angle = i * math.pi / 12
        radius = 20 + 5 * math.cos(3 * angle)
        points.SetValue(i + 1, gp_Pnt(radius * math.cos(angle), radius * math.sin(angle), 0))
    edge = BRepBuilderAPI_MakeEdge(GeomAPI_PointsToBSpline(points).Curve()).Edge()
    base = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(edge).Wire()).Face()
    prism = BRepPrimAPI_MakePrism(base, gp_Vec(3, 0, 12)).Shape()
    area = integral_of(base)[0]
    volume = sum(integral_of(face)[1] * (1 if face.Orientation() == TopAbs_FORWARD else -1) for face in explore(prism, TopAbs_FACE))
    for value, expected in ((integral_of(ball)[0], 16 * math.pi * METRE**2), (integral_of(ball)[1], 32 / 3 * math.pi * METRE**3),
                            (volume, area * 12 * METRE)):
        assert abs(abs(value) / expected - 1) < INTEGRATION, (value, expected)
    edge_test(prism, sum(integral_of(face)[0] for face in explore(prism, TopAbs_FACE)) / METRE**2)
    for shape, expected in ((BRepPrimAPI_MakeCylinder(2, 3), 2 * math.pi * 2 * 5), (BRepPrimAPI_MakeCone(3, 0, 4), math.pi * 3 * 8),
                            (BRepPrimAPI_MakeSphere(2, math.pi / 6), 4 * math.pi / 3 + 4 * math.pi),
                            (BRepPrimAPI_MakeSphere(2), 16 * math.pi), (BRepPrimAPI_MakeTorus(3, 1), 12 * math.pi**2),
                            (BRepPrimAPI_MakeTorus(3, 1, math.pi / 2), 3 * math.pi**2 + 2 * math.pi)):
        edge_test(shape.Shape(), expected)
        edge_test(BRepBuilderAPI_NurbsConvert(shape.Shape()).Shape(), expected)
    enclosed = EdgeIntegral(base)
    assert abs(enclosed.distance(gp_Pnt(1, 2, 3)) - 3) < INTEGRATION
    assert enclosed.distance(gp_Pnt(26, 0, 0)) == math.inf
    print("the tests of the integrals pass")


def main():
    parser = argparse.ArgumentParser(description="What OpenCascade says of STEP and IGES files; the top of the program describes the result.")
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    parser.add_argument("-o", "--out", type=pathlib.Path, default=".", help="file, or folder for several")
    parser.add_argument("--rays", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    if arguments.self_test:
        self_test()
    for path in arguments.files:
        out = arguments.out / f"{path.stem}.json" if arguments.out.is_dir() else arguments.out
        try:
            refer(path, out, arguments.rays, arguments.seed)
            print(summary(json.loads(out.read_text())), flush=True)
        except RuntimeError as error:
            print(error, flush=True)


if __name__ == "__main__":
    main()

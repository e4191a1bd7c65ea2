#!/usr/bin/env python3
"""Ray intersection of one trimmed rational bicubic face: Glanz and the line-face intersectors of OpenCascade, in one run.

    python3 -m venv VENV && VENV/bin/pip install cadquery-ocp
    VENV/bin/python peers/freeform/opencascade.py [--size 480x270] [--rounds 5] [--out benches/results/NAME.json]

The face has 25 rational bicubic patches with twelve round holes; control points, knots, weights, circles and rays (f32 numbers)
are the same on both sides. One thread; times are processor times. OpenCascade (IntCurvesFace_Intersector and
IntCurvesFace_ShapeIntersector, lines created beforehand, tolerance 1e-7) is called from Python: the time of the same number of
calls with the same kinds of arguments (an object and two numbers) but little work is measured as well and subtracted. Its
intersector finds all roots; Glanz is measured for the closest hit, as renderers use it, in batches and ray by ray, and for all hits.
"""

import argparse
import array
import json
import math
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepLib import BRepLib
from OCP.collections import Array1_double, Array1_int, Array2_double, Array2_gp_Pnt
from OCP.Geom import Geom_BSplineSurface
from OCP.Geom2d import Geom2d_Circle
from OCP.gp import gp_Ax22d, gp_Dir, gp_Dir2d, gp_Lin, gp_Pnt, gp_Pnt2d
from OCP.IntCurvesFace import IntCurvesFace_Intersector, IntCurvesFace_ShapeIntersector

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TOLERANCE = 1e-7
FAR = 1e9

# Queries of Glanz; the ratios are those of batches.
BATCH = "closest_batch"
QUERIES = (BATCH, "closest", "all")


def one_dimensional(kind, values):
    values = list(values)
    result = kind(1, len(values))
    for i, value in enumerate(values):
        result.SetValue(i + 1, value)
    return result


def distinct(knots):
    values = sorted(set(knots))
    return one_dimensional(Array1_double, values), one_dimensional(Array1_int, (knots.count(x) for x in values))


def face_of(spline):
    """The spline surface with its holes."""
    knots_u, times_u = distinct(spline["knots_u"])
    knots_v, times_v = distinct(spline["knots_v"])
    rows = len(spline["knots_u"]) - spline["degree_u"] - 1
    columns = len(spline["points"]) // rows
    points, weights = Array2_gp_Pnt(1, rows, 1, columns), Array2_double(1, rows, 1, columns)
    for index, (x, y, z, w) in enumerate(spline["points"]):
        i, j = divmod(index, columns)
        points.SetValue(i + 1, j + 1, gp_Pnt(x / w, y / w, z / w))
        weights.SetValue(i + 1, j + 1, w)
    surface = Geom_BSplineSurface(points, weights, knots_u, knots_v, times_u, times_v, spline["degree_u"], spline["degree_v"])
    face = BRepBuilderAPI_MakeFace(surface, TOLERANCE)
    for x, y, radius in spline["holes"]:
        circle = Geom2d_Circle(gp_Ax22d(gp_Pnt2d(x, y), gp_Dir2d(1, 0), True), radius)
        wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle, surface, 0, 2 * math.pi).Edge()).Wire()
        BRepLib.BuildCurves3d_s(wire)
        wire.Reverse()
        face.Add(wire)
    return face.Face()


def lines_of(path):
    numbers = array.array("f")
    data = path.read_bytes()
    numbers.frombytes(data[4:])
    origin = [gp_Pnt(*numbers[i:i + 3]) for i in range(0, len(numbers), 6)]
    return [gp_Lin(o, gp_Dir(*numbers[i + 3:i + 6])) for o, i in zip(origin, range(0, len(numbers), 6))]


def face_hits(face):
    intersector = IntCurvesFace_Intersector(face, TOLERANCE)

    def run(lines):
        perform, hits = intersector.Perform, 0
        for line in lines:
            perform(line, 0.0, FAR)
            hits += intersector.NbPnt() > 0
        return hits

    def nearest():
        return min((intersector.WParameter(i + 1) for i in range(intersector.NbPnt())), default=-1.0)

    return run, intersector.Perform, nearest


def shape_hits(face):
    intersector = IntCurvesFace_ShapeIntersector()
    intersector.Load(face, TOLERANCE)

    def run(lines):
        perform, hits = intersector.PerformNearest, 0
        for line in lines:
            perform(line, 0.0, FAR)
            hits += intersector.NbPnt() > 0
        return hits

    return run, intersector.PerformNearest, None


def calls(lines):
    """The same number of calls with little work: whether the origin is within 1e9 of the line, and the sign of a coordinate."""
    origin = gp_Pnt(0, 0, 0)
    for line in lines:
        line.Contains(origin, FAR)
        origin.X() > 0


def timed(work, *arguments):
    start = time.process_time()
    result = work(*arguments)
    return time.process_time() - start, result


class Glanz:
    """The program of compare.py."""

    def __init__(self, folder, size):
        cargo = ["cargo", "build", "--release", "-p", "glanz-geometry", "--example", "peer_freeform", "--message-format=json"]
        messages = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
        built = [json.loads(line) for line in messages.splitlines()]
        program = next(m["executable"] for m in built
                       if m.get("target", {}).get("name") == "peer_freeform" and m.get("executable"))
        self.process = subprocess.Popen([program, folder, "rational trimmed", *size], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)
        self.read()

    def read(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit("Glanz ended unexpectedly")
        return line

    def say(self, *task):
        print(*task, file=self.process.stdin, flush=True)
        return self.read()

    def rate(self, rays, query):
        """Rays per second; the set is repeated until the resolution of the kernel's clock does not matter."""
        _, processor, count, hits, _ = self.say(rays, query, 20).split()
        return int(count) / float(processor) * 1e9, int(hits)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", default="480x270", help="of the picture, pixels")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--out", type=pathlib.Path, help="raw results")
    arguments = parser.parse_args()
    results = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        glanz = Glanz(folder, arguments.size.split("x"))
        face = face_of(json.loads((folder / "spline.json").read_text()))
        sides = {"face": face_hits(face), "shape, nearest": shape_hits(face)}
        for rays in ("tiles", "shuffled"):
            lines = lines_of(folder / rays)
            rates = {**{f"Glanz, {query}": [] for query in QUERIES}, **{side: [] for side in sides}}
            hits, overheads = {}, []
            for _ in range(arguments.rounds):
                for query in QUERIES:
                    rate, hits[f"Glanz, {query}"] = glanz.rate(rays, query)
                    rates[f"Glanz, {query}"].append(rate)
                overhead, _ = timed(calls, lines)
                overheads.append(overhead)
                for side, (run, _, _) in sides.items():
                    seconds, hits[side] = timed(run, lines)
                    rates[side].append(len(lines) / (seconds - overhead))
            medians = {side: statistics.median(rate) for side, rate in rates.items()}
            ratios = {side: medians[f"Glanz, {BATCH}"] / medians[side] for side in sides}
            results.append({"rays": rays, "count": len(lines), "rays_per_second": medians, "ratio_of_batch": ratios,
                            "hits": hits, "python_seconds": overheads, "each": rates})
            print(f"{rays} {len(lines)}:", *(f"{side} {rate:.4g}/s" for side, rate in medians.items()),
                  *(f"ratio to {side} {ratio:.1f}" for side, ratio in ratios.items()),
                  f"| Python {statistics.median(overheads) / len(lines) * 1e9:.0f} ns per ray | hits {hits}", flush=True)
        _, perform, parameter = sides["face"]
        found = array.array("f")
        for line in lines_of(folder / "coherent"):
            perform(line, 0.0, FAR)
            found.append(parameter())
        (folder / "t").write_bytes(found.tobytes())
        difference = json.loads(glanz.say("coherent", "compare", 1))
        print(difference)
    if arguments.out:
        about = {"date": time.strftime("%Y-%m-%d"), "machine": platform.platform(), "difference": difference, "results": results}
        arguments.out.write_text(json.dumps(about, indent=1) + "\n")


main()

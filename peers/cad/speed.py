#!/usr/bin/env python3
"""From a STEP file to a picture: Glanz, and OpenCascade's meshing with Embree, in one run; time and memory.

    apt-get install libembree-dev gcc     # Embree 3.13
    VENV/bin/pip install cadquery-ocp numpy
    VENV/bin/python peers/cad/speed.py FILE.step ... [--glanz target/release/glanz] [--rounds 3] [--threads 2]
                                       [--out benches/results/NAME.json]

Each step runs in a process of its own, `rounds` times in turn with the others; medians of wall-clock and processor time, and peak
resident memory (MB of 10^6 bytes) of OpenCascade less that of the same process before its work (interpreter and libraries).

    read        OpenCascade reads the file and transfers it to shapes
    mesh        BRepMesh_IncrementalMesh after that, deflection 1e-4 of the size (diagonal of the bounds), absolute, angle 0.5 rad,
                with one thread and in parallel; memory includes reading, as the shape is needed
    Embree      building the hierarchy of those triangles (vertices shared within 1e-7 of the size), and 1280 x 720 rays of a camera,
                traced 16 times, one by one and in packets of 16. The camera looks at the middle of the bounds as the studio of
                Glanz does by default. Memory: Embree's own count with buffers. Converting the triangles is not timed, nor is any
                shading: this favours Embree
    Glanz       GLANZ render FILE -o PICTURE --size 1280x720 --spp 16 --json: `all` is the whole program, `render` the time that it reports
                for its loop (with light and shading). `first pixels` is the whole program for 16 x 9 pixels of one sample: reading,
                building, and hardly more. `one plane` is the same program for a scene of one plane, with the same picture: the
                program, its libraries and threads, as what is subtracted from OpenCascade's memory

`ratio` is read + mesh + building of Embree over the first pixels of Glanz, from which no time is subtracted, and the memory of meshing
plus Embree's over that of Glanz for its first pixels: `memory` less that of one plane, which is like with like, and `whole` without
subtraction.
"""

import argparse
import json
import math
import os
import pathlib
import platform
import statistics
import struct
import subprocess
import sys
import tempfile
import time

import numpy

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from sides import Side

PLANE = """
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective"
WorldBegin
LightSource "infinite"
Shape "disk"
"""

DEFLECTION = 1e-4
ANGLE = 0.5
WIDTH, HEIGHT, SAMPLES = 1280, 720, 16
FIELD = math.radians(30)
WELD = 1e-7


class Stopwatch:
    def __enter__(self):
        self.start = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_):
        self.wall, self.processor = time.perf_counter() - self.start[0], time.process_time() - self.start[1]

    def result(self):
        return {"wall": self.wall, "processor": self.processor}


def peak():
    """Peak resident memory of this process; that of `getrusage` includes its parent's before `exec`."""
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def size_of(shape):
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    return math.sqrt(box.SquareExtent())


def triangles_of(shape):
    """Corners (n, 3, 3) of all triangles, mm."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    from step import explore
    result = [numpy.zeros((0, 3, 3))]
    for face in explore(shape, TopAbs_FACE):
        place = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(TopoDS.Face(face), place)
        if mesh is None:
            continue
        move = place.Transformation()
        nodes = (mesh.Node(i).Transformed(move) for i in range(1, mesh.NbNodes() + 1))
        points = numpy.array([(p.X(), p.Y(), p.Z()) for p in nodes])
        corners = numpy.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]) - 1
        result.append(points[corners])
    return numpy.concatenate(result)


def occ_phase(path, parallel, out):
    """Reads, and meshes unless `parallel` is None; in a process of its own. Triangles go to `out`."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.STEPControl import STEPControl_Reader
    before = peak()
    with Stopwatch() as read:
        reader = STEPControl_Reader()
        reader.ReadFile(str(path))
        reader.TransferRoots()
        shape = reader.OneShape()
    result = {"read": read.result()}
    if parallel is not None:
        size = size_of(shape)
        with Stopwatch() as mesh:
            BRepMesh_IncrementalMesh(shape, DEFLECTION * size, False, ANGLE, parallel)
        result["mesh"] = mesh.result()
    result["memory"] = peak() - before
    if out:
        numpy.save(out, triangles_of(shape))
    return result


def write_mesh(folder, triangles):
    """Files for the program of Embree; returns the bounds."""
    points = triangles.reshape(-1, 3)
    low, high = points.min(0), points.max(0)
    cells = numpy.round((points - low) / (WELD * numpy.linalg.norm(high - low))).astype(numpy.int64)
    _, first, corners = numpy.unique(cells, axis=0, return_index=True, return_inverse=True)
    vertices = points[first].astype(numpy.float32)
    (folder / "mesh").write_bytes(struct.pack("<II", len(vertices), len(triangles)) + vertices.tobytes()
                                  + corners.astype(numpy.uint32).tobytes())
    # The program reads normals, which no query here uses.
    (folder / "normals").write_bytes(numpy.zeros_like(vertices).tobytes())
    return low, high


def write_camera(folder, low, high):
    """Rays through the centres of the pixels: three quarters from the front, above; the bounds fill the picture."""
    centre, radius = (low + high) / 2, numpy.linalg.norm(high - low) / 2
    forward = numpy.array([-1.0, 1.5, -0.9])
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, [0, 0, 1])
    right /= numpy.linalg.norm(right)
    up = numpy.cross(right, forward)
    eye = centre - forward * radius / math.sin(FIELD / 2)
    x, y = numpy.meshgrid(2 * (numpy.arange(WIDTH) + 0.5) / WIDTH - 1, 1 - 2 * (numpy.arange(HEIGHT) + 0.5) / HEIGHT)
    scale = math.tan(FIELD / 2)
    directions = forward + scale * (x[..., None] * right * WIDTH / HEIGHT + y[..., None] * up)
    directions /= numpy.linalg.norm(directions, axis=2, keepdims=True)
    rays = numpy.concatenate([numpy.broadcast_to(eye, directions.shape), directions], axis=2).astype(numpy.float32)
    (folder / "camera").write_bytes(struct.pack("<I", WIDTH * HEIGHT) + rays.tobytes())


def run_phase(path, phase, out=None):
    command = [sys.executable, __file__, path, "--phase", phase] + (["--triangles", out] if out else [])
    return json.loads(subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()[-1])


def run_embree(side, threads):
    """Seconds of building and of all rays of the picture."""
    build_wall, build_processor, triangles, _, memory = side.ask("mesh", "build", threads)
    result = {"build": {"wall": build_wall / 1e9, "processor": build_processor / 1e9}, "triangles": triangles, "memory": memory}
    for name, query in (("trace", "closest"), ("trace packets", "closest16coherent")):
        answers = [side.ask("camera", query, threads) for _ in range(SAMPLES)]
        result[name] = {"wall": sum(a[0] for a in answers) / 1e9, "processor": sum(a[1] for a in answers) / 1e9}
        result["hits"] = answers[0][3]
    return result


def run_glanz(program, path, folder, threads, size, samples):
    """Times of the program, of its loop as it reports it, and peak memory."""
    command = [program, "render", path, "-o", folder / "glanz.png", "--size", size, "--spp", samples, "--threads", threads, "--json"]
    start = time.perf_counter()
    with open(folder / "glanz.txt", "w") as output:
        process = subprocess.Popen(list(map(str, command)), stdout=output, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    if status:
        raise RuntimeError(f"{program} ended with {os.waitstatus_to_exitcode(status)} for {path}")
    report = json.loads((folder / "glanz.txt").read_text())
    return {"all": {"wall": wall, "processor": usage.ru_utime + usage.ru_stime}, "render": {"wall": report["seconds"]},
            "memory": report["peak_memory_bytes"]}


def medians(runs):
    """Median of every number; numbers of other kinds are those of the first run."""
    first = runs[0]
    if isinstance(first, dict):
        return {key: medians([run[key] for run in runs]) for key in first}
    return statistics.median(runs) if isinstance(first, (int, float)) else first


def measure(path, arguments, program, folder):
    runs = []
    triangles = folder / "triangles.npy"
    run_phase(path, "parallel", triangles)
    corners = numpy.load(triangles)
    if not len(corners):
        print(f"{path.name}: OpenCascade has no triangles")
        return None
    write_camera(folder, *write_mesh(folder, corners))
    del corners
    for _ in range(arguments.rounds):
        run = {"read": run_phase(path, "read"), "mesh": run_phase(path, "single"), "parallel": run_phase(path, "parallel")}
        side = Side("Embree", [program, folder, "fast", arguments.threads, "camera"])
        run["embree"] = run_embree(side, arguments.threads)
        side.end()
        if arguments.glanz:
            run["glanz"] = run_glanz(arguments.glanz, path, folder, arguments.threads, f"{WIDTH}x{HEIGHT}", SAMPLES)
            run["first"] = run_glanz(arguments.glanz, path, folder, arguments.threads, "16x9", 1)
            (folder / "plane.pbrt").write_text(PLANE)
            run["plane"] = run_glanz(arguments.glanz, folder / "plane.pbrt", folder, arguments.threads, "16x9", 1)
        runs.append(run)
    return {"file": path.name, "bytes": path.stat().st_size, "median": medians(runs), "each": runs}


def rows(result):
    """Steps with wall-clock seconds, processor seconds and memory in MB."""
    m = result["median"]
    embree = m["embree"]
    yield "read", m["read"]["read"], m["read"]["memory"]
    yield "mesh, one thread", m["mesh"]["mesh"], m["mesh"]["memory"]
    yield "mesh, parallel", m["parallel"]["mesh"], m["parallel"]["memory"]
    yield f"Embree: build, {embree['triangles']:.0f} triangles", embree["build"], embree["memory"]
    yield "Embree: trace", embree["trace"], None
    yield "Embree: trace in packets", embree["trace packets"], None
    glanz, first, plane = m.get("glanz", {}), m.get("first", {}), m.get("plane", {})
    yield "Glanz: first pixels", first.get("all"), first.get("memory")
    yield "Glanz: one plane", plane.get("all"), plane.get("memory")
    yield "Glanz: first pixels, less one plane", None, first["memory"] - plane["memory"] if first else None
    yield "Glanz: render", glanz.get("render"), None
    yield "Glanz: all", glanz.get("all"), glanz.get("memory")


def show(result):
    print(f"\n{result['file']}, {result['bytes'] / 1e6:.3g} MB\n\n| step | wall, s | processor, s | memory, MB |\n|---|---|---|---|")
    for name, times, memory in rows(result):
        times = times or {}
        cells = [f"{times[key]:.3f}" if key in times else "-" for key in ("wall", "processor")]
        print(f"| {name} | {cells[0]} | {cells[1]} | {f'{memory / 1e6:.0f}' if memory else '-'} |")
    m = result["median"]
    if "first" in m:
        for name in ("mesh", "parallel"):
            peers = m["read"]["read"]["wall"] + m[name]["mesh"]["wall"] + m["embree"]["build"]["wall"]
            memory, whole = m[name]["memory"] + m["embree"]["memory"], m["first"]["memory"]
            print(f"ratio ({'one thread' if name == 'mesh' else 'parallel'}): time {peers / m['first']['all']['wall']:.2f}, "
                  f"memory {memory / (whole - m['plane']['memory']):.2f}, whole {memory / whole:.2f}")
    sys.stdout.flush()


def compile_embree(folder):
    program = folder / "embree"
    source = HERE.parent / "embree" / "embree.c"
    subprocess.run(["gcc", "-O3", "-march=native", "-o", program, source, "-lembree3", "-lpthread", "-lm"], check=True)
    return program


def main():
    parser = argparse.ArgumentParser(description="Time and memory from a STEP file to a picture.")
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--glanz", help="the program; without it its rows are empty")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2, help="of Embree and Glanz")
    parser.add_argument("--out", type=pathlib.Path, help="raw results")
    parser.add_argument("--phase", choices=["read", "single", "parallel"], help=argparse.SUPPRESS)
    parser.add_argument("--triangles", type=pathlib.Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.phase:
        parallel = {"read": None, "single": False, "parallel": True}[arguments.phase]
        print(json.dumps(occ_phase(arguments.files[0], parallel, arguments.triangles)))
        return
    results = []
    for path in arguments.files:
        with tempfile.TemporaryDirectory() as name:
            result = measure(path, arguments, compile_embree(pathlib.Path(name)), pathlib.Path(name))
        if result is None:
            continue
        show(result)
        results.append(result)
    if arguments.out:
        about = {"date": time.strftime("%Y-%m-%d"), "machine": platform.platform(), "deflection": DEFLECTION, "angle": ANGLE,
                 "threads": arguments.threads, "rounds": arguments.rounds, "results": results}
        arguments.out.write_text(json.dumps(about, indent=1) + "\n")


if __name__ == "__main__":
    main()

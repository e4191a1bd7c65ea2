#!/usr/bin/env python3
"""Memory of a large triangle mesh: Glanz, and Mitsuba with its usual hierarchies, on the same binary PLY file.

    pip install mitsuba==3.9.1
    cargo build --release && peers/embree/memory.py [--glanz target/release/glanz] [--triangles 8000000]

The mesh is an indexed grid of hills without normals. Mitsuba: growth of the resident memory of Python from before `load_dict` until
after the first ray, and at its peak, for each variant: `scalar_rgb` has its own kd-tree, `llvm_ad_rgb` Embree. Glanz: resident memory
of the program while it renders the mesh, and at its peak; the same for one of two triangles is subtracted. Megabytes of 10^6 bytes.
"""

import argparse
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import time
from array import array

SCENE = """LookAt 1.2 -2.2 1.4  0 0 0  0 0 1
Camera "perspective" "float fov" [50]
Film "rgb" "integer xresolution" [64] "integer yresolution" [64] "string filename" ["out.png"]
Sampler "independent" "integer pixelsamples" [4096]
WorldBegin
LightSource "infinite"
Shape "plymesh" "string filename" ["mesh.ply"]
"""


def write_grid(path, triangles):
    n = max(1, round(math.sqrt(triangles / 2)))
    points, faces = array("f"), bytearray()
    for j in range(n + 1):
        y = 2 * j / n - 1
        for i in range(n + 1):
            x = 2 * i / n - 1
            points.extend((x, y, 0.1 * math.sin(9 * x) * math.cos(7 * y) + 0.01 * math.sin(101 * x + 83 * y)))
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            c = a + n + 1
            faces += struct.pack("<B3iB3i", 3, a, a + 1, c, 3, a + 1, c + 1, c)
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {(n + 1) ** 2}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {2 * n * n}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + points.tobytes() + bytes(faces))
    return 2 * n * n


def status(key, process="self"):
    for line in pathlib.Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith(key):
            return 1024 * int(line.split()[1])
    return 0


def mitsuba(folder, variant):
    """Prints bytes of resident memory: growth until after the first ray, and until the peak."""
    import mitsuba
    mitsuba.set_variant(variant)

    def first_ray(path):
        scene = mitsuba.load_dict({"type": "scene", "shape": {"type": "ply", "filename": str(path)}})
        return scene, str(scene.ray_intersect(mitsuba.Ray3f([0.1, 0.2, 5], [0, 0, -1])).t)

    first_ray(folder / "two.ply")
    before = status("VmRSS")
    scene, _ = first_ray(folder / "mesh.ply")
    print(status("VmRSS") - before, status("VmHWM") - before)


def glanz(program, folder, mesh):
    """Bytes of resident memory while it renders, and at the peak."""
    (folder / "scene.pbrt").write_text(SCENE.replace("mesh.ply", mesh))
    process = subprocess.Popen([program, "render", "scene.pbrt", "-o", "out.png", "-q"], cwd=folder)
    samples, peak = [], 0
    while process.poll() is None:
        samples.append(status("VmRSS", process.pid))
        peak = max(peak, status("VmHWM", process.pid))
        time.sleep(0.01)
    if process.wait() != 0:
        sys.exit(f"{program} failed")
    # Rendering takes most of the time; at the end nothing is left.
    last = sorted(samples[len(samples) * 3 // 5:])
    return last[len(last) // 2], peak


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--glanz", type=pathlib.Path, default=pathlib.Path("target/release/glanz"))
    parser.add_argument("--triangles", type=int, default=8_000_000)
    parser.add_argument("--variants", nargs="+", default=["scalar_rgb", "llvm_ad_rgb"])
    parser.add_argument("--mitsuba", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.mitsuba:
        folder, variant = arguments.mitsuba
        mitsuba(pathlib.Path(folder), variant)
        return
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_grid(folder / "two.ply", 2)
        count = write_grid(folder / "mesh.ply", arguments.triangles)
        program = arguments.glanz.resolve()
        rows = {}
        few, many = (glanz(program, folder, mesh) for mesh in ("two.ply", "mesh.ply"))
        rows["Glanz"] = (many[0] - few[0], many[1] - few[1])
        for variant in arguments.variants:
            child = [sys.executable, __file__, "--mitsuba", str(folder), variant]
            out = subprocess.run(child, check=True, capture_output=True, text=True).stdout
            rows[f"Mitsuba {variant}"] = tuple(int(word) for word in out.split()[-2:])
        for side, (end, most) in rows.items():
            print(f"{side:20} {1e-6 * end:8.0f} MB, {end / count:6.1f} bytes a triangle; peak {1e-6 * most:8.0f} MB")


main()

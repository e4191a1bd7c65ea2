"""Reader of the scenes that glanz.rs exports, and the interface between compare.py and the renderers' programs."""

import argparse
import json
import pathlib
import resource
import sys
import time

import numpy


class Scene:
    """Camera and meshes of a folder written by glanz.rs."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        described = json.loads((self.folder / "scene.json").read_text())
        self.camera_to_world = numpy.array(described["camera_to_world"]).reshape(4, 4).T
        self.field_of_view = described["field_of_view_degrees"]
        self.max_depth = described["max_depth"]
        self.meshes = described["meshes"]

    def arrays(self, mesh):
        """Positions, normals and triangles."""
        data = (self.folder / mesh["file"]).read_bytes()
        header, _, body = data.partition(b"end_header\n")
        words = header.split()
        vertices, faces = (int(words[words.index(name) + 1]) for name in (b"vertex", b"face"))
        points = numpy.frombuffer(body, "<f4", 6 * vertices).reshape(vertices, 6)
        faces = numpy.frombuffer(body, numpy.dtype([("count", "u1"), ("corners", "<i4", 3)]), faces, 24 * vertices)
        return points[:, :3], points[:, 3:], faces["corners"]


def arguments(*more):
    """The command line of a renderer's program: a budget is either seconds or samples per pixel."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("picture", type=pathlib.Path, help="NPY file to write, linear Rec. 709, the top row first")
    parser.add_argument("--size", required=True, help="pixels, such as 320x240")
    budget = parser.add_mutually_exclusive_group(required=True)
    budget.add_argument("--seconds", type=float)
    budget.add_argument("--samples", type=int)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    for name in more:
        parser.add_argument(name, action="store_true")
    # Arguments before "--" are Blender's own.
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    parsed = parser.parse_args(given)
    parsed.width, parsed.height = map(int, parsed.size.split("x"))
    return parsed


class Clock:
    """Wall-clock and processor seconds since its creation."""

    def __init__(self):
        self.start = time.perf_counter(), self.processors()

    @staticmethod
    def processors():
        used = resource.getrusage(resource.RUSAGE_SELF)
        return used.ru_utime + used.ru_stime

    def seconds(self):
        return time.perf_counter() - self.start[0]

    def both(self):
        return self.seconds(), self.processors() - self.start[1]


def report(asked, picture, samples, seconds, version):
    """Writes the picture, and prints its samples, times and version as the last line."""
    numpy.save(asked.picture, numpy.ascontiguousarray(picture[..., :3], dtype=numpy.float32))
    about = {"samples": samples, "seconds": seconds[0], "processor_seconds": seconds[1], "version": version}
    print(json.dumps(about), flush=True)

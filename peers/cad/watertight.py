"""Whether files of triangles are closed: their sides are counted from what was written, without a line of Glanz.

    python3 peers/cad/watertight.py OUT.ply|OUT.obj|OUT.glb ... [--solids REF.json]

A component is a set of triangles that hang together by common vertices; vertices of GLB are joined by their bits. Per file: vertices, triangles,
components, and over all components
  open      sides of triangles that are not traversed as often forwards as backwards
  manifold  sides with more than two triangles
  turned    pairs of triangles that traverse a side the same way
  flat      triangles of area 0 (two equal points, or three on a line)
  folded    sides across which normals turn by more than 150 degrees, of triangles higher than 1e-4 of the size
Volume and area are sums over the file; --solids takes those that peers/cad/glanz.rs or reference.py found for the exact solids (one occurrence
each), and prints the volume's difference divided by the exact area: the mean distance of the triangles from the surface.
"""

import argparse
import json
import struct
from pathlib import Path

import numpy


def ply(data):
    head, body = data.split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in head.split(b"\n") if line.startswith(b"element")]
    points = numpy.frombuffer(body, "<f8", 3 * counts[0]).reshape(-1, 3)
    row = numpy.dtype([("n", "u1"), ("i", "<u4", 3), ("c", "u1", 3)])
    rows = numpy.frombuffer(body, row, counts[1], 24 * counts[0])
    assert (rows["n"] == 3).all() and len(body) == 24 * counts[0] + row.itemsize * counts[1]
    return points, rows["i"].astype(int)


def obj(data):
    lines = [line.split() for line in data.decode().splitlines()]
    points = numpy.array([[float(x) for x in line[1:4]] for line in lines if line[:1] == ["v"]])
    faces = [[int(word.split("/")[0]) - 1 for word in line[1:]] for line in lines if line[:1] == ["f"]]
    return points, numpy.array(faces, int).reshape(-1, 3)


def glb(data):
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length])
    start = 20 + length + 8

    def accessor(number):
        entry = document["accessors"][number]
        view = document["bufferViews"][entry["bufferView"]]
        kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "u1"}[entry["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[entry["type"]]
        offset = start + view.get("byteOffset", 0) + entry.get("byteOffset", 0)
        return numpy.frombuffer(data, kind, entry["count"] * width, offset).reshape(-1, width)

    points, faces, count = [], [], 0

    def visit(number, outer):
        nonlocal count
        node = document["nodes"][number]
        matrix = outer @ numpy.array(node["matrix"]).reshape(4, 4).T if "matrix" in node else outer
        if "mesh" in node:
            # Joined by bits, all primitives of an instance together.
            parts = document["meshes"][node["mesh"]]["primitives"]
            lists = [accessor(part["attributes"]["POSITION"]) for part in parts]
            base = numpy.cumsum([0] + [len(part) for part in lists])
            unique, inverse = numpy.unique(numpy.concatenate(lists) + 0.0, axis=0, return_inverse=True)
            corners = [accessor(part["indices"]).astype(int).reshape(-1, 3) + b for part, b in zip(parts, base)]
            own = inverse.reshape(-1)[numpy.concatenate(corners)]
            faces.append((own[:, ::-1] if numpy.linalg.det(matrix[:3, :3]) < 0 else own) + count)
            points.append(unique.astype(float) @ matrix[:3, :3].T + matrix[:3, 3])
            count += len(unique)
        for child in node.get("children", []):
            visit(child, matrix)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root, numpy.eye(4))
    return numpy.concatenate(points), numpy.concatenate(faces)


def components(count, faces):
    """A number per triangle, by merging the smallest label over each triangle until nothing changes."""
    label = numpy.arange(count)
    while True:
        least = label[faces].min(axis=1)
        before = label.copy()
        for corner in range(3):
            numpy.minimum.at(label, faces[:, corner], least)
        label = label[label]
        if (label == before).all():
            return label[faces[:, 0]]


def measure(points, faces):
    equal = (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    collapsed = int(equal.sum())
    faces = faces[~equal]
    origin = points[faces].reshape(-1, 3).mean(axis=0)
    a, b, c = (points[faces[:, i]] - origin for i in range(3))
    normal = numpy.cross(b - a, c - a)
    double = numpy.linalg.norm(normal, axis=1)
    sides = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner = numpy.repeat(numpy.arange(len(faces)), 3)
    forward = sides[:, 0] < sides[:, 1]
    pairs, number = numpy.unique(numpy.sort(sides, axis=1), axis=0, return_inverse=True)
    number = number.reshape(-1)
    total = numpy.bincount(number, minlength=len(pairs))
    excess = numpy.bincount(number, numpy.where(forward, 1, -1), minlength=len(pairs)).astype(int)
    order = numpy.argsort(number, kind="stable")
    first = numpy.concatenate([[0], numpy.cumsum(total)[:-1]])[total == 2]
    one, other = owner[order[first]], owner[order[first + 1]]
    longest = numpy.max([numpy.linalg.norm(points[faces[:, i]] - points[faces[:, i - 1]], axis=1) for i in range(3)], axis=0)
    size = numpy.linalg.norm(numpy.ptp(points[faces].reshape(-1, 3), axis=0))
    high = double > 1e-4 * size * longest
    cosine = (normal[one] * normal[other]).sum(axis=1) / numpy.maximum(double[one] * double[other], 1e-300)
    folded = (cosine < -0.866) & high[one] & high[other]
    component = components(len(points), faces)
    leaks = numpy.unique(component[owner[order[numpy.isin(number[order], numpy.flatnonzero(excess))]]])
    worst = pairs[numpy.flatnonzero(excess)[:4]]
    return {
        "vertices": len(points),
        "triangles": len(faces),
        "components": len(numpy.unique(component)),
        "leaking": len(leaks),
        "open": int(numpy.abs(excess).sum()),
        "manifold": int((total > 2).sum()),
        "turned": int(((total == 2) & (excess != 0)).sum()),
        "flat": int((double <= 1e-14 * longest**2).sum()) + collapsed,
        "folded": int(folded.sum()),
        "volume": float((a * numpy.cross(b, c)).sum() / 6),
        "area": float(double.sum() / 2),
    }, points[worst], points[pairs[number[order[first]]][folded]] if folded.any() else []


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--solids", type=Path, help="JSON of glanz.rs or reference.py")
    parser.add_argument("--places", action="store_true", help="print points of open and folded sides")
    arguments = parser.parse_args()
    solids = json.loads(arguments.solids.read_text())["solids"] if arguments.solids else []
    for file in arguments.files:
        points, faces = {".ply": ply, ".obj": obj, ".glb": glb}[file.suffix](file.read_bytes())
        found, leaks, folds = measure(points, faces)
        text = " ".join(f"{key} {value:.8g}" if isinstance(value, float) else f"{key} {value}" for key, value in found.items())
        if solids and all(solid["volume"] for solid in solids):
            volume, area = (sum(solid[key] for solid in solids) for key in ("volume", "area"))
            text += f" | exact volume {volume:.8g} area {area:.8g}, mean distance {(found['volume'] - volume) / area * 1e3:.3g} mm"
        print(f"{file.name}: {text}", flush=True)
        if arguments.places:
            for name, list_of in (("open", leaks), ("folded", folds[:8])):
                for ends in list_of:
                    print(f"  {name}", *(numpy.array2string(end, precision=9) for end in ends))


if __name__ == "__main__":
    main()

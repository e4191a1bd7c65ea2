#!/usr/bin/env python3
"""Light maps of Glanz and of Cycles (Blender's bake) against paths, at random points of a furnished room.

    pip install bpy==5.0.1 numpy          # Python 3.11
    cargo build --release && cargo build --release --example bake
    python3 peers/bake/compare.py --out bake.json

Both programs fill the same texels: Cycles bakes the model that `glanz bake` writes, with its texture coordinates, so that texels of both
have the same places, and the light of both is looked up alike, bilinearly. Charts are a hundredth of a texel wider for Cycles, which would
otherwise leave out texels whose middles are on the border. The reference is the irradiance on the exact surfaces, by paths (glanz.rs). Errors are
relative to the irradiance there, or to 1 % of the mean irradiance of all points where that is larger, as is the standard error of the
reference; nothing is capped. Points without light in 4096 paths are left out, and counted where their light map has light. Since
a dark point that is shown bright has thousands of percent, there is also the mean of the errors relative to the larger of both values.
Times are those of the processor: of the whole program `glanz bake`, of the bake alone of Cycles. First the unit of Cycles' bake is checked by
the closed form of a floor beneath a square lamp."""

import argparse
import hashlib
import json
import math
import pathlib
import re
import resource
import struct
import subprocess
import sys
import tempfile

import numpy

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RGB_TO_Y = numpy.array([0.2126390, 0.7151687, 0.0721923])

# Errors above this are counted; smallest light that errors are relative to, in means of all points; and by how many texels charts are widened.
LARGE = 0.08
FLOOR = 0.01
NUDGE = 0.01

# From scenes to models with z up; models of scenes that are shown mirrored are mirrored, too.
AXES = [numpy.array([[sign, 0, 0], [0, 0, 1], [0, -1, 0]], float) for sign in (1, -1)]


def run(command, **options):
    """The output of a program and its processor seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True, **options).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return told, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def scene_text(scene):
    """Text of a scene and the files that it includes."""
    text = scene.read_text()
    for name in re.findall(r'Include "([^"]+)"', text):
        text += (scene.parent / name).read_text()
    return text


def colours(scene):
    """Colours of named materials of a scene, and the cells of those that are checkerboards."""
    text = scene_text(scene)
    three = r"\[ *([\d.]+) +([\d.]+) +([\d.]+) *\]"
    boards = {}
    for name, u, v, rest in re.findall(r'Texture "(\w+)" "spectrum" "checkerboard" "float uscale" (\d+) "float vscale" (\d+)([^T]+)', text):
        boards[name] = [tuple(map(float, c)) for c in re.findall(three, rest)[:2]], (int(u), int(v))
    made = {}
    for name, rest in re.findall(r'MakeNamedMaterial "([^"]+)"(.*)', text):
        texture = re.search(r'"texture reflectance" "(\w+)"', rest)
        one = re.search(three, rest)
        if texture:
            made[name] = boards[texture[1]]
        elif one:
            made[name] = [tuple(map(float, one.groups()))], (1, 1)
    return made


class Part:
    """Triangles of one shape of a model, on one page or none."""

    def __init__(self, document, body, node, primitive):
        def values(number, columns):
            accessor = document["accessors"][number]
            view = document["bufferViews"][accessor["bufferView"]]
            kind = {5126: "<f4", 5125: "<u4", 5123: "<u2"}[accessor["componentType"]]
            start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            return numpy.frombuffer(body, kind, columns * accessor["count"], start).reshape(-1, columns)

        attributes = primitive["attributes"]
        self.material, _, number = node["name"].rpartition(" ")
        self.shape = int(number)
        self.positions = values(attributes["POSITION"], 3).astype(float)
        self.normals = values(attributes["NORMAL"], 3).astype(float)
        self.parameters = values(attributes["TEXCOORD_0"], 2).astype(float)
        self.triangles = values(primitive["indices"], 1).astype(int).reshape(-1, 3)
        self.is_lit = "TEXCOORD_1" in attributes
        self.texels = values(attributes["TEXCOORD_1"], 2).astype(float) if self.is_lit else numpy.zeros((len(self.positions), 2))
        # Of the front of each triangle.
        self.radiance = numpy.zeros((len(self.triangles), 3))

    def widened(self, side):
        """Texture coordinates with charts that are wider by a part of a texel at each end."""
        label = numpy.arange(len(self.positions))
        while True:
            least = label[self.triangles].min(axis=1)
            before = label.copy()
            for corner in self.triangles.T:
                numpy.minimum.at(label, corner, least)
            label = label[label]
            if (label == before).all():
                break
        low, high = (numpy.full((len(label), 2), x) for x in (numpy.inf, -numpy.inf))
        numpy.minimum.at(low, label, self.texels)
        numpy.maximum.at(high, label, self.texels)
        middle, half = (low[label] + high[label]) / 2, (high[label] - low[label]) / 2
        return middle + (self.texels - middle) * (1 + NUDGE / side / numpy.maximum(half, 0.5 / side))


def read_model(path):
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    document, body = json.loads(data[20:20 + length]), data[28 + length:]
    nodes = [node for node in document["nodes"] if "mesh" in node]
    return [Part(document, body, node, p) for node in nodes for p in document["meshes"][node["mesh"]]["primitives"]]


def mark_lamps(parts, lamps, axes):
    """Gives the triangles that lie on lamps their radiance. `axes`: from the scene to the model."""
    if not lamps:
        sys.exit("no surface of the scene emits light; Cycles gets the light of flat patches only")
    curved = sum(not lamp["flat"] for lamp in lamps)
    if curved:
        sys.exit(f"{curved} of {len(lamps)} lamps are no flat patches; Cycles gets the light of flat patches only")
    for lamp in lamps:
        corners = numpy.array(lamp["corners"]) @ axes.T
        low, high = corners.min(axis=0) - 1e-3, corners.max(axis=0) + 1e-3
        for side in lamp["sides"]:
            normal = axes @ side["normal"]
            for part in parts:
                inside = ((part.positions >= low) & (part.positions <= high)).all(axis=1) & (part.normals @ normal > 0.9)
                part.radiance[inside[part.triangles].all(axis=1)] = side["radiance"]


def put(parts, palette, side, path):
    """Writes the model that bake_cycles.py reads."""
    looks, triangles, first = {}, [], 0
    for part in parts:
        look = [looks.setdefault((part.material, tuple(radiance)), len(looks)) for radiance in part.radiance.tolist()]
        triangles.append((part.triangles + first, look, numpy.full(len(part.triangles), part.is_lit)))
        first += len(part.positions)
    described = [{"name": name, "colours": palette[name][0], "fields": palette[name][1], "radiance": radiance}
                 for name, radiance in looks]
    joined = [numpy.concatenate(column) for column in zip(*triangles)]
    vertices = {name: numpy.concatenate([getattr(part, name) for part in parts]).astype(numpy.float32)
                for name in ("positions", "normals", "parameters")}
    texels = numpy.concatenate([part.widened(side) if part.is_lit else part.texels for part in parts]).astype(numpy.float32)
    numpy.savez(path, triangles=joined[0], materials=joined[1], lit=joined[2], texels=texels,
                described=json.dumps(described), **vertices)


def cycles(model, folder, side, samples, asked):
    out = folder / "cycles.npy"
    told, _ = run([sys.executable, HERE / "bake_cycles.py", model, out, side, samples, asked.seed, asked.threads])
    return numpy.load(out), json.loads(told.strip().splitlines()[-1])


def places(parts, points, axes):
    """Coordinates on the page of the points: of the nearest triangle of their shape that has their normal; and their distance from it, metres."""
    found, away = numpy.full((len(points), 2), numpy.nan), numpy.full(len(points), numpy.inf)
    for i, point in enumerate(points):
        at, normal = axes @ point["position"], axes @ point["normal"]
        for part in parts:
            if part.shape != point["shape"] or not part.is_lit:
                continue
            corners = part.triangles[(part.normals[part.triangles] @ normal).mean(axis=1) > 0.5]
            if not len(corners):
                continue
            a, b, c = (part.positions[corners[:, k]] for k in range(3))
            e, f, g = b - a, c - a, at - a
            ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
            eg, fg = (e * g).sum(1), (f * g).sum(1)
            area = numpy.maximum(ee * ff - ef * ef, 1e-300)
            shares = numpy.stack([(ff * eg - ef * fg) / area, (ee * fg - ef * eg) / area], 1).clip(0, 1)
            shares /= numpy.maximum(shares.sum(1, keepdims=True), 1)
            distance = numpy.linalg.norm(a + shares[:, :1] * e + shares[:, 1:] * f - at, axis=1)
            best = distance.argmin()
            if distance[best] < away[i]:
                away[i] = distance[best]
                u, v, w = part.texels[corners[best]]
                found[i] = u + shares[best, 0] * (v - u) + shares[best, 1] * (w - u)
    return found, away


def looked_up(page, coordinates):
    """Luminance, bilinear between texels."""
    side = len(page)
    page = page @ RGB_TO_Y
    at = numpy.nan_to_num(coordinates) * side - 0.5
    low = numpy.floor(at).astype(int)
    x, y = (at - low).T
    i, j = low.T.clip(0, side - 2)
    return (page[j, i] * (1 - x) + page[j, i + 1] * x) * (1 - y) + (page[j + 1, i] * (1 - x) + page[j + 1, i + 1] * x) * y


def summary(light, points):
    true = numpy.array([point["irradiance"] for point in points])
    curved = numpy.array([point["curved"] for point in points])
    floor = FLOOR * true.mean()
    error = abs(light - true) / numpy.maximum(true, floor)
    of_larger = abs(light - true) / numpy.maximum(numpy.maximum(true, light), floor)
    rows = {}
    for name, chosen in (("all", curved | True), ("flat", ~curved), ("curved", curved)):
        e = error[chosen]
        rows[name] = {"points": int(chosen.sum()), "mean": e.mean(), "mean_of_larger": of_larger[chosen].mean(), "median": numpy.median(e),
                      "quantile_95": numpy.quantile(e, 0.95), "share_within": (e <= LARGE).mean(), "largest": e.max(),
                      "bias": light[chosen].sum() / true[chosen].sum() - 1,
                      "of_mean_light": abs(light - true)[chosen].mean() / true.mean()}
    worst = [{**{key: points[i][key] for key in ("kind", "shape", "position", "irradiance", "deviation")},
              "light": light[i], "error": error[i]} for i in error.argsort()[::-1][:12]]
    return {"of": rows, "worst": worst}


def show(name, found, seconds):
    for kind, row in found["of"].items():
        print(f"{name:24} {kind:6} {row['points']:5d} points: mean {row['mean']:7.2%}, of the larger {row['mean_of_larger']:6.2%}, median {row['median']:6.2%}, 95 % within "
              f"{row['quantile_95']:7.2%}, {row['share_within']:6.1%} within {LARGE:.0%}, largest {row['largest']:8.1%}, "
              f"all light {row['bias']:+.2%}; {seconds:.1f} s", flush=True)


def check_unit(folder, asked):
    """Irradiance of Cycles and of the closed form in the middle of a floor that a parallel square lamp lights."""
    half, height, radiance, side = 0.5, 1.0, 3.0, 64
    floor = numpy.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], float)
    lamp = numpy.array([[-half, height, -half], [half, height, -half], [half, height, half], [-half, height, half]])
    corners = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    up = numpy.array([[0.0, 1, 0]] * 4)
    numpy.savez(folder / "unit.npz", positions=numpy.concatenate([floor, lamp]), normals=numpy.concatenate([up, -up]),
                parameters=numpy.concatenate([corners] * 2), texels=numpy.concatenate([corners] * 2),
                triangles=numpy.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]), materials=numpy.array([0, 0, 1, 1]),
                lit=numpy.array([True, True, False, False]), described=json.dumps([
                    {"name": "floor", "colours": [[0.5] * 3], "fields": [1, 1], "radiance": [0, 0, 0]},
                    {"name": "lamp", "colours": [[0.0] * 3], "fields": [1, 1], "radiance": [radiance] * 3}]))
    page, _ = cycles(folder / "unit.npz", folder, side, 1024, asked)
    # Four quarters, each with a corner above the point (the form factor to a parallel rectangle).
    a = half / height
    quarter = 2 * a / math.hypot(1, a) * math.atan(a / math.hypot(1, a)) / (2 * math.pi)
    true = 4 * quarter * math.pi * radiance
    found = page[side // 2 - 1:side // 2 + 1, side // 2 - 1:side // 2 + 1].mean()
    print(f"Cycles beneath a square lamp: {found:.4f}, closed form {true:.4f}: {found / true - 1:+.2%}", flush=True)
    if abs(found / true - 1) > 0.01:
        sys.exit("the unit of Cycles' bake is not the expected one")
    return {"cycles": float(found), "closed_form": true}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=pathlib.Path, default=ROOT / "scenes/rooms/furnished.pbrt")
    parser.add_argument("--glanz", type=pathlib.Path, default=ROOT / "target/release/glanz")
    parser.add_argument("--points-program", type=pathlib.Path, default=ROOT / "target/release/examples/bake")
    parser.add_argument("--density", type=float, nargs="+", default=[45], help="texels per metre; those of Cycles are the first")
    parser.add_argument("--rays", type=int, default=512, help="of `glanz bake`")
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--reference-error", type=float, default=0.004, help="standard error of a point")
    parser.add_argument("--reference-samples", type=int, default=1 << 18, help="largest number of paths of a point")
    parser.add_argument("--cycles-samples", type=int, nargs="*", default=[16, 64, 256, 1024])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--folder", type=pathlib.Path, help="keep files there, in a folder for each scene and its settings, and use the bakes and points that it has; after a change of the programs, give another one")
    parser.add_argument("--out", type=pathlib.Path, help="JSON file of the results")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        settings = [scene_text(asked.scene), float(asked.density[0]), asked.rays, asked.points, asked.reference_error, asked.reference_samples]
        key = hashlib.sha256(json.dumps(settings).encode()).hexdigest()[:16]
        folder = (asked.folder or pathlib.Path(temporary)) / key
        folder.mkdir(parents=True, exist_ok=True)
        compare(asked, folder)


def compare(asked, folder):
    results = {"settings": {key: str(value) for key, value in vars(asked).items()}}
    baked = {}
    for density in asked.density:
        model = folder / f"glanz-{density:g}.glb"
        told = model.with_suffix(".json")
        if not told.exists():
            _, seconds = run([asked.glanz, "bake", asked.scene, "-o", model, "--texels-per-metre", density, "--rays", asked.rays,
                              "--checkpoint", model.with_suffix(".light"), "--threads", asked.threads])
            told.write_text(json.dumps({"processor_seconds": seconds}))
        baked[density] = model, json.loads(told.read_text())["processor_seconds"]
    first, seconds_of_first = baked[asked.density[0]]
    file = folder / "points.json"
    if not file.exists():
        told, seconds = run([asked.points_program, asked.scene, first.with_suffix(".light"), asked.density[0], asked.rays, asked.points,
                             asked.reference_error, asked.reference_samples])
        file.write_text(told)
        print(f"points: {seconds:.0f} s")
    found = json.loads(file.read_text())
    points = found["points"]
    true, deviation = (numpy.array([p[name] for p in points]) for name in ("irradiance", "deviation"))
    print(f"{len(points)} points, {found['covered']} beside them covered")
    results["reference"] = {"covered": found["covered"]}
    for name, light in (("the irradiance", true), (f"the irradiance or {FLOOR:.0%} of its mean", numpy.maximum(true, FLOOR * true.mean()))):
        relative = deviation / light
        print(f"standard error of the reference, relative to {name}: {relative.mean():.2%} on average, "
              f"{numpy.quantile(relative, 0.95):.2%} for 95 %, at most {relative.max():.2%}")
        results["reference"][f"relative to {name}"] = {"mean": relative.mean(), "quantile_95": numpy.quantile(relative, 0.95),
                                                       "largest": relative.max()}
    results["glanz"] = {}
    for density, (model, seconds) in reversed(baked.items()):
        parts, page = read_model(model), read_exr(model.with_suffix(".exr"))
        axes, (coordinates, away) = min(((a, places(parts, points, a)) for a in AXES), key=lambda c: numpy.median(c[1][1]))
        lost = int(numpy.isinf(away).sum())
        if lost:
            sys.exit(f"{lost} of {len(points)} points are on no triangle with a light map at {density:g} texels per metre")
        print(f"points are at most {away.max() * 1e3:.2f} mm from the triangles")
        results["glanz"][density] = {**summary(looked_up(page, coordinates), points), "processor_seconds": seconds}
        show(f"glanz, {density:g} texels/m", results["glanz"][density], seconds)
    exact = numpy.array([p["glanz"] for p in points])
    own = summary(exact, points)
    results["glanz_on_surface"] = own
    show("glanz, exact surfaces", own, seconds_of_first)
    for worst in own["worst"]:
        at = ", ".join(f"{x:.3f}" for x in worst["position"])
        print(f"  {worst['error']:7.1%} {worst['kind']} {worst['shape']} ({at}): {worst['light']:.4f}, paths {worst['irradiance']:.4f} +- {worst['deviation']:.4f}")
    if asked.cycles_samples:
        results["unit"] = check_unit(folder, asked)
        mark_lamps(parts, found["lamps"], axes)
        emitting = sum(int((part.radiance > 0).any(axis=1).sum()) for part in parts)
        if not emitting:
            sys.exit("no triangle of the model lies on a lamp")
        print(f"{emitting} triangles emit light")
        side = len(page)
        put(parts, colours(asked.scene), side, folder / "model.npz")
        results["cycles"] = {}
        for samples in asked.cycles_samples:
            page, told = cycles(folder / "model.npz", folder, side, samples, asked)
            numpy.save(folder / f"cycles-{samples}.npy", page)
            results["cycles"][samples] = {**summary(looked_up(page, coordinates), points), **told}
            show(f"cycles, {samples} samples", results["cycles"][samples], told["processor_seconds"])
        if len(asked.cycles_samples) > 1:
            results["equal"] = equal_error(own["of"]["all"], results["cycles"], seconds_of_first)
    if asked.out:
        asked.out.write_text(json.dumps(results, indent=1))


def equal_error(of_glanz, cycles, seconds):
    """Processor time of Cycles at the errors of Glanz: its own squared is that of noise, in inverse proportion to the samples, and what remains
    with any number of them, both from the two largest numbers."""
    (few, a), (many, b) = sorted(cycles.items())[-2:]
    per_sample, found = b["processor_seconds"] / many, {}
    for name in ("median", "of_mean_light"):
        goal, x, y = (of[name] for of in (of_glanz, a["of"]["all"], b["of"]["all"]))
        noise = max(x ** 2 - y ** 2, 0) / (1 / few - 1 / many)
        rest = max(y ** 2 - noise / many, 0)
        at_least = y ** 2 * many / goal ** 2 * per_sample
        found[name] = {"goal": goal, "remaining": math.sqrt(rest), "seconds_if_nothing_remained": at_least}
        if goal ** 2 > rest:
            found[name]["seconds"] = noise / (goal ** 2 - rest) * per_sample
        told = f"{found[name]['seconds']:.0f} s" if "seconds" in found[name] else "never"
        print(f"Cycles at the error of Glanz ({name}, {goal:.2%} after {seconds:.0f} s): {told}, {math.sqrt(rest):.2%} remain with any number of "
              f"samples; {at_least:.0f} s if nothing remained")
    return found


def read_exr(path):
    import bpy
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    values = numpy.empty(4 * image.size[0] * image.size[1], dtype=numpy.float32)
    image.pixels.foreach_get(values)
    # The first row of the file is the last of Blender's.
    return values.reshape(image.size[1], image.size[0], 4)[::-1, :, :3].astype(float)


if __name__ == "__main__":
    main()

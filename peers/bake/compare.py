#!/usr/bin/env python3
"""Light maps of Glanz and of Cycles (Blender's bake) against paths, at random points of a furnished room.

    pip install bpy==5.0.1 numpy          # Python 3.11
    cargo build --release && cargo build --release --example bake
    python3 peers/bake/compare.py --out bake.json

Both programs fill the same texels: Cycles bakes the model that `glanz bake` writes, with its texture coordinates, so that texels of both
have the same places, and the light of both is interpolated alike, bilinearly. Charts are a hundredth of a texel wider for Cycles, which would
otherwise leave out texels whose middles are on the border. The reference is the irradiance on the exact surfaces, by paths (glanz.rs). Errors are
relative to the irradiance there, or to 1 % of the mean irradiance of all points where that is larger, as is the standard error of the
reference; nothing is capped. Points without light in 4096 paths are left out, and counted where their light map has light. Since
a dark point that is shown bright has thousands of percent, there is also the mean of the errors relative to the larger of both values.
Charts without light have no texels: there the light of both is 0. Cycles gets flat lamps and diffuse materials only.
Times are those of the processor: of the whole program `glanz bake`, of the bake alone of Cycles. First the unit of Cycles' bake is checked by
the closed form of a floor beneath a square lamp."""

import argparse
import hashlib
import json
import math
import pathlib
import re
import resource
import shutil
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

# Largest distance of triangles from their surface, and of points from their triangles, metres.
TOLERANCE = 0.001
FARTHEST = 0.005

# Rotations from a scene, where z is up, to its model, where y is up. If the camera mirrors the scene, the model is mirrored, too.
AXES = [numpy.array([[sign, 0, 0], [0, 0, 1], [0, -1, 0]], float) for sign in (1, -1)]

WITHOUT_CYCLES = "--cycles-samples without numbers leaves Cycles out"


def run(command, **options):
    """The output of a program and its processor seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    output = subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True, **options).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return output, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def replace_text(path, text):
    """Writes a file whole or not at all."""
    part = path.with_name(f"{path.name}.part")
    part.write_text(text)
    part.replace(path)


def scene_text(file, including=()):
    """Text of a scene with the files that it includes, and those that they include. `including`: the files around it, the scene first."""
    files = (*including, file)
    if len(files) > 100:
        sys.exit(f"{file}: files are included more than 100 deep")

    def included(match):
        paths = [folder / match[1] for folder in (files[0].parent, file.parent, files[0].parent.parent)]
        path = next((path for path in paths if path.is_file()), None)
        if path is None:
            sys.exit(f"{file}: the included file {match[1]} is not there; names are relative to the folder of the scene file")
        return scene_text(path, files)

    return re.sub(r'^[ \t]*(?:Include|Import)\s+"([^"]+)"', included, file.read_text(), flags=re.MULTILINE)


def colours(scene):
    """Colours of named materials of a scene, and the cells of those that are checkerboards."""
    text = scene_text(scene)
    three = r"\[ *([\d.]+) +([\d.]+) +([\d.]+) *\]"
    boards = {}
    for name, u, v, rest in re.findall(r'Texture "(\w+)" "spectrum" "checkerboard" "float uscale" (\d+) "float vscale" (\d+)([^T]+)', text):
        boards[name] = [tuple(map(float, c)) for c in re.findall(three, rest)[:2]], (int(u), int(v))
    materials = {}
    for name, rest in re.findall(r'MakeNamedMaterial "([^"]+)"(.*)', text):
        if not re.search(r'"string type"\s+\[?\s*"diffuse"', rest):
            continue
        texture = re.search(r'"texture reflectance" "(\w+)"', rest)
        one = re.search(three, rest)
        if texture and texture[1] in boards:
            materials[name] = boards[texture[1]]
        elif one and not texture:
            materials[name] = [tuple(map(float, one.groups()))], (1, 1)
    return materials


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
    pages = len(document.get("images", []))
    if pages != 1:
        sys.exit(f"{path}: the light maps fill {pages} pages instead of one; " + ("lower the density" if pages else "no surface has light"))
    nodes = [node for node in document["nodes"] if "mesh" in node]
    return [Part(document, body, node, p) for node in nodes for p in document["meshes"][node["mesh"]]["primitives"]]


def mark_lamps(parts, reference, axes):
    """Gives the triangles of lamps their radiance. `axes`: from the scene to the model."""
    lamps, others = reference["lamps"], reference["other_lights"]
    if others:
        sys.exit(f"the scene has lights of the kinds {', '.join(others)}; Cycles gets the light of flat patches only; {WITHOUT_CYCLES}")
    if not lamps:
        sys.exit(f"no surface of the scene emits light; Cycles gets the light of flat patches only; {WITHOUT_CYCLES}")
    curved = sum(not lamp["flat"] for lamp in lamps)
    if curved:
        sys.exit(f"{curved} of {len(lamps)} lamps are no flat patches; Cycles gets the light of flat patches only; {WITHOUT_CYCLES}")
    if len({lamp["shape"] for lamp in lamps}) < len(lamps):
        sys.exit(f"lamps are copies of one shape, which the model does not tell apart; {WITHOUT_CYCLES}")
    for lamp in lamps:
        for side in lamp["sides"]:
            if max(side["radiance"]) <= 0:
                continue
            normal, count = axes @ side["normal"], 0
            for part in (part for part in parts if part.shape == lamp["shape"]):
                chosen = (part.normals[part.triangles] @ normal > 0.9).all(axis=1)
                part.radiance[chosen] = side["radiance"]
                count += chosen.sum()
            if not count:
                sys.exit(f"the model has no triangle of the lamp that is shape {lamp['shape']}, on the side that emits light; {WITHOUT_CYCLES}")
    emitting = sum(int((part.radiance > 0).any(axis=1).sum()) for part in parts)
    print(f"{emitting} triangles emit light")


def write_model(parts, palette, side, path):
    """Writes the model that bake_cycles.py reads."""
    unknown = sorted({part.material for part in parts} - palette.keys())
    if unknown:
        sys.exit(f"the colour of these materials is not known: {', '.join(unknown)}; Cycles gets named materials with an \"rgb reflectance\" or a "
                 f"checkerboard only; {WITHOUT_CYCLES}")
    material_numbers, triangles, first = {}, [], 0
    for part in parts:
        numbers = [material_numbers.setdefault((part.material, tuple(radiance)), len(material_numbers)) for radiance in part.radiance.tolist()]
        triangles.append((part.triangles + first, numbers, numpy.full(len(part.triangles), part.is_lit)))
        first += len(part.positions)
    described = [{"name": name, "colours": palette[name][0], "fields": palette[name][1], "radiance": radiance}
                 for name, radiance in material_numbers]
    joined = [numpy.concatenate(column) for column in zip(*triangles)]
    vertices = {name: numpy.concatenate([getattr(part, name) for part in parts]).astype(numpy.float32)
                for name in ("positions", "normals", "parameters")}
    texels = numpy.concatenate([part.widened(side) if part.is_lit else part.texels for part in parts]).astype(numpy.float32)
    numpy.savez(path, triangles=joined[0], materials=joined[1], lit=joined[2], texels=texels,
                described=json.dumps(described), **vertices)


def cycles(model, folder, side, samples, arguments):
    page = folder / "cycles.npy"
    output, _ = run([sys.executable, HERE / "bake_cycles.py", model, page, side, samples, arguments.seed, arguments.threads])
    return numpy.load(page), json.loads(output.strip().splitlines()[-1])


def locate(parts, points, axes):
    """Coordinates of the points on the page, NaN on charts without light, and their distance from the model, metres.

    Both are of the nearest triangle of their shape that has their normal. Where charts with and without light meet, the one that the point is
    on wins."""
    coordinates, distances = numpy.full((len(points), 2), numpy.nan), numpy.full(len(points), numpy.inf)
    of_shapes = {}
    for part in parts:
        of_shapes.setdefault(part.shape, []).append(part)
    for i, point in enumerate(points):
        position, normal = axes @ point["position"], axes @ point["normal"]
        nearest = numpy.inf
        for part in of_shapes.get(point["shape"], []):
            corners = part.triangles[(part.normals[part.triangles] @ normal).mean(axis=1) > 0.5]
            if not len(corners):
                continue
            a, b, c = (part.positions[corners[:, k]] for k in range(3))
            e, f, g = b - a, c - a, position - a
            ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
            eg, fg = (e * g).sum(1), (f * g).sum(1)
            area = numpy.maximum(ee * ff - ef * ef, 1e-300)
            shares = numpy.stack([(ff * eg - ef * fg) / area, (ee * fg - ef * eg) / area], 1).clip(0, 1)
            shares /= numpy.maximum(shares.sum(1, keepdims=True), 1)
            distance = numpy.linalg.norm(a + shares[:, :1] * e + shares[:, 1:] * f - position, axis=1)
            best = distance.argmin()
            compared = distance[best] + (0 if part.is_lit == point["lit"] else TOLERANCE)
            if compared < nearest:
                nearest, distances[i] = compared, distance[best]
                u, v, w = part.texels[corners[best]]
                coordinates[i] = u + shares[best, 0] * (v - u) + shares[best, 1] * (w - u) if part.is_lit else numpy.nan
    return coordinates, distances


def bilinear(page, coordinates):
    """Luminance, bilinear between texels; 0 where the coordinates are NaN."""
    side = len(page)
    page = page @ RGB_TO_Y
    texels = numpy.nan_to_num(coordinates) * side - 0.5
    low = numpy.floor(texels).astype(int)
    x, y = (texels - low).T
    i, j = low.T.clip(0, side - 2)
    light = (page[j, i] * (1 - x) + page[j, i + 1] * x) * (1 - y) + (page[j + 1, i] * (1 - x) + page[j + 1, i + 1] * x) * y
    return numpy.where(numpy.isnan(coordinates).any(axis=1), 0, light)


def summary(light, points):
    true = numpy.array([point["irradiance"] for point in points])
    curved = numpy.array([point["curved"] for point in points])
    floor = FLOOR * true.mean()
    error = abs(light - true) / numpy.maximum(true, floor)
    of_larger = abs(light - true) / numpy.maximum(numpy.maximum(true, light), floor)
    rows = {}
    for name, chosen in (("all", curved | True), ("flat", ~curved), ("curved", curved)):
        if not chosen.any():
            continue
        e = error[chosen]
        rows[name] = {"points": int(chosen.sum()), "mean": e.mean(), "mean_of_larger": of_larger[chosen].mean(), "median": numpy.median(e),
                      "quantile_95": numpy.quantile(e, 0.95), "share_within": (e <= LARGE).mean(), "largest": e.max(),
                      "bias": light[chosen].sum() / true[chosen].sum() - 1,
                      "of_mean_light": abs(light - true)[chosen].mean() / true.mean()}
    worst = [{**{key: points[i][key] for key in ("kind", "shape", "position", "irradiance", "deviation")},
              "light": light[i], "error": error[i]} for i in error.argsort()[::-1][:12]]
    return {"of": rows, "worst": worst}


def show(name, results, seconds):
    for kind, row in results["of"].items():
        print(f"{name:24} {kind:6} {row['points']:5d} points: mean {row['mean']:7.2%}, of the larger {row['mean_of_larger']:6.2%}, median {row['median']:6.2%}, 95 % within "
              f"{row['quantile_95']:7.2%}, {row['share_within']:6.1%} within {LARGE:.0%}, largest {row['largest']:8.1%}, "
              f"all light {row['bias']:+.2%}; {seconds:.1f} s", flush=True)


def check_unit(folder, arguments):
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
    page, _ = cycles(folder / "unit.npz", folder, side, 1024, arguments)
    # Four quarters, each with a corner above the point (the form factor to a parallel rectangle).
    a = half / height
    quarter = 2 * a / math.hypot(1, a) * math.atan(a / math.hypot(1, a)) / (2 * math.pi)
    true = 4 * quarter * math.pi * radiance
    middle = page[side // 2 - 1:side // 2 + 1, side // 2 - 1:side // 2 + 1].mean()
    print(f"Cycles beneath a square lamp: {middle:.4f}, closed form {true:.4f}: {middle / true - 1:+.2%}", flush=True)
    if abs(middle / true - 1) > 0.01:
        sys.exit("the unit of Cycles' bake is not the expected one")
    return {"cycles": float(middle), "closed_form": true}


def program(name):
    """A file, or a command."""
    path = pathlib.Path(name)
    return path.resolve() if path.is_file() else path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=pathlib.Path, default=ROOT / "scenes/rooms/furnished.pbrt")
    parser.add_argument("--glanz", type=program, default=ROOT / "target/release/glanz")
    parser.add_argument("--points-program", type=program, default=ROOT / "target/release/examples/bake")
    parser.add_argument("--density", type=float, nargs="+", default=[50], help="texels per metre; those of Cycles are the first")
    parser.add_argument("--rays", type=int, default=512, help="of `glanz bake`")
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--reference-error", type=float, default=0.004, help="standard error of a point")
    parser.add_argument("--reference-samples", type=int, default=1 << 18, help="largest number of paths of a point")
    parser.add_argument("--cycles-samples", type=int, nargs="*", default=[16, 64, 256, 1024])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--folder", type=pathlib.Path, help="keep files there, in a folder for each scene and its settings, and use the bakes and points that it has; after a change of the programs, give another one")
    parser.add_argument("--out", type=pathlib.Path, help="JSON file of the results")
    arguments = parser.parse_args()
    check(arguments)
    with tempfile.TemporaryDirectory() as temporary:
        settings = [scene_text(arguments.scene), float(arguments.density[0]), arguments.rays, arguments.points, arguments.reference_error,
                    arguments.reference_samples]
        key = hashlib.sha256(json.dumps(settings).encode()).hexdigest()[:16]
        folder = (arguments.folder or pathlib.Path(temporary)) / key
        folder.mkdir(parents=True, exist_ok=True)
        compare(arguments, folder)


def check(arguments):
    """Ends the program before it has spent an hour if something is missing."""
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        sys.exit(f"Blender's module is missing ({error}): pip install bpy==5.0.1")
    for command in (arguments.glanz, arguments.points_program):
        if not shutil.which(command):
            sys.exit(f"the program {command} is missing: cargo build --release && cargo build --release --example bake")
    if not arguments.scene.is_file():
        sys.exit(f"the scene {arguments.scene} is missing")
    if arguments.out and not arguments.out.resolve().parent.is_dir():
        sys.exit(f"the folder of {arguments.out} is missing")


def save(results, arguments):
    if arguments.out:
        replace_text(arguments.out, json.dumps(results, indent=1))


def bake(arguments, folder, density):
    """The model of `glanz bake` and the processor seconds of that, which a file beside it keeps."""
    model = folder / f"glanz-{density:g}.glb"
    times, checkpoint = model.with_suffix(".json"), model.with_suffix(".light")
    if not times.exists():
        # That of an interrupted bake would be refused, and its time is not known.
        checkpoint.unlink(missing_ok=True)
        _, seconds = run([arguments.glanz, "bake", arguments.scene, "-o", model, "--texels-per-metre", density, "--rays", arguments.rays,
                          "--checkpoint", checkpoint, "--threads", arguments.threads])
        replace_text(times, json.dumps({"processor_seconds": seconds}))
    return model, json.loads(times.read_text())["processor_seconds"]


def reference_points(arguments, folder, model):
    """The output of glanz.rs for the model of the first density."""
    file = folder / "points.json"
    if not file.exists():
        output, seconds = run([arguments.points_program, arguments.scene, model.with_suffix(".light"), arguments.density[0], arguments.rays,
                               arguments.points, arguments.reference_error, arguments.reference_samples, arguments.threads])
        replace_text(file, output)
        print(f"points: {seconds:.0f} s")
    return json.loads(file.read_text())


def reference_summary(reference):
    """Prints and returns the standard errors of the reference."""
    points = reference["points"]
    true, deviation = (numpy.array([p[name] for p in points]) for name in ("irradiance", "deviation"))
    dark = sum(not point["lit"] for point in points)
    print(f"{len(points)} points, {dark} of them on charts without light, {reference['covered']} beside them covered")
    results = {"covered": reference["covered"], "on_charts_without_light": dark}
    for name, light in (("the irradiance", true), (f"the irradiance or {FLOOR:.0%} of its mean", numpy.maximum(true, FLOOR * true.mean()))):
        relative = deviation / light
        print(f"standard error of the reference, relative to {name}: {relative.mean():.2%} on average, "
              f"{numpy.quantile(relative, 0.95):.2%} for 95 %, at most {relative.max():.2%}")
        results[f"relative to {name}"] = {"mean": relative.mean(), "quantile_95": numpy.quantile(relative, 0.95), "largest": relative.max()}
    return results


def locate_on_model(parts, points, density):
    """As `locate`, with the axes that fit."""
    axes, (coordinates, distances) = min(((a, locate(parts, points, a)) for a in AXES), key=lambda c: numpy.median(c[1][1]))
    lost = int((distances > FARTHEST).sum())
    if lost:
        sys.exit(f"{lost} of {len(points)} points are farther than {FARTHEST * 1e3:g} mm from the triangles of their shape at {density:g} texels per "
                 "metre; the scene must have z up, and files of --folder must be of the same programs")
    print(f"points are at most {distances.max() * 1e3:.2f} mm from the triangles")
    return axes, coordinates


def compare(arguments, folder):
    # Without the places of programs and folders on this machine.
    settings = {key: value.name if isinstance(value, pathlib.Path) else value for key, value in vars(arguments).items()}
    results = {"settings": {key: str(value) for key, value in settings.items() if key not in ("folder", "out")}}
    baked = {density: bake(arguments, folder, density) for density in arguments.density}
    models = {density: read_model(model) for density, (model, _) in baked.items()}
    first, seconds_of_first = baked[arguments.density[0]]
    reference = reference_points(arguments, folder, first)
    points = reference["points"]
    results["reference"] = reference_summary(reference)
    results["glanz"] = {}
    for density, (model, seconds) in reversed(baked.items()):
        axes, coordinates = locate_on_model(models[density], points, density)
        page = read_exr(model.with_suffix(".exr"))
        results["glanz"][density] = {**summary(bilinear(page, coordinates), points), "processor_seconds": seconds}
        show(f"glanz, {density:g} texels/m", results["glanz"][density], seconds)
    exact = summary(numpy.array([p["glanz"] for p in points]), points)
    results["glanz_on_surface"] = exact
    show("glanz, exact surfaces", exact, seconds_of_first)
    for worst in exact["worst"]:
        position = ", ".join(f"{x:.3f}" for x in worst["position"])
        print(f"  {worst['error']:7.1%} {worst['kind']} {worst['shape']} ({position}): {worst['light']:.4f}, paths {worst['irradiance']:.4f} "
              f"+- {worst['deviation']:.4f}")
    save(results, arguments)
    if arguments.cycles_samples:
        # The loop ends with the first density.
        mark_lamps(models[arguments.density[0]], reference, axes)
        compare_cycles(arguments, folder, models[arguments.density[0]], len(page), coordinates, points, results)
        if len(results["cycles"]) > 1:
            results["equal"] = equal_error(exact["of"]["all"], results["cycles"], seconds_of_first)
        save(results, arguments)


def compare_cycles(arguments, folder, parts, side, coordinates, points, results):
    """Adds the bakes of Cycles to the results. `side`: texels of the page."""
    write_model(parts, colours(arguments.scene), side, folder / "model.npz")
    results["unit"] = check_unit(folder, arguments)
    results["cycles"] = {}
    for samples in arguments.cycles_samples:
        page, output = cycles(folder / "model.npz", folder, side, samples, arguments)
        numpy.save(folder / f"cycles-{samples}.npy", page)
        results["cycles"][samples] = {**summary(bilinear(page, coordinates), points), **output}
        show(f"cycles, {samples} samples", results["cycles"][samples], output["processor_seconds"])
        save(results, arguments)


def equal_error(of_glanz, cycles, seconds):
    """Processor time of Cycles at the errors of Glanz: its own squared is that of noise, in inverse proportion to the samples, and what remains
    with any number of them, both from the two largest numbers. Not known if the error does not decrease from one to the other."""
    (few, a), (many, b) = sorted(cycles.items())[-2:]
    per_sample, results = b["processor_seconds"] / many, {}
    for name in ("median", "of_mean_light"):
        goal, x, y = (of[name] for of in (of_glanz, a["of"]["all"], b["of"]["all"]))
        noise = (x ** 2 - y ** 2) / (1 / few - 1 / many)
        at_least = y ** 2 * many / goal ** 2 * per_sample
        results[name] = {"goal": goal, "seconds_if_nothing_remained": at_least}
        if noise <= 0:
            text = "unknown, as the error does not decrease with the number of samples"
        else:
            rest = max(y ** 2 - noise / many, 0)
            results[name]["remaining"] = math.sqrt(rest)
            if goal ** 2 > rest:
                results[name]["seconds"] = noise / (goal ** 2 - rest) * per_sample
                text = f"{results[name]['seconds']:.0f} s"
            else:
                text = "never"
            text += f", {math.sqrt(rest):.2%} remain with any number of samples"
        print(f"Cycles at the error of Glanz ({name}, {goal:.2%} after {seconds:.0f} s): {text}; {at_least:.0f} s if nothing remained")
    return results


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

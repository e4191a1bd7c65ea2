#!/usr/bin/env python3
"""Error over time of Glanz, with and without path guiding, and of other renderers, in rooms with little and much indirect light.

    pip install numpy OpenEXR mitsuba pyluxcore      # in one environment; libllvm22 for Mitsuba's vectorised variant
    pip install bpy                                  # in another: it needs an older numpy
    peers/guiding/compare.py --rooms uplights --times 5 15 45 --size 320x240 --blender OTHER/bin/python
        [--renderers glanz mitsuba ...] [--rounds 3] [--threads 2] [--references 4096 1024] [--work DIR] [--out FILE.json]

The scenes are those of scenes/rooms and of the folder scenes here. glanz.rs reads them as Glanz does and exports triangles, materials,
lights and the camera for the other renderers; only Glanz renders the surfaces themselves. All renderers use a box filter of one pixel and the path depth of
the scene, and neither clamp nor denoise. Mitsuba's sampler is independent, the others use Sobol' sequences.

First the pictures must agree: each renderer renders a reference of its own, in steps that are stored in the working folder, so
that an interrupted run is resumed and a larger number of samples adds to those present. Means and blocks of 8 x 8 pixels are
compared with Glanz's reference, and all references are put side by side in ROOM-SIZE/references.png: look at it.

Then the renderers render in turn for each of the times, with one seed per round. The times are limits of wall-clock time; the time
used is measured as well. Building hierarchies and compiling are not counted, except for a tenth of a second in Glanz's processor
time. Errors are medians over the rounds: the root of the mean squared difference per pixel and channel (rmse) and the mean squared
difference relative to the square of the reference + 0.01 (relmse), both against Glanz's reference; the same two against the
renderer's own reference, which excludes differences by the export (own); relmse without the worst thousandth of all pixels,
which excludes fireflies (trimmed); and, from two rounds on, half of the mean squared difference between rounds, relative to the same (variance), which needs no reference
of the renderer's own: --references 4096 0 spares those of the others.

Efficiency is 1 / (relmse x processor seconds), as a multiple of Glanz's path tracer at the same time: on shared processors,
wall-clock time is not comparable. Path guiding improves with time; compare it on a machine without other load.
"""

import argparse
import hashlib
import json
import pathlib
import platform
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import numpy
import OpenEXR

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROOMS = ["direct", "uplights", "open"]

# Scenes that are compared if they are asked for.
EXTRA_SCENES = ["cornell", "teapot"]

# Where the scenes are.
SCENES = [ROOT / "scenes" / "rooms", HERE / "scenes"]

# First seed of references; those of measurements are smaller.
REFERENCE_SEED = 1000

# Samples per pixel of one step of a peer's reference.
STEP = 64


def built(package, name, *kind):
    """The path of a program of the workspace."""
    cargo = ["cargo", "build", "--release", "-p", package, *kind, "--message-format=json"]
    messages = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    lines = [json.loads(line) for line in messages.splitlines()]
    return next(m["executable"] for m in lines if m.get("target", {}).get("name") == name and m.get("executable"))


class Glanz:
    """Glanz with one of its integrators; `more`: further options."""

    def __init__(self, name, program, integrator, *more):
        self.name, self.program, self.integrator, self.more = name, program, integrator, more
        # All integrators converge to the same picture.
        self.reference = "glanz"

    def call(self, room, picture, *more):
        command = [self.program, "render", room.scene, "--integrator", self.integrator, "--size", room.size, "--threads",
                   room.threads, "--quiet", "--json", "-o", picture, *more]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        said = subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True).stdout
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        about = json.loads(said)
        used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        values = OpenEXR.File(str(picture)).channels()["RGB"].pixels.astype(numpy.float64)
        return values, {"samples": about["samples_per_pixel"], "seconds": about["seconds"], "processor_seconds": used,
                        "version": about["integrator"]}

    def render(self, room, seconds, seed):
        with tempfile.TemporaryDirectory() as folder:
            return self.call(room, pathlib.Path(folder) / "picture.exr", "--time", seconds, "--seed", seed, *self.more)

    def converged(self, room, samples):
        """The reference of Glanz; its checkpoint makes it resumable."""
        kept = room.folder / f"glanz-{room.digest}.checkpoint"
        picture = room.folder / "glanz.exr"
        more = ["--checkpoint", kept, "--resume", "--seed", REFERENCE_SEED, "--spp", samples]
        return self.call(room, picture, *more)[0]


class Peer:
    """A renderer's program with the interface of exported.py."""

    def __init__(self, name, python, program, *more, reference=None):
        self.name, self.reference = name, reference or name
        self.command = [python, HERE / program]
        self.more = more

    def call(self, room, *budget):
        with tempfile.TemporaryDirectory() as folder:
            picture = pathlib.Path(folder) / "picture.npy"
            command = [*self.command, room.folder, picture, "--size", room.size, "--threads", room.threads, *budget,
                       *self.more]
            # Their output is of interest only if they fail.
            said = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if said.returncode != 0:
                sys.exit(f"{self.name} failed:\n{said.stdout}")
            # Other threads may write after the last line.
            last = [line for line in said.stdout.splitlines() if line.startswith('{"samples"')][-1]
            return numpy.load(picture).astype(numpy.float64), json.loads(last)

    def render(self, room, seconds, seed):
        return self.call(room, "--seconds", seconds, "--seed", seed)

    def converged(self, room, samples):
        kept = room.folder / f"{self.reference}-{room.digest}.npz"
        total, count = 0.0, 0
        if kept.exists():
            with numpy.load(kept) as data:
                total, count = data["total"], int(data["count"])
        while count < samples:
            picture, _ = self.call(room, "--samples", STEP, "--seed", REFERENCE_SEED + count // STEP)
            total, count = total + STEP * picture, count + STEP
            unfinished = kept.with_suffix(".unfinished.npz")
            numpy.savez(unfinished, total=total, count=count)
            unfinished.replace(kept)
        return total / count


class Room:
    """A scene, exported at some size."""

    def __init__(self, name, arguments, exporter):
        self.name, self.size, self.threads = name, arguments.size, arguments.threads
        self.scene = next(file for file in (folder / f"{name}.pbrt" for folder in SCENES) if file.exists())
        self.folder = arguments.work / f"{name}-{arguments.size}"
        self.folder.mkdir(parents=True, exist_ok=True)
        for old in self.folder.glob("*.ply"):
            old.unlink()
        subprocess.run([exporter, self.scene, self.folder], check=True)
        # References of another scene must not be continued.
        exported = [self.folder / "scene.json", *sorted(self.folder.glob("*.ply"))]
        self.digest = hashlib.sha256(b"".join(file.read_bytes() for file in exported)).hexdigest()[:12]


def blocks(picture, side=8):
    rows, columns = (n // side * side for n in picture.shape[:2])
    return picture[:rows, :columns].reshape(rows // side, side, columns // side, side, 3).mean((1, 3))


def agreement(picture, reference):
    ours, theirs = blocks(picture), blocks(reference)
    relative = (ours - theirs) / (theirs + 0.02)
    lit = theirs > 0.01
    return {"mean_ratio": picture.mean() / reference.mean(), "block_median_ratio": float(numpy.median(ours[lit] / theirs[lit])),
            "block_relative_rms": float(numpy.sqrt((relative**2).mean()))}


def errors(picture, reference, own):
    def relative(to):
        return (picture - to) ** 2 / (to**2 + 0.01)

    pixels = relative(own).mean(2).ravel()
    worst = max(1, len(pixels) // 1000)
    return {
        "rmse": float(numpy.sqrt(((picture - reference) ** 2).mean())), "relmse": float(relative(reference).mean()),
        "own_rmse": float(numpy.sqrt(((picture - own) ** 2).mean())), "own_relmse": float(pixels.mean()),
        "trimmed_relmse": float(numpy.partition(pixels, -worst)[:-worst].mean()),
    }


def variance(pictures, reference):
    """Variance of a picture relative to the square of the reference + 0.01, from independent ones."""
    return float((numpy.var(pictures, axis=0, ddof=1) / (reference**2 + 0.01)).mean())


def write_png(path, picture):
    """Linear values as an sRGB picture."""
    x = numpy.clip(picture, 0, 1)
    shown = numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    rows = (255 * shown + 0.5).astype(numpy.uint8)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 2, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def references(room, renderers, samples):
    """References by name, and the agreement of the peers' with that of Glanz."""
    found, agreements = {}, {}
    for renderer in renderers:
        if renderer.reference != "glanz" and samples[1] == 0:
            found[renderer.reference] = found["glanz"]
        elif renderer.reference not in found:
            picture = renderer.converged(room, samples[0] if renderer.reference == "glanz" else samples[1])
            found[renderer.reference] = picture
            if renderer.reference != "glanz":
                same = agreements[renderer.reference] = agreement(picture, found["glanz"])
                print(f"  {renderer.reference:9} mean {same['mean_ratio']:.4f} of Glanz, blocks {same['block_median_ratio']:.4f}"
                      f" by the median, {100 * same['block_relative_rms']:.2f} % rms apart", flush=True)
    write_png(room.folder / "references.png", numpy.concatenate(list(found.values()), axis=1))
    return found, agreements


def measure(room, renderers, found, arguments):
    """A row for each time and renderer, with medians over the rounds."""
    rows = []
    for seconds in arguments.times:
        runs = {renderer.name: [] for renderer in renderers}
        pictures = {renderer.name: [] for renderer in renderers}
        for seed in range(1, arguments.rounds + 1):
            for renderer in renderers:
                picture, about = renderer.render(room, seconds, seed)
                pictures[renderer.name].append(picture)
                runs[renderer.name].append(about | errors(picture, found["glanz"], found[renderer.reference]))
        for name, all_runs in runs.items():
            numbers = [key for key, value in all_runs[0].items() if isinstance(value, (int, float))]
            medians = {key: statistics.median(run[key] for run in all_runs) for key in numbers}
            if arguments.rounds > 1:
                medians["variance"] = variance(pictures[name], found["glanz"])
            rows.append({"renderer": name, "time": seconds} | medians | {"runs": all_runs})
        show(rows[-len(renderers):])
    return rows


def show(rows):
    def efficiency(row):
        return 1 / (row["relmse"] * row["processor_seconds"])

    columns = ["time", "seconds", "processor_seconds", "samples", "rmse", "own_rmse", "relmse", "own_relmse", "trimmed_relmse",
               "variance", "efficiency"]
    print("\n  | renderer | " + " | ".join(columns) + " |\n  |" + "---|" * (len(columns) + 1))
    for row in rows:
        row["efficiency"] = efficiency(row) / efficiency(rows[0])
        values = " | ".join(f"{row[name]:.4g}" if name in row else "-" for name in columns)
        print(f"  | {row['renderer']} | {values} |", flush=True)


def all_renderers(arguments):
    """The available renderers; Glanz's path tracer is first, since the others are compared with it."""
    program = arguments.glanz or built("glanz-cli", "glanz", "--bin", "glanz")
    python, blender = arguments.python, arguments.blender
    known = [Glanz("glanz", program, "path")]
    help_text = subprocess.run([program, "render", "--help"], check=True, stdout=subprocess.PIPE, text=True).stdout
    if "--branching" in help_text:
        known.append(Glanz("glanz-branching", program, "path", "--branching", 4))
    if "guided" in help_text:
        known.append(Glanz("glanz-guided", program, "guided"))
    known += [Peer("mitsuba", python, "render_mitsuba.py"),
              Peer("mitsuba-llvm", python, "render_mitsuba.py", "--vectorised", reference="mitsuba"),
              Peer("luxcore", python, "render_luxcore.py")]
    if blender:
        known += [Peer("cycles", blender, "render_cycles.py"),
                  Peer("cycles-guided", blender, "render_cycles.py", "--guided", reference="cycles")]
    asked = arguments.renderers or [renderer.name for renderer in known]
    missing = set(asked) - {renderer.name for renderer in known}
    if missing:
        sys.exit(f"not there: {', '.join(sorted(missing))}; there are {', '.join(renderer.name for renderer in known)}")
    return [renderer for renderer in known if renderer.name in asked or renderer is known[0]]


def options():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rooms", nargs="+", choices=ROOMS + EXTRA_SCENES, default=ROOMS)
    parser.add_argument("--times", nargs="*", type=float, default=[5, 15, 45], help="seconds; none: only the references")
    parser.add_argument("--size", default="320x240", help="of the pictures, pixels")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--references", nargs=2, type=int, default=[4096, 1024], metavar=("GLANZ", "PEERS"),
                        help="samples per pixel")
    parser.add_argument("--renderers", nargs="+", help="beside Glanz's path tracer; all, if not said")
    parser.add_argument("--python", default=sys.executable, help="has mitsuba and pyluxcore")
    parser.add_argument("--blender", help="a Python that has bpy; without it Cycles is left out")
    parser.add_argument("--glanz", help="the program; built, if not said")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "target" / "guiding", help="folder that keeps references")
    parser.add_argument("--out", type=pathlib.Path, help="raw results")
    return parser.parse_args()


def main():
    arguments = options()
    renderers = all_renderers(arguments)
    exporter = built("glanz-formats", "peer_guiding", "--example", "peer_guiding")
    about = {"date": time.strftime("%Y-%m-%d"), "machine": platform.platform(), "size": arguments.size,
             "threads": arguments.threads, "reference_samples": dict(zip(("glanz", "peers"), arguments.references)), "rooms": []}
    for name in arguments.rooms:
        room = Room(name, arguments, exporter)
        print(f"{name}, {room.size}, {room.threads} threads", flush=True)
        found, agreements = references(room, renderers, arguments.references)
        about["rooms"].append({"room": name, "agreement": agreements, "rows": measure(room, renderers, found, arguments)})
        if arguments.out:
            arguments.out.parent.mkdir(parents=True, exist_ok=True)
            arguments.out.write_text(json.dumps(about, indent=1) + "\n")


if __name__ == "__main__":
    main()

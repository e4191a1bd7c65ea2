#!/usr/bin/env python3
"""Models with light maps from `glanz bake` in other programs: three.js in a browser, and Blender.

    apt-get install chromium nodejs npm
    (cd peers/gltf && npm ci)
    pip install numpy OpenEXR pillow                 # in one environment
    pip install bpy                                  # in another: it needs an older numpy
    peers/gltf/compare.py --rooms vase open [--size 640x480] [--samples 256] [--references radiosity path] [--over 4]
        [--chromium /usr/bin/chromium] [--blender OTHER/bin/python] [--glanz PROGRAM] [--threads 2] [--work DIR] [--out FILE.json] [--picture FILE.png]

The scenes are those of scenes/rooms. Each is baked, Khronos' validator checks the model, and three.js and Blender render it from
its camera. page.html is the page that three.js uses; served by any file server, it is an interactive viewer of a model:

    cd peers/gltf && python3 -m http.server          # http://localhost:8000/page.html?model=room.glb

Glanz renders the same view twice: with the light maps of the model ("radiosity"), where all differences come from the model and the
other program, and by path tracing, where they include those of the light maps. Light above 1 is clipped, as in the model. Expected
differences: the model's light and the picture are rounded to 8 bits of sRGB; colours have the resolution of the texels; triangles
deviate from the surface; mirrors and glass are shown as diffuse; and three.js does not sample pixels, so that its picture is
rendered larger (`--over`) and averaged in linear light. Figures for linear values, mean over pixels and channels:

    difference   |shown - reference| relative to the reference, or to a hundredth of its mean where that is larger
    light        mean of shown relative to the mean of the reference, minus 1
    within       95 % quantile of the differences
    blocks       the difference of means of 16 x 16 pixels, in which the noise of paths is small
    8 bits       the difference of the reference from itself after rounding to 8 bits of sRGB

Models and pictures of Glanz that exist in the working folder are reused: choose another folder after a change.

An invalid model, or any message on the browser's console, ends the run. `--picture`: the pictures of three.js, Blender and Glanz
side by side, of the first room, at half the size. Look at it.
"""

import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys
import tempfile

import numpy
import OpenEXR
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# Fields of the report of `glanz bake` that are stored.
TOLD = ["charts", "texels", "side", "pages", "triangles", "tolerance", "warnings"]

# Samples per pixel by integrator: with light maps, only edges need several.
SAMPLES = {"radiosity": 64, "path": 256}

# Pixels along a side of the blocks over which noise is averaged.
BLOCK = 16


def built():
    """The path of the command line."""
    cargo = ["cargo", "build", "--release", "-p", "glanz-cli", "--bin", "glanz", "--message-format=json"]
    messages = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    lines = [json.loads(line) for line in messages.splitlines()]
    return next(line["executable"] for line in lines if line.get("executable"))


def answer(command, threads):
    """The JSON that a program prints after all other output."""
    command = [str(word) for word in command]
    print("$", *command, file=sys.stderr, flush=True)
    environment = os.environ | {"RAYON_NUM_THREADS": str(threads)}
    ran = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=environment)
    return json.loads(ran.stdout[("\n" + ran.stdout).rindex("\n{"):])


def kept(path, command, threads):
    """The result of a program that writes a file; an existing file is reused."""
    said = path.with_suffix(path.suffix + ".json")
    if not (path.exists() and said.exists()):
        said.write_text(json.dumps(answer(command, threads)))
    return json.loads(said.read_text())


def decoded(bytes_):
    """Linear light of sRGB bytes."""
    x = numpy.asarray(bytes_, dtype=numpy.float64) / 255
    return numpy.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def encoded(light):
    """sRGB bytes of linear light."""
    x = numpy.clip(light, 0, 1)
    x = numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return numpy.rint(255 * x).astype(numpy.uint8)


def exr(path):
    """Linear light of a rendered picture, clipped as in a model."""
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return numpy.clip(numpy.stack([channels[name].pixels for name in "RGB"], axis=-1).astype(numpy.float64), 0, 1)


def blocks(light, side=BLOCK):
    """Means of `side` by `side` pixels."""
    rows, columns = (n // side for n in light.shape[:2])
    return light[:side * rows, :side * columns].reshape(rows, side, columns, side, 3).mean(axis=(1, 3))


def png(path, over=1):
    """Linear light of a picture, `over` by `over` of its pixels averaged to one."""
    return blocks(decoded(Image.open(path).convert("RGB")), over)


def differences(shown, reference):
    return numpy.abs(shown - reference) / numpy.maximum(reference, 0.01 * reference.mean())


def figures(shown, reference):
    relative = differences(shown, reference)
    return {
        "difference": float(relative.mean()),
        "light": float(shown.mean() / reference.mean() - 1),
        "within": float(numpy.quantile(relative, 0.95)),
        "blocks": float(differences(blocks(shown), blocks(reference)).mean()),
        "8 bits": float(differences(decoded(encoded(reference)), reference).mean()),
    }


def checked(model, asked):
    """The report of the validator. Two of its infos are intended: coordinates that no material uses, the surface's own parameters;
    and a picture whose side is not a power of two, which is free of cost without mipmaps and since OpenGL ES 3."""
    report = answer(["node", HERE / "valid.js", model], asked.threads)
    kinds = {message["code"] for message in report.pop("messages")}
    if report["errors"] or report["warnings"] or kinds - {"UNUSED_OBJECT", "IMAGE_NPOT_DIMENSIONS"}:
        sys.exit(f"{model} is not valid: {report} {kinds}")
    return report


def compared(room, glanz, asked):
    width, height = map(int, asked.size.split("x"))
    scene = ROOT / "scenes" / "rooms" / f"{room}.pbrt"
    at = asked.work / room
    model = at.with_suffix(".glb")
    baked = kept(model, [glanz, "bake", scene, "-o", model, "--json", "-q"], asked.threads)
    report = {"baked": {name: baked[name] for name in TOLD}}
    report["validator"] = checked(model, asked)

    shown = {}
    picture = asked.work / f"{room}-three.png"
    large = f"{asked.over * width}x{asked.over * height}"
    three = ["node", HERE / "three.js", model, picture, large, "--chromium", asked.chromium]
    report["three"] = answer(three, asked.threads)
    if report["three"]["said"]:
        sys.exit(f"the browser's console: {report['three']['said']}")
    shown["three"] = png(picture, asked.over)
    if asked.blender:
        picture = asked.work / f"{room}-blender.png"
        blender = [asked.blender, HERE / "blender.py", model, picture, asked.size, "--threads", asked.threads]
        report["blender"] = answer(blender, asked.threads)
        shown["blender"] = png(picture)

    references = {}
    for integrator in asked.references:
        picture = asked.work / f"{room}-{integrator}.exr"
        render = [glanz, "render", scene, "-o", picture, "--integrator", integrator, "--size", asked.size,
                  "--spp", asked.samples[integrator], "--threads", asked.threads, "--json", "-q"]
        kept(picture, render, asked.threads)
        references[integrator] = exr(picture)

    for program, light in shown.items():
        for integrator, reference in references.items():
            found = report[program][integrator] = figures(light, reference)
            print(f"{room:10} {program:8} {integrator:10}", *(f"{name} {100 * x:+.2f} %" for name, x in found.items()),
                  flush=True)
            # Grey is no difference; white is a fifth more, black a fifth less.
            relative = (light - reference) / numpy.maximum(reference, 0.01 * reference.mean())
            grey = numpy.clip(128 + 635 * relative, 0, 255).astype(numpy.uint8)
            Image.fromarray(grey).save(asked.work / f"{room}-{program}-{integrator}-difference.png")
    beside = numpy.concatenate([*shown.values(), references[asked.references[0]]], axis=1)
    Image.fromarray(encoded(beside)).save(asked.work / f"{room}.png")
    return report, beside


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rooms", nargs="+", default=["vase", "open"])
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--samples", type=int, default=SAMPLES["path"], help="of paths per pixel")
    parser.add_argument("--references", nargs="+", default=list(SAMPLES), choices=list(SAMPLES))
    parser.add_argument("--over", type=int, default=4)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--blender", type=pathlib.Path, help="a Python that has bpy")
    parser.add_argument("--glanz", type=pathlib.Path, help="the program; default: it is built")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--work", type=pathlib.Path, help="folder for models and pictures; those of Glanz are reused")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--picture", type=pathlib.Path)
    asked = parser.parse_args()
    asked.samples = SAMPLES | {"path": asked.samples}
    with tempfile.TemporaryDirectory() as folder:
        asked.work = asked.work or pathlib.Path(folder)
        asked.work.mkdir(parents=True, exist_ok=True)
        glanz = asked.glanz or built()
        found = {}
        for number, room in enumerate(asked.rooms):
            found[room], beside = compared(room, glanz, asked)
            if asked.picture and number == 0:
                Image.fromarray(encoded(blocks(beside, 2))).save(asked.picture, optimize=True)
    if asked.out:
        machine = {"processor": platform.processor() or platform.machine(), "system": platform.platform()}
        settings = {"size": asked.size, "samples": asked.samples, "over": asked.over}
        asked.out.write_text(json.dumps({"machine": machine, "settings": settings, "rooms": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()

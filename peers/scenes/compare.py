#!/usr/bin/env python3
"""Compares pictures of Glanz and Mitsuba 3 of the same scenes pixel by pixel; README.md describes it.

    peers/scenes/compare.py --glanz target/release/glanz [--scene NAME ...] [--json FILE] [--pictures FOLDER]

Exit status: 0 all scenes agree, 1 at least one does not, 2 a program failed. Scenes that Glanz does not read yet are 'not available'.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import drjit
import mitsuba
import numpy

import languages
import scenes
import ztest


class NotAvailable(Exception):
    """Glanz does not read a part of the scene exactly."""


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--glanz", help="program of Glanz; without it the halves of Mitsuba's renders are compared, which tests the test")
    parser.add_argument("--scene", nargs="*", default=["all"], help="names, or all")
    parser.add_argument("--list", action="store_true", help="list the scenes")
    parser.add_argument("--renders", type=int, default=32, help="independent renders by each program")
    parser.add_argument("--samples", type=int, default=32, help="samples per pixel of each; some scenes have a multiple in Mitsuba")
    parser.add_argument("--size", type=int, default=64, help="width and height, a multiple of 8")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--integrator", help="another integrator of Glanz: light, guided, distributed, ...")
    parser.add_argument("--sampler", help="another sampler of Glanz; independent is that of Mitsuba here")
    parser.add_argument("--json", type=pathlib.Path, help="file for the results")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for pictures: Glanz, Mitsuba, z of every pixel")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the scene files, instead of a temporary one")
    return parser.parse_args()


def render_glanz(scene: languages.Scene, asked: argparse.Namespace) -> numpy.ndarray:
    file, out = scene.folder / "scene.pbrt", scene.folder / "out.exr"
    pictures = []
    for seed in range(asked.seed, asked.seed + asked.renders):
        command = [asked.glanz, "render", file, "-o", out, "--spp", asked.samples, "--seed", seed, "--threads", asked.threads, "--strict", "-q"]
        command += ["--integrator", asked.integrator] if asked.integrator else []
        command += ["--sampler", asked.sampler] if asked.sampler else []
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
        if done.returncode:
            errors = [text for text in done.stderr.splitlines() if text.startswith("error:")]
            if errors and all("stands in" in text for text in errors):
                raise NotAvailable(errors[0].rpartition(": ")[2])
            print(f"{file}\n{done.stderr}", file=sys.stderr)
            sys.exit(2)
        pictures.append(languages.read(out))
    return numpy.stack(pictures)


def render_mitsuba(scene: languages.Scene, asked: argparse.Namespace, first: int = 0) -> numpy.ndarray:
    world = scene.mitsuba()
    seeds = range(asked.seed + first, asked.seed + first + asked.renders)
    return numpy.stack([numpy.array(mitsuba.render(world, spp=asked.samples * scene.factor, seed=seed), dtype=float) for seed in seeds])


def show(name: str, first: numpy.ndarray, second: numpy.ndarray, z: numpy.ndarray, folder: pathlib.Path) -> None:
    """Both pictures and z from -5 (blue) over 0 (white) to 5 (red)."""
    folder.mkdir(parents=True, exist_ok=True)
    height = max(float(numpy.quantile(second.mean(axis=0), 0.98)), 1e-6)
    curve = [numpy.clip(p.mean(axis=0) / height, 0, 1) ** (1 / 2.2) for p in (first, second)]
    worst = numpy.take_along_axis(z, numpy.abs(z).argmax(axis=2, keepdims=True), axis=2)[..., 0] / 5
    red, blue = 1 - numpy.clip(-worst, 0, 1), 1 - numpy.clip(worst, 0, 1)
    sheet = numpy.concatenate([*curve, numpy.stack([red, numpy.minimum(red, blue), blue], axis=2)], axis=1)
    sheet = sheet.repeat(4, axis=0).repeat(4, axis=1)
    mitsuba.Bitmap((sheet * 255 + 0.5).astype(numpy.uint8)).write(str(folder / f"{name}.png"))


def compare(name: str, asked: argparse.Namespace, folder: pathlib.Path) -> dict[str, object]:
    folder.mkdir(parents=True, exist_ok=True)
    scene = languages.Scene(folder, asked.size)
    scenes.SCENES[name](scene)
    (folder / "scene.pbrt").write_text(scene.pbrt())
    start = time.monotonic()
    try:
        first = render_glanz(scene, asked) if asked.glanz else render_mitsuba(scene, asked, 1 << 20)
    except NotAvailable as reason:
        return {"scene": name, "state": "not available", "reason": str(reason)}
    middle = time.monotonic()
    second = render_mitsuba(scene, asked)
    end = time.monotonic()
    result = ztest.compare(first, second)
    levels = result.pop("levels")
    # At as many samples.
    factor = scene.factor if asked.glanz else 1
    result["variance_ratio"] = {k: v / factor for k, v in result["variance_ratio"].items()}
    if asked.pictures:
        show(name, first, second, levels[0].z, asked.pictures)
    return {"scene": name, "state": "agrees" if result.pop("passes") else "DIFFERS", **result,
            "levels": [{k: v for k, v in level._asdict().items() if k != "z"} for level in levels],
            "seconds": [round(middle - start, 1), round(end - middle, 1)]}


def line(result: dict[str, object]) -> str:
    if result["state"] == "not available":
        return f"{result['scene']:24} not available: {result['reason']}"
    cells = "  ".join(f"{l['smallest_p']:8.2g} {100 * l['beyond']:5.2f} {l['variance']:5.2f}" for l in result["levels"][:2])
    return (f"{result['scene']:24} {result['state']:8} {cells}  {result['levels'][2]['smallest_p']:8.2g}  "
            f"{result['ratio']:.5f} +- {result['ratio_error']:.5f}  {result['variance_ratio']['mean']:6.2f}"
            f" {result['variance_ratio']['without_worst_percent']:6.2f} {result['variance_ratio']['median']:6.2f}  {result['seconds']} s")


def main() -> int:
    asked = arguments()
    if asked.list:
        print("\n".join(f"{name:24} {build.__doc__}" for name, build in scenes.SCENES.items()))
        return 0
    drjit.set_thread_count(asked.threads)
    names = list(scenes.SCENES) if asked.scene == ["all"] else asked.scene
    print(f"{'':33} pixels: p, % beyond, var   blocks: p, % beyond, var     mean: p     Glanz / Mitsuba     variances: all, 99 %, median")
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        for name in names:
            results.append(compare(name, asked, (asked.keep or pathlib.Path(temporary)) / name))
            print(line(results[-1]), flush=True)
    if asked.json:
        versions = {"mitsuba": mitsuba.__version__, "variant": mitsuba.variant()}
        if asked.glanz:
            versions["glanz"] = subprocess.run([asked.glanz, "--version"], capture_output=True, text=True).stdout.strip()
        report = {"date": time.strftime("%Y-%m-%d"), "versions": versions, "renders": asked.renders, "samples": asked.samples, "size": asked.size,
                  "integrator": asked.integrator or "path", "sampler": asked.sampler or "sobol", "seed": asked.seed, "results": results}
        asked.json.write_text(json.dumps(report, indent=1) + "\n")
    return 1 if any(r["state"] == "DIFFERS" for r in results) else 0


sys.exit(main())

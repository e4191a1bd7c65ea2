#!/usr/bin/env python3
"""Freeform surfaces: Glanz intersects the surface itself, Embree a tessellation of it, with the same rays in one run.

    apt-get install libembree-dev        # Embree 3.13
    peers/freeform/compare.py [--models bicubic teapot ...] [--rounds 7] [--mode fast|robust] [--out benches/results/NAME.json]
                              [--size 1920x1080] [--pictures DIR]

The triangles are within 1e-4 of the size (diagonal of the bounding box) of the surface, and their interpolated normals within
0.1 degree; both are measured. Each patch has its own grid with the smallest sufficient number of cells. The search for that number
is not timed, and cracks between patches with different grids are not closed, which favours Embree. Trimming drops whole triangles.

Both sides are programs that execute one task at a time, alternately, with one call per ray and one thread. The result is the
ratio of the medians of processor time.

Batches of Glanz are of 4096 rays: those of a camera in tiles, in random order, and random lines; Embree takes the same rays one by one and
in packets of 16, with and without its flag for coherent ones.

Tasks: rays of a camera (1920 x 1080) line by line ("coherent") and in random order ("shuffled"); the closest hit and any; the
picture, which is the closest hits with their normals (Glanz: in batches of tiles, with all data that a renderer uses; Embree: ray by ray,
and in packets with the flag for coherent ones). The time to the picture is build and picture for Glanz; tessellation, build and picture
for Embree. Memory is that of the surface (patches, leaves, hierarchy) for
Glanz, and for Embree its own count including buffers, plus 12 bytes per normal.
"""

import argparse
import json
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from sides import Side, build

TASKS = [("coherent", "closest"), ("shuffled", "closest"), ("coherent", "any"), ("shuffled", "any")]

# Ways to a picture: batches of Glanz, single rays and packets of Embree.
PICTURES = {"Glanz": ("tiles", "picture"), "Embree": ("coherent", "picture"), "Embree packets": ("coherent", "picture16coherent")}

# Batches of Glanz beside single rays of both and Embree's packets of 16.
BATCHED = [(rays, query) for query in ("closest", "any") for rays in ("tiles", "shuffled", "lines")]


def measure(sides, rounds):
    """Runs all tasks `rounds` times, with both sides alternating; returns results by task, with medians."""
    results = []
    for task in TASKS:
        rates = {side.name: [] for side in sides}
        answers = {}
        for _ in range(rounds):
            for side in sides:
                _, processors, rays, hits, total = side.ask(*task, 1)
                rates[side.name].append(rays / processors * 1e3)
                answers[side.name] = (hits, total)
        medians = {name: statistics.median(rate) for name, rate in rates.items()}
        glanz, embree = medians.values()
        results.append({"rays": task[0], "query": task[1], "million_rays_per_second": medians, "ratio": glanz / embree,
                        "hits_and_sum": answers, "each": rates})
        print(f"  {task[0]:9} {task[1]:8} Glanz {glanz:6.2f} Embree {embree:6.2f} ratio {glanz / embree:5.2f}"
              f" | hits {answers[sides[0].name][0]} {answers[sides[1].name][0]}", flush=True)
    return results


def measure_batches(glanz, embree, rounds):
    """The same for batches: rates of all ways, which take turns, and the ratios of the batch to Embree's."""
    results = []
    for rays, query in BATCHED:
        ways = {"batch": (glanz, f"{query}_batch"), "single": (glanz, query), "Embree": (embree, query),
                "packets": (embree, f"{query}16"), "coherent packets": (embree, f"{query}16coherent")}
        rates, hits = {name: [] for name in ways}, {}
        for _ in range(rounds):
            for name, (side, task) in ways.items():
                _, processors, count, hits[name], _ = side.ask(rays, task, 1)
                rates[name].append(count / processors * 1e3)
        if hits["batch"] != hits["single"]:
            sys.exit(f"{rays} {query}: a batch has {hits['batch']} hits, single rays {hits['single']}")
        medians = {name: statistics.median(rate) for name, rate in rates.items()}
        ratios = {name: medians["batch"] / rate for name, rate in medians.items() if name != "batch"}
        results.append({"rays": rays, "query": query, "million_rays_per_second": medians, "batch_over": ratios,
                        "hits": hits, "each": rates})
        print(f"  {rays:9} {query:8}" + "".join(f" {name} {rate:.2f}" for name, rate in medians.items())
              + " | batch over" + "".join(f" {name} {ratio:.2f}" for name, ratio in ratios.items())
              + f" | hits {hits['batch']} {hits['single']} {hits['Embree']}", flush=True)
    return results


def measure_picture(glanz, embree, rounds):
    """Seconds of all ways to the picture, without build, which take turns."""
    seconds = {name: [] for name in PICTURES}
    for _ in range(rounds):
        for name, task in PICTURES.items():
            _, processors, *_ = (glanz if name == "Glanz" else embree).ask(*task, 1)
            seconds[name].append(processors * 1e-9)
    return {name: statistics.median(times) for name, times in seconds.items()}


def show(about):
    build, tessellate, embree = (1e3 * about[name] for name in ("build_s", "tessellate_s", "embree_build_s"))
    print(f"  build: {build:.3g} ms against {tessellate:.3g} + {embree:.3g} ms | memory: {about['bytes'] / 1e6:.3g} MB against"
          f" {about['embree_bytes'] / 1e6:.3g} (ratio {about['bytes'] / about['embree_bytes']:.4f})")
    seconds = about["to_picture_s"]
    print("  to the picture: " + ", ".join(f"{name} {time:.3f} s" for name, time in seconds.items())
          + f" (Glanz over Embree {seconds['Glanz'] / seconds['Embree']:.2f},"
          f" over packets {seconds['Glanz'] / seconds['Embree packets']:.2f})")
    print(f"  {about['difference']}", flush=True)


def run(model, programs, folder, arguments):
    """Compares both sides for one model."""
    glanz = Side("Glanz", [programs[0], folder, model, *arguments.size.split("x")])
    embree = Side("Embree", [programs[1], folder, arguments.mode, 1, "coherent", "shuffled", "tiles", "lines"])
    about = json.loads(glanz.about)
    print(f"{model}: {about['patches']} patches, {about['leaves']} leaves | {about['triangles']} triangles, chord"
          f" {about['chord_of_size']:.1e} of the size, normals {about['normal_degrees']:.3f} degrees (facets"
          f" {about['facet_normal_degrees']:.2f})", flush=True)
    results = measure([glanz, embree], arguments.rounds)
    batches = measure_batches(glanz, embree, arguments.rounds)
    builds = [embree.ask("mesh", "build", 1) for _ in range(max(arguments.rounds, 5))]
    about["embree_build_s"] = statistics.median(processors for _, processors, *_ in builds) * 1e-9
    about["embree_bytes"] = int(builds[-1][4]) + 12 * about["vertices"]
    before = {"Glanz": about["build_s"]}
    triangles = about["tessellate_s"] + about["embree_build_s"]
    about["to_picture_s"] = {name: before.get(name, triangles) + time
                             for name, time in measure_picture(glanz, embree, arguments.rounds).items()}
    embree.ask("coherent", "dump", 1)
    about["difference"] = json.loads(glanz.say("coherent", "compare", 1))
    show(about)
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
        (arguments.pictures / f"{model.replace(' ', '-')}.pgm").write_bytes((folder / "glanz.pgm").read_bytes())
    glanz.end()
    embree.end()
    return {"model": model, "about": about, "embree": embree.about, "results": results, "batches": batches}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--models", nargs="+", help="default: all")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--size", default="1920x1080", help="of the picture, pixels")
    parser.add_argument("--mode", choices=["fast", "robust"], default="fast", help="of Embree")
    parser.add_argument("--out", type=pathlib.Path, help="raw results")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for the pictures of Glanz")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        programs = build(folder, "peer_freeform")
        every = subprocess.run([programs[0]], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
        about = {"date": time.strftime("%Y-%m-%d"), "machine": platform.platform(), "mode": arguments.mode,
                 "size": arguments.size, "rounds": arguments.rounds, "models": []}
        for model in arguments.models or every:
            about["models"].append(run(model, programs, folder, arguments))
            if arguments.out:
                arguments.out.parent.mkdir(parents=True, exist_ok=True)
                arguments.out.write_text(json.dumps(about, indent=1) + "\n")


main()

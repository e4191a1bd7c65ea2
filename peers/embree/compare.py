#!/usr/bin/env python3
"""Rays per second for a triangle mesh: Glanz and Embree, with the same mesh and the same rays, in one run.

    apt-get install libembree-dev        # Embree 3.13
    peers/embree/compare.py [--shape sphere|grid] [--triangles 1000000] [--rounds 7] [--out benches/results/NAME.json]

Both sides are programs that build their hierarchy once and then time one set of rays at a time, one call per ray
(rtcIntersect1, rtcOccluded1; Mesh::intersect, Mesh::occluded). The sets alternate (Glanz, Embree, Embree robust, Glanz ...),
so that other load on the machine affects all programs alike. The result is the ratio of the medians of processor time; with two
threads the wall-clock time is also measured, which shows the scaling if the machine has no other load. Glanz tests triangles in
f64 without gaps between them, Embree's robust mode does so in f32, and its fast mode does not guarantee it.

Sets: "coherent" (camera rays, line by line), "bounced" (diffuse, from the hits of those), "random" (chords of a sphere).
"""

import argparse
import json
import pathlib
import platform
import statistics
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from sides import Side, build

TASKS = [(rays, query, threads) for rays in ("coherent", "bounced", "random")
         for query in ("closest", "any") for threads in (1, 2)]


def show(task, rates, answers):
    print(f"{task[0]:9} {task[1]:8} {task[2]} thread(s)", end="")
    for clock in ("processor", "clock"):
        medians = {name: statistics.median(rate[clock]) for name, rate in rates.items()}
        print(f" | {clock}:", *(f"{name} {value:.2f}" for name, value in medians.items()), "ratios",
              *(f"{medians['Glanz'] / value:.2f}" for name, value in medians.items() if name != "Glanz"), end="")
    print(" | hits", *(hits for hits, _ in answers.values()), flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--shape", choices=["sphere", "grid"], default="sphere")
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--out", type=pathlib.Path, help="raw results")
    parser.add_argument("--modes", nargs="+", default=["fast", "robust"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        glanz, embree = build(folder, "peer_embree")
        sides = [Side("Glanz", [glanz, folder, arguments.shape, arguments.triangles])]
        sides += [Side(f"Embree {mode}", [embree, folder, mode]) for mode in arguments.modes]
        for side in sides:
            print(f"{side.name}: built in {side.about}")
        results = []
        for task in TASKS:
            # Million rays per second of processor time and of wall-clock time.
            rates = {side.name: {"processor": [], "clock": []} for side in sides}
            answers = {}
            for _ in range(arguments.rounds):
                for side in sides:
                    clock, processors, rays, hits, total = side.ask(*task)
                    rates[side.name]["processor"].append(rays / processors * 1e3)
                    rates[side.name]["clock"].append(rays / clock * 1e3)
                    answers[side.name] = (hits, total)
            results.append({"rays": task[0], "query": task[1], "threads": task[2], "million_rays_per_second": rates,
                            "hits_and_sum_of_t": answers})
            show(task, rates, answers)
    if arguments.out:
        about = {"date": time.strftime("%Y-%m-%d"), "machine": platform.platform(),
                 "sides": {side.name: side.about for side in sides}, "results": results}
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(json.dumps(about, indent=1) + "\n")


main()

"""Runs `glanz illuminate` and measures its processor time."""

import json
import os
import pathlib
import resource
import subprocess
import sys

from lux_map import LuxMap

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def built() -> str:
    """The path of the command line."""
    cargo = ["cargo", "build", "--release", "-p", "glanz-cli", "--bin", "glanz", "--message-format=json"]
    messages = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    lines = [json.loads(line) for line in messages.splitlines()]
    return str(next(line["executable"] for line in lines if line.get("executable")))


def measured(command: list[object], **more: object) -> float:
    """Runs a program; returns its processor seconds."""
    words = [str(word) for word in command]
    print("$", *words, file=sys.stderr, flush=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, **more)  # type: ignore[call-overload]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def illuminate(program: str, scene: pathlib.Path, to: pathlib.Path, goal: list[object], seed: int, threads: int, *more: object) -> float:
    """Writes the maps of a scene to a folder; returns processor seconds, including reading and writing.

    `goal`: the option that ends the calculation, with its value."""
    command = [program, "illuminate", scene, "-o", to, *goal, "--seed", seed, "--threads", threads, "--quiet", *more]
    return measured(command, env=os.environ | {"RAYON_NUM_THREADS": str(threads)})


def read(folder: pathlib.Path, receivers: list[str]) -> list[LuxMap]:
    return [LuxMap.read(folder / f"{name.replace(' ', '-')}.csv") for name in receivers]

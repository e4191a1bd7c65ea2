"""The two sides of a comparison with Embree: programs that answer each line of input with one line of output."""

import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent


def build(folder, example):
    """Compiles the example of glanz-geometry and the Embree program into `folder`; returns the paths of both."""
    embree = folder / "embree"
    subprocess.run(["gcc", "-O3", "-march=native", "-Wall", "-Wextra", "-o", embree, HERE / "embree" / "embree.c",
                    "-lembree3", "-lpthread", "-lm"], check=True)
    cargo = ["cargo", "build", "--release", "-p", "glanz-geometry", "--example", example, "--message-format=json"]
    messages = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    built = [json.loads(line) for line in messages.splitlines()]
    glanz = next(m["executable"] for m in built if m.get("target", {}).get("name") == example and m.get("executable"))
    return glanz, embree


class Side:
    """A program that answers each line of input with one line of output. Its first line describes it."""

    def __init__(self, name, command):
        self.name = name
        self.process = subprocess.Popen([str(c) for c in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.about = self.read()

    def read(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"{self.name} ended unexpectedly")
        return line.strip()

    def say(self, *task):
        print(*task, file=self.process.stdin, flush=True)
        return self.read()

    def ask(self, *task):
        """Wall-clock nanoseconds, nanoseconds of processor time, number of rays, number of hits, sum of the results."""
        clock, processors, rays, hits, total = self.say(*task).split()
        return float(clock), float(processors), int(rays), int(hits), float(total)

    def end(self):
        self.process.stdin.close()
        self.process.wait()

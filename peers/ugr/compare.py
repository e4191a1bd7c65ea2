"""Tables of UGR of Glanz and of eulumdat-ugr (https://pypi.org/project/eulumdat-ugr), room by room, for two luminaires.

    pip install eulumdat-ugr
    python3 peers/ugr/compare.py --glanz FILE
"""

import argparse
import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from eulumdat_ugr import UgrCalculator
from pyldt import LdtReader

PLANES = range(0, 360, 15)
GAMMAS = range(0, 181, 5)
LUMENS = 4000


def panel(c, gamma):
    """Lambertian."""
    return max(0.0, math.cos(math.radians(gamma)))


def strip(c, gamma):
    """Wide across the luminaire (C0), narrow along it."""
    return panel(c, gamma) ** (1.0 + 2.0 * math.cos(math.radians(c)) ** 2)


def flux(shape):
    """Lumens of 1 cd on the axis, by a midpoint rule."""
    steps = range(360)
    zone = [math.cos(math.radians(k / 2)) - math.cos(math.radians((k + 1) / 2)) for k in steps]
    cells = ((c, k) for c in range(0, 360, 3) for k in steps)
    return sum(shape(c + 1.5, k / 2 + 0.25) * zone[k] * math.radians(3) for c, k in cells)


def write(path, shape, length, width):
    """An EULUMDAT file that is symmetric to both planes; millimetres."""
    scale = 1000 / flux(shape)
    lines = ["Maker", 2, 4, len(PLANES), 15, len(GAMMAS), 5, "report", "luminaire", 1, path.name, 2026]
    lines += [length, width, 80, length, width, 0, 0, 0, 0, 100, 100, 1, 0, 1]
    lines += [1, "LED", LUMENS, 4000, 80, 30] + 10 * [0.5] + list(PLANES) + list(GAMMAS)
    lines += [f"{scale * shape(c, gamma):.5f}" for c in PLANES if c <= 90 for gamma in GAMMAS]
    path.write_text("".join(f"{line}\r\n" for line in lines))


def compare(path, glanz):
    peer = np.array(UgrCalculator.compute(LdtReader.read(str(path))).values)
    told = subprocess.run([glanz, "info", path, "--ugr", "--json"], capture_output=True, text=True, check=True)
    rows = json.loads(told.stdout)["ugr"]
    keys = [key for key in rows[0] if "wise" in key]
    own = np.array([[row[key] for key in keys] for row in rows])
    apart = own - peer
    print(f"{path.stem}: largest difference {np.abs(apart).max():.2f}, mean {apart.mean():+.3f}")
    for row, a, b in zip(rows, own, peer):
        pairs = "  ".join(f"{a[i]:5.2f} {b[i]:5.2f}" for i in (0, 4, 5, 9))
        print(f"  {row['x_heights']:2.0f}H x {row['y_heights']:2.0f}H  {pairs}")


if __name__ == "__main__":
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--glanz", default="target/release/glanz")
    program = arguments.parse_args().glanz
    print("Glanz and eulumdat-ugr: across 70/50/20, across 30/30/20, along 70/50/20, along 30/30/20")
    with tempfile.TemporaryDirectory() as folder:
        for name, shape, length, width in [("panel", panel, 600, 600), ("strip", strip, 1200, 200)]:
            path = Path(folder) / f"{name}.ldt"
            write(path, shape, length, width)
            compare(path, program)

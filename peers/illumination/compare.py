#!/usr/bin/env python3
"""Compares illuminance maps of Glanz with those of Radiance and Mitsuba 3; README.md describes usage and results."""

import argparse
import dataclasses
import datetime
import json
import pathlib
import platform
import statistics
import time

import numpy

import glanz
import lux_map
import mirror
import pictures
import radiance
import room
from luminaire import Luminaire, asymmetric
from lux_map import Agreement, LuxMap

Report = dict[str, object]

# Triangles along an edge of the mirror.
CUTS = {"mitsuba": 1024, "radiance": 256}

# Cells along a wall; fewer for photons, so that each has enough of them for a normal distribution.
CELLS, PHOTON_CELLS = 32, 16


def report_agreement(what: str, names: list[str], ours: list[LuxMap], theirs: list[LuxMap]) -> Report:
    """Prints and returns the agreement of maps, of all together and of each."""
    found = {"all": Agreement.of(ours, theirs)}
    found |= {name: Agreement.of([a], [b]) for name, a, b in zip(names, ours, theirs, strict=True)}
    for name, agreement in found.items():
        print(f"{what}, {name}: {agreement.text()}", flush=True)
    return {name: dataclasses.asdict(agreement) for name, agreement in found.items()}


def office(program: str, asked: argparse.Namespace) -> Report:
    """Direct light of the luminaires, then light of all bounces."""
    luminaire = Luminaire.read(asked.ies) if asked.ies else asymmetric()
    folder = asked.work / "office"
    room.write(folder, luminaire)
    receivers, heights = list(room.RECEIVERS), list(room.RECEIVERS.values())
    report: Report = {"luminaire": asked.ies.name if asked.ies else "own", "lumens": luminaire.flux()}
    goal = ["--error", asked.error] if asked.error else ["--rays", asked.rays]
    for scene, bounces in (("black", 0), ("office", asked.bounces)):
        to = folder / f"glanz-{scene}"
        used = {"glanz": glanz.illuminate(program, folder / f"{scene}.pbrt", to, goal, 0, asked.threads)}
        ours = glanz.read(to, receivers)
        tree = radiance.octree(folder, scene)
        parts = asked.parts if bounces else min(asked.parts, 20)
        peers = [radiance.lux_map(tree, height, parts, bounces, asked.divisions, asked.threads) for height in heights]
        theirs = [one for one, _ in peers]
        used["radiance"] = sum(seconds for _, seconds in peers)
        report[scene] = {"processor_seconds": used, "agreement": report_agreement(f"{scene}, Radiance", receivers, ours, theirs)}
        if not bounces:
            exact = [room.closed_form(luminaire, height) for height in heights]
            report["closed form"] = report_agreement("black, closed form", receivers, ours, exact)
            report["Radiance at points"] = at_points(tree, luminaire, asked.threads)
        if asked.pictures:
            pictures.draw(asked.pictures / f"{scene}-desk.png", f"{scene}, desk", ours[0], theirs[0], "Radiance")
    return report


def at_points(tree: pathlib.Path, luminaire: Luminaire, threads: int) -> Report:
    """Radiance's direct light at points of the desk's plane against I cos / d^2.

    Points on the edge of a shadow may be lit in one and not in the other: these differ by more than a thousandth and are
    counted. The relative differences are those of the others.
    """
    random = numpy.random.default_rng(1)
    points = numpy.append(random.random((10000, 2)) * room.SIZE[:2], numpy.full((10000, 1), room.RECEIVERS["desk"]), axis=1)
    theirs, _ = radiance.illuminance(tree, points, 0, 0, threads)
    exact = room.direct(luminaire, points)
    relative = numpy.abs(theirs - exact) / numpy.maximum(exact, 1e-9)
    edge = relative > 1e-3
    others = relative[~edge & (exact > 0)]
    found: Report = {"points": len(points), "more than 0.1 % apart": int(edge.sum())}
    found |= {"largest of the others": float(others.max()), "mean of the others": float(others.mean())}
    print("Radiance at points:", found, flush=True)
    return found


def reflector(program: str, asked: argparse.Namespace) -> Report:
    """The room without and with a hood, behind which there is only light of the mirror; Radiance's photons against both."""
    (asked.work / "hooded.pbrt").write_text(mirror.hooded_scene())
    report: Report = {"triangles": {name: cuts**2 for name, cuts in CUTS.items()}}
    report["bare"], bare = by_particles(program, mirror.SCENE, False, asked)
    report["hooded"], hooded = by_particles(program, asked.work / "hooded.pbrt", True, asked)
    if asked.photons:
        report["radiance"] = by_photons(bare, hooded[:1], asked)
    return report


def by_particles(program: str, scene: pathlib.Path, hooded: bool, asked: argparse.Namespace) -> tuple[Report, list[LuxMap]]:
    """Traces Glanz and Mitsuba alternately for all rounds; returns the report and Glanz's maps, means over the rounds."""
    import mitsuba_particles

    begun = time.process_time()
    mesh = mirror.tessellated(mirror.control_points(), CUTS["mitsuba"])
    peer = mitsuba_particles.Particles(mesh, hooded, CELLS, asked.threads)
    report: Report = {"mitsuba's seconds before the first particle": time.process_time() - begun}
    ours, theirs, rounds = [], [], []
    for seed in range(1, asked.rounds + 1):
        to = asked.work / f"{scene.stem}-{seed}"
        walls = ["--room", *[mirror.SIZE] * 3, "--cells", CELLS]
        seconds = glanz.illuminate(program, scene, to, ["--rays", asked.rays], seed, asked.threads, *walls)
        ours.append(glanz.read(to, mirror.WALLS))
        found, count, used = peer.trace(asked.rays, seed)
        theirs.append(found)
        rounds.append({"glanz": cost(ours[-1], asked.rays, seconds), "mitsuba": cost(found, count, used)})
    means = [[lux_map.mean([seed[wall] for seed in maps]) for wall in range(6)] for maps in (ours, theirs)]
    report |= {"agreement": report_agreement(f"{scene.stem}, Mitsuba", mirror.WALLS, *means), "rounds": rounds, "medians": medians(rounds)}
    if asked.rounds > 1:
        report["variance found per stated"] = {"glanz": lux_map.variance_found(ours), "mitsuba": lux_map.variance_found(theirs)}
    print(report["medians"], report.get("variance found per stated"), flush=True)
    if asked.pictures:
        wall = 0 if hooded else 5
        title = f"{mirror.WALLS[wall]} of the room of document 000{', the mirror alone' if hooded else ''}"
        pictures.draw(asked.pictures / f"{scene.stem}.png", title, means[0][wall], means[1][wall], "Mitsuba")
    return report, means[0]


def by_photons(bare: list[LuxMap], hooded: list[LuxMap], asked: argparse.Namespace) -> Report:
    """Compares all photons with all light, and those from the mirror with the light of the mirror on the wall x = 0."""
    import photons

    tree = photons.write(asked.work / "photons", mirror.tessellated(mirror.control_points(), CUTS["radiance"]))
    direct, direct_count, direct_seconds = photons.arrivals(tree, "direct", asked.photons, PHOTON_CELLS)
    caustic, caustic_count, caustic_seconds = photons.arrivals(tree, "caustic", asked.photons // 4, PHOTON_CELLS)
    report: Report = {"photons": {"direct": direct_count, "caustic": caustic_count}}
    report["processor_seconds"] = {"direct": direct_seconds, "caustic": caustic_seconds}
    coarse = [[wall.coarser(CELLS // PHOTON_CELLS) for wall in walls] for walls in (bare, hooded)]
    theirs = [mirror.maps(sums[0], sums[1], None, PHOTON_CELLS) for sums in (direct + caustic, caustic)]
    report["all light"] = report_agreement("reflector, Radiance", mirror.WALLS, coarse[0], theirs[0])
    report["the mirror's"] = report_agreement("hooded, Radiance", mirror.WALLS[:1], coarse[1], theirs[1][:1])
    return report


def cost(walls: list[LuxMap], particles: int, seconds: float) -> dict[str, float]:
    """Rates, and processor seconds until the standard error of a wall's brightest cell is 1 %."""
    found = {"processor_seconds": seconds, "particles": particles, "particles_per_second": particles / seconds}
    for name in ("wall x=0", "ceiling"):
        wall = walls[mirror.WALLS.index(name)]
        peak = wall.lux.argmax()
        found[f"seconds to 1 % of the peak, {name}"] = float(seconds * (100 * wall.errors[peak] / wall.lux[peak]) ** 2)
    return found


def medians(rounds: list[dict[str, dict[str, float]]]) -> dict[str, dict[str, float]]:
    """Medians over the rounds for both programs, and of the ratios of Glanz to Mitsuba within each round."""
    keys = list(rounds[0]["glanz"])
    found = {name: {key: statistics.median(one[name][key] for one in rounds) for key in keys} for name in ("glanz", "mitsuba")}
    found["ratio"] = {key: statistics.median(one["glanz"][key] / one["mitsuba"][key] for one in rounds) for key in keys}
    return found


def processor() -> str:
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=40, help="Radiance uses twice the square of this number of points per cell")
    parser.add_argument("--only", choices=["office", "reflector"])
    parser.add_argument("--ies", type=pathlib.Path, help="a file of type C instead of the generated luminaire")
    parser.add_argument("--rays", type=int, default=20_000_000, help="particles of Glanz and of Mitsuba per run")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of the reflector")
    parser.add_argument("--photons", type=int, default=2_000_000, help="direct photons of Radiance; 0: none")
    parser.add_argument("--error", type=float, help="office by Glanz's default method until this error, instead of particles")
    parser.add_argument("--bounces", type=int, default=24, help="bounces of Radiance")
    parser.add_argument("--divisions", type=int, default=1, help="rays that Radiance continues with from every point")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--glanz", help="the program; default: it is built")
    parser.add_argument(
        "--work", type=pathlib.Path, default=glanz.ROOT / "target" / "illumination", help="folder for scenes and maps"
    )
    parser.add_argument("--out", type=pathlib.Path, help="raw results")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for pictures of both maps and their difference")
    asked = parser.parse_args()
    asked.work = asked.work.resolve()
    return asked


def main() -> None:
    asked = options()
    for folder in (asked.work, asked.pictures):
        if folder:
            folder.mkdir(parents=True, exist_ok=True)
    program = asked.glanz or glanz.built()
    settings = {key: value for key, value in vars(asked).items() if isinstance(value, (int, float))}
    report: Report = {"date": datetime.date.today().isoformat(), "processor": processor(), "system": platform.platform()}
    report |= {"radiance": radiance.version(), "settings": settings}
    report["normal"] = {str(k): lux_map.expected(k) for k in lux_map.BEYOND}
    for name, compared in (("office", office), ("reflector", reflector)):
        if asked.only in (None, name):
            report[name] = compared(program, asked)
            if asked.out:
                asked.out.write_text(json.dumps(report, indent=1) + "\n")


if __name__ == "__main__":
    main()

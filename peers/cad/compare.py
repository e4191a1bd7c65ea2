#!/usr/bin/env python3
"""STEP and IGES files: what Glanz has made of them against what OpenCascade says.

    VENV/bin/python peers/cad/reference.py FILES -o REF/
    cargo build --release -p glanz-formats --example peer_cad
    VENV/bin/python peers/cad/compare.py REF GLANZ [--files FOLDER ...] [--program target/release/examples/peer_cad]
                                         [--markdown] [--list 20]
    peers/cad/compare.py --self-test

REF and GLANZ are files or folders of files with the same names; `--program` first writes GLANZ, with PROGRAM FILE.step REF.json for each
file found in a folder of `--files`. The format of REF.json stands in reference.py; GLANZ.json (metres) is

    faces    [{entity, kind, area, status: "read"|"repaired"|"refused", reason, width}]: every face entity of the file once, in the
             coordinates of its part; area null where refused; reason (string or null) of repairs and refusals; width of the
             overlap at its edges (or null). Entries of entities that are no faces are printed, nothing else
    solids   [{volume, area, bounds: [min, max]}]: every occurrence of a solid; further fields are ignored
    rays     for each ray of REF the list of its hits, ascending: [t, entity] or {t, entity}; t counts from the ray's origin

Compared:

    faces    refused at most 1 in 100, of all files together
    areas    within 1e-4 relative; 3 in 1000 may differ, of all files together, and are listed. With --files, an area that differs is
             integrated from the 3D curves of the edges (edge_integral.py), without the parameter curves of either side: where that confirms
             Glanz within 1e-4, the area is `explained` and does not count
    widths   those beyond the accuracy and 10 times the distance of the edges from the surface and each other are listed (needs --files)
    solids   volume and area within 1e-4 relative, bounds within 1e-4 of the size; solids are paired by their bounds
    rays     hits are paired if they lie within the accuracy (the file's uncertainty, at least 1e-7 of the size) of each other,
             measured along the normal; best on the same face. Hits without partner, and pairs of different faces, are
               edge       if the hit, projected along the ray, is within the accuracy of an edge of its face
               loose      the same with the tolerance that OpenCascade has given the edges of the face, whose curves stray further than the
                          file's uncertainty, or with the measured distance between the nearest edge and the surfaces of its faces (needs
                          --files)
               tangent    if the ray is within the accuracy of touching a surface of the file's size
               refused    if Glanz has refused the face or does not mention it
               twice      if OpenCascade has the hit twice, off edges
               ghost      if OpenCascade misses it: the point lies on the face within the accuracy, off its edges (needs --files, with which
                          OpenCascade measures the distances of the points of Glanz; where it finds no nearer point than the edges, the
                          foot on the surface counts if the 3D curves of the edges enclose it), and Glanz has it once
               wrong      otherwise: listed, and none may be

The exit code is 1 if anything is beyond that. `ghost` counts for Glanz because the distance of a point to a face is found by another
algorithm than the intersections. Where all faces belong to closed solids, a ray has an even number of hits: the numbers of those with an
odd one are printed, too, but judged by tests of Glanz. Faces that OpenCascade misreads in files of models.py are printed; the shape from
before they were written takes their place (reference.py).
"""

import argparse
import collections
import json
import math
import pathlib
import subprocess
import sys
import time

AREA = 1e-4
VOLUME = 1e-4
BOUNDS = 1e-4
DIFFERENT_AREAS = 3e-3
REFUSED = 1e-2

# Least accuracy, of the size: both sides work with tolerances of their own.
LEAST_ACCURACY = 1e-7

# Relative difference of the distances from a face and from its edges below which the nearest point is on an edge.
EDGE = 1e-6

# Tolerance of the feet of edges where their distances from the surface are measured, of the size of the face; and the factor by which a
# width may exceed them.
LOOSENESS, WIDE = 1e-6, 10

EXCEPTIONS = ("edge", "loose", "tangent", "refused", "twice", "ghost")


def relative(value, reference):
    if value is None or reference is None:
        return math.inf
    return abs(value - reference) / abs(reference) if reference else float(value != reference)


class Arbiter:
    """Distances of points to the faces of a file, from OpenCascade, and areas of faces from their edges alone."""

    def __init__(self, path, deflection):
        from edges import Boundary
        from iges import open_file
        from step import METRE, explore
        from OCP.TopAbs import TopAbs_EDGE
        self.boundary, self.deflection, self.metre = Boundary, deflection / METRE, METRE
        self.faces, self.boundaries, self.integrals, self.strays = collections.defaultdict(list), {}, {}, {}
        self.sharing = collections.defaultdict(dict)
        file = open_file(path)
        for face in file.faces():
            self.faces[file.entity(face)].append(face)
            for edge in explore(face, TopAbs_EDGE):
                self.sharing[edge.TShape()][face.TShape()] = face

    def area(self, entity):
        """Area of a face from its edges, the same with splines continued beyond their ends, and what the edges look like; or why not."""
        from edge_integral import Undecided, area_from_edges
        faces = {face.TShape(): face for face in self.faces.get(entity, [])}
        try:
            areas = [area_from_edges(face) for face in faces.values()]
        except Undecided as reason:
            return None, None, str(reason)
        area, extended = (sum(a[i] for a in areas) for i in range(2))
        error, stray, gap = (max((a[i] for a in areas), default=0.0) for i in range(2, 5))
        beyond = f", {extended} beyond the ends of the surface" if relative(extended, area) > AREA / 10 else ""
        return area, extended, f"{area} within {error:.1g}{beyond}; edges {stray:.2g} m off the surface, gaps {gap:.2g} m"

    def looseness(self, entity):
        """Largest distance of the edges of a face from its surface and from each other, metres; infinite if unknown."""
        from edge_integral import EdgeIntegral, Undecided
        result = 0.0
        for face in self.faces.get(entity, []):
            try:
                integral = EdgeIntegral(face)
                integral.area(LOOSENESS, 1)
            except Undecided:
                return math.inf
            result = max(result, integral.stray * self.metre, integral.gap * self.metre)
        return result

    def stray(self, entity, point):
        """Largest distance between the edge of a face that is nearest to a point and the surfaces of the faces of that edge, metres."""
        from edge_integral import Undecided, stray_of_edge
        nearest = min((self.boundary(face, self.deflection).nearest([x / self.metre for x in point])
                       for face in self.faces.get(entity, [])), key=lambda found: found[0], default=(None, None))[1]
        if nearest is None:
            return 0.0
        if nearest.TShape() not in self.strays:
            faces = self.sharing[nearest.TShape()].values()
            try:
                stray = max((stray_of_edge(nearest, face) for face in faces), default=0.0)
            except Undecided:
                stray = 0.0
            self.strays[nearest.TShape()] = stray * self.metre
        return self.strays[nearest.TShape()]

    def distance(self, key, face, point):
        """Distance to the part of the surface that the 3D curves of the edges enclose; infinite if they do not decide."""
        from edge_integral import EdgeIntegral, Undecided
        from OCP.gp import gp_Pnt
        try:
            if key not in self.integrals:
                self.integrals[key] = EdgeIntegral(face)
            return self.integrals[key].distance(gp_Pnt(*point).Transformed(face.Location().Transformation().Inverted()))
        except Undecided:
            return math.inf

    def ask(self, entity, point):
        """Distances to the nearest occurrence of the face, and to its edges, metres."""
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
        from OCP.BRepExtrema import BRepExtrema_DistShapeShape
        from OCP.gp import gp_Pnt
        from step import FAILURES
        point = [x / self.metre for x in point]
        vertex, best = BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex(), (math.inf, math.inf)
        for number, face in enumerate(self.faces.get(entity, [])):
            try:
                extrema = BRepExtrema_DistShapeShape(vertex, face)
            except FAILURES:
                extrema = None
            distance = extrema.Value() if extrema and extrema.IsDone() else math.inf
            key = (entity, number)
            if key not in self.boundaries:
                self.boundaries[key] = self.boundary(face, self.deflection)
            edge = float(self.boundaries[key].distances([point])[0])
            if distance > edge * (1 - EDGE):
                distance = min(distance, self.distance(key, face, point))
            best = min(best, (distance, edge))
        return best[0] * self.metre, best[1] * self.metre


Hit = collections.namedtuple("Hit", "t entity edge cosine")


class RayComparison:
    """Counts of rays and hits by class, and the wrong hits."""

    def __init__(self, reference, glanz, arbiter):
        self.reference, self.arbiter = reference, arbiter
        self.size = math.dist(*reference["bounds"]) if reference["bounds"] else 0.0
        self.accuracy = max(reference["uncertainty"] or 0.0, LEAST_ACCURACY * self.size)
        self.counts, self.wrong, self.rays, self.agree = collections.Counter(), [], len(reference["rays"]), 0
        self.deviation = 0.0
        entities = [face["entity"] for face in reference["faces"]]
        self.tolerances = {face["entity"]: face.get("tolerance") or 0.0 for face in reference["faces"]}
        self.odd = self.odd_rays(reference, glanz)
        self.known = {face["entity"] for face in glanz["faces"] if face["status"] != "refused"}
        if len(glanz["rays"]) != self.rays:
            raise ValueError(f"{reference['file']}: {self.rays} rays against {len(glanz['rays'])}")
        for number, (ours, theirs) in enumerate(zip(glanz["rays"], reference["hits"])):
            theirs = [Hit(t, entities[face], edge, cosine) for t, face, edge, cosine in theirs]
            ours = [Hit(*((hit["t"], hit["entity"]) if isinstance(hit, dict) else hit), None, None) for hit in ours]
            self.ray(number, ours, theirs)

    @staticmethod
    def odd_rays(reference, glanz):
        """Rays of Glanz with an odd number of hits; None where not everything is a closed solid."""
        occurrences = sum(face["occurrences"] for face in reference["faces"])
        if not all(solid.get("closed") for solid in reference["solids"]) or occurrences != sum(s["faces"] for s in reference["solids"]):
            return None
        return sum(len(hits) % 2 for hits in glanz["rays"])

    def ray(self, number, ours, theirs):
        found = [self.judge(number, side, hit, ours, theirs) for side, hit in self.unpaired(ours, theirs)]
        self.counts.update(kind for kind, _ in found)
        wrong = [text for kind, text in found if kind == "wrong"]
        if wrong:
            self.wrong.append((number, ours, theirs, wrong))
        self.agree += not found

    def unpaired(self, ours, theirs):
        """Hits of one side alone, and those of OpenCascade that have a partner on another face ("face")."""
        rest = list(ours)
        open_hits = []
        for same_face in (True, False):
            remaining = theirs if same_face else open_hits
            open_hits = []
            for hit in remaining:
                near = [other for other in rest if self.near(hit, other) and (not same_face or hit.entity == other.entity)]
                if not near:
                    open_hits.append(hit)
                    continue
                partner = min(near, key=lambda other: abs(other.t - hit.t))
                rest.remove(partner)
                self.deviation = max(self.deviation, abs(partner.t - hit.t) * hit.cosine)
                if partner.entity != hit.entity:
                    yield "face", hit
        yield from (("missing", hit) for hit in open_hits)
        yield from (("extra", hit) for hit in rest)

    def near(self, hit, other):
        return abs(hit.t - other.t) * hit.cosine <= self.accuracy or abs(hit.t - other.t) <= self.accuracy

    def judge(self, number, side, hit, ours, theirs):
        """Class of a hit, and the sentence for it."""
        if side == "extra":
            return self.judge_extra(number, hit, ours, theirs)
        text = f"{side} #{hit.entity} at t {hit.t:.9g}, {hit.edge:.3g} from an edge, cosine {hit.cosine}"
        border = self.border(hit)
        if border:
            return border, text
        if self.touches(hit):
            return "tangent", text
        if hit.entity not in self.known:
            return "refused", text
        twins = sum(other.entity == hit.entity and self.near(hit, other) for other in theirs)
        if side == "missing" and twins > 1:
            return "twice", text
        return self.strays(number, hit) or "wrong", text

    def border(self, hit):
        """Class of a hit of OpenCascade near an edge, or None."""
        distance = hit.edge * min(hit.cosine, 1.0)
        return "edge" if distance <= self.accuracy else "loose" if distance <= self.tolerances.get(hit.entity, 0.0) else None

    def strays(self, number, hit):
        """"loose" for a hit of OpenCascade that is as near to an edge as that is to its faces, or None."""
        distance = hit.edge * min(hit.cosine, 1.0)
        return "loose" if self.arbiter and distance <= self.arbiter.stray(hit.entity, self.point(number, hit.t)) else None

    def point(self, number, t):
        ray = self.reference["rays"][number]
        return [ray[i] + t * ray[i + 3] for i in range(3)]

    def touches(self, hit):
        return self.size * hit.cosine**2 / 2 <= self.accuracy

    def judge_extra(self, number, hit, ours, theirs):
        text = f"extra #{hit.entity} at t {hit.t:.9g}"
        # Both sides may have hits around the same place of an edge or of a touching surface; those of OpenCascade tell.
        beside = [other for other in theirs if abs(other.t - hit.t) * other.cosine <= 2 * self.accuracy]
        classes = [self.border(other) or ("tangent" if self.touches(other) else None) for other in beside]
        for kind in ("edge", "loose", "tangent"):
            if kind in classes:
                return kind, text
        if self.arbiter is None:
            return "wrong", text
        point = self.point(number, hit.t)
        distance, edge = self.arbiter.ask(hit.entity, point)
        text += f", {distance:.3g} from the face, {edge:.3g} from its edges"
        if edge <= self.accuracy:
            return "edge", text
        if edge <= self.tolerances.get(hit.entity, 0.0):
            return "loose", text
        twins = sum(other.entity == hit.entity and abs(other.t - hit.t) <= self.accuracy for other in ours)
        if distance <= self.accuracy and twins == 1:
            return "ghost", text
        return "loose" if edge <= self.arbiter.stray(hit.entity, point) else "wrong", text


AreaDifference = collections.namedtuple("AreaDifference", "entity kind theirs ours verdict text")


def area_difference(entity, kind, theirs, ours, arbiter):
    """Whose area the edges confirm."""
    if arbiter is None:
        return AreaDifference(entity, kind, theirs, ours, "unasked", "")
    area, extended, text = arbiter.area(entity)
    if area is None:
        return AreaDifference(entity, kind, theirs, ours, "undecided", text)
    sides = [side for side, value in (("Glanz", ours), ("OpenCascade", theirs)) if relative(value, area) <= AREA]
    if "OpenCascade" not in sides and relative(theirs, extended) <= AREA:
        sides.append("OpenCascade beyond the ends of the surface")
    return AreaDifference(entity, kind, theirs, ours, " and ".join(sides) or "neither", text)


class FaceComparison:
    """Numbers of faces by status, and the areas that differ: `explained` are those that the edges confirm for Glanz."""

    def __init__(self, reference, glanz, arbiter=None):
        ours, self.notes = {}, []
        for face in glanz["faces"]:
            if face["entity"] in reference["entities"]:
                ours.setdefault(face["entity"], face)
            else:
                self.notes.append(f"#{face['entity']} {face['status']}: {face['reason']}")
        theirs = collections.defaultdict(list)
        for face in reference["faces"]:
            theirs[face["entity"]].append(face)
        self.unnumbered = len(theirs.pop(None, []))
        self.in_file, self.theirs, self.ours = len(reference["entities"]), len(reference["faces"]), len(ours)
        self.status = collections.Counter(face["status"] for face in ours.values())
        self.refused = [(entity, face["reason"]) for entity, face in ours.items() if face["status"] == "refused"]
        self.forgotten = sorted(set(reference["entities"]) - set(ours))
        self.only_ours = sorted(entity for entity in ours if entity not in theirs)
        self.width = max((face.get("width") or 0.0 for face in ours.values()), default=0.0)
        self.compared, self.largest, self.different = 0, 0.0, []
        for entity, faces in sorted(theirs.items()):
            face = ours.get(entity)
            if face is None or face["status"] == "refused":
                continue
            areas = [f["area"] for f in faces]
            area = None if None in areas else sum(areas)
            self.compared += 1
            deviation = relative(face["area"], area)
            if deviation <= AREA:
                self.largest = max(self.largest, deviation)
            else:
                self.different.append(area_difference(entity, face["kind"], area, face["area"], arbiter))
        size = math.dist(*reference["bounds"]) if reference["bounds"] else 0.0
        accuracy = max(reference["uncertainty"] or 0.0, LEAST_ACCURACY * size)
        self.wide = []
        for entity, face in sorted(ours.items()) if arbiter else ():
            width = face.get("width") or 0.0
            if width > accuracy and width > WIDE * max(looseness := arbiter.looseness(entity), LEAST_ACCURACY * size):
                self.wide.append(f"#{entity} {face['kind']}: width {width:.2g} m, edges within {looseness:.2g} m; {face['reason']}")
        self.explained = sum(difference.verdict.startswith("Glanz") for difference in self.different)


class SolidComparison:
    """Solids paired by their bounds: largest deviations and what is beyond."""

    def __init__(self, reference, glanz):
        size = math.dist(*reference["bounds"]) if reference["bounds"] else 1.0
        rest, self.beyond, self.volume, self.bounds = list(glanz["solids"]), [], 0.0, 0.0
        theirs = [solid for solid in reference["solids"] if solid.get("bounds")]
        self.theirs, self.ours = len(reference["solids"]), len(rest)
        if self.theirs != self.ours:
            self.beyond.append(f"{self.theirs} solids against {self.ours}")

        def distance(one, other):
            return max(abs(x - y) for p, q in zip(one["bounds"], other["bounds"]) for x, y in zip(p, q)) / size

        for solid in theirs:
            if not rest:
                break
            # Volumes break ties of solids with the same bounds.
            partner = min(rest, key=lambda other: distance(solid, other) + relative(other["volume"], solid["volume"]) * BOUNDS)
            rest.remove(partner)
            volume, area = (relative(partner[x], solid[x]) for x in ("volume", "area"))
            bounds = distance(solid, partner)
            self.volume, self.bounds = max(self.volume, volume), max(self.bounds, bounds)
            if not (volume <= VOLUME and area <= VOLUME and bounds <= BOUNDS):
                self.beyond.append(f"#{solid['entity']}: volume {solid['volume']} against {partner['volume']}, "
                                   f"area {solid['area']} against {partner['area']}, bounds differ by {bounds:.2g} of the size")


class FileComparison:
    def __init__(self, reference, glanz, path=None):
        self.name = reference["file"]
        size = math.dist(*reference["bounds"]) if reference["bounds"] else 0.0
        arbiter = Arbiter(path, 1e-4 * size) if path and size else None
        self.faces, self.solids = FaceComparison(reference, glanz, arbiter), SolidComparison(reference, glanz)
        self.rays = RayComparison(reference, glanz, arbiter)
        self.odd, self.misread = len(reference["odd"]), reference.get("misread", [])

    def report(self, limit):
        faces, solids, rays = self.faces, self.solids, self.rays
        print(f"{self.name}: {faces.in_file} faces in the file, OpenCascade {faces.theirs}, Glanz {faces.ours} ({dict(faces.status)})")
        print(f"  areas: {faces.compared - len(faces.different)} of {faces.compared} agree, within {faces.largest:.2g}, "
              f"{faces.explained} explained, {len(faces.different) - faces.explained} wrong; width up to {faces.width:.2g} m")
        lists = [("not mentioned by Glanz", [f"#{entity}" for entity in faces.forgotten]),
                 ("besides", faces.notes),
                 ("refused", [f"#{entity}: {reason}" for entity, reason in faces.refused]),
                 ("not in OpenCascade", [f"#{entity}" for entity in faces.only_ours]),
                 ("area differs", [f"#{entity} {kind}: OpenCascade {theirs}, Glanz {ours}, edges {text} -> {verdict}"
                                   for entity, kind, theirs, ours, verdict, text in faces.different]),
                 ("too wide", faces.wide),
                 ("solid", solids.beyond)]
        for title, lines in lists:
            self.items(title, lines, limit)
        self.items("misread by OpenCascade:", [f"#{entity} with the area {area}" for entity, area in self.misread], limit)
        if faces.unnumbered:
            print(f"  {faces.unnumbered} faces of OpenCascade have no number")
        print(f"  solids: OpenCascade {solids.theirs}, Glanz {solids.ours}; volumes within {solids.volume:.2g}, "
              f"bounds within {solids.bounds:.2g} of the size")
        print(f"  rays: {rays.agree} of {rays.rays} agree, paired hits within {rays.deviation:.2g} m "
              f"(accuracy {rays.accuracy:.2g} m); hits "
              + ", ".join(f"{rays.counts[kind]} {kind}" for kind in (*EXCEPTIONS, "wrong")) + f"; {len(rays.wrong)} wrong rays")
        if rays.odd is not None:
            print(f"  rays with an odd number of hits: OpenCascade {self.odd}, Glanz {rays.odd}")
        self.items("ray", [f"{number}: {'; '.join(wrong)} | OpenCascade {line(theirs)} | Glanz {line(ours)}"
                           for number, ours, theirs, wrong in rays.wrong], limit)

    @staticmethod
    def items(title, lines, limit):
        for text in lines[:limit]:
            print(f"    {title} {text}")
        if len(lines) > limit:
            print(f"    ... {len(lines) - limit} more ({title})")

    def row(self):
        faces, solids, rays = self.faces, self.solids, self.rays
        return [self.name, faces.in_file, faces.theirs, faces.status["read"], faces.status["repaired"], faces.status["refused"],
                f"{faces.compared - len(faces.different)} / {faces.compared}", faces.explained, f"{faces.largest:.1e}",
                f"{faces.width:.1e}", solids.theirs,
                f"{solids.volume:.1e}", f"{solids.bounds:.1e}", f"{rays.agree} / {rays.rays}",
                *(rays.counts[kind] for kind in (*EXCEPTIONS, "wrong"))]


COLUMNS = ["file", "faces", "OpenCascade", "read", "repaired", "refused", "areas agree", "explained", "within", "width, m", "solids",
           "volume within", "bounds within", "rays agree", *EXCEPTIONS, "wrong"]


def line(hits):
    return "[" + ", ".join(f"{hit.t:.9g} #{hit.entity}" for hit in hits) + "]"


def failures(files):
    """What is beyond the limits, as sentences."""
    result = []
    faces = sum(file.faces.in_file for file in files)
    refused = sum(len(file.faces.refused) + len(file.faces.forgotten) for file in files)
    if refused > REFUSED * faces:
        result.append(f"{refused} of {faces} faces are refused or not mentioned")
    compared, explained = (sum(getattr(file.faces, name) for file in files) for name in ("compared", "explained"))
    wrong = sum(len(file.faces.different) for file in files) - explained
    if wrong > DIFFERENT_AREAS * compared:
        result.append(f"{wrong} of {compared} areas are wrong, {explained} more differ and are explained")
    for file in files:
        if file.solids.beyond:
            result.append(f"{file.name}: solids differ")
        if file.rays.wrong:
            result.append(f"{file.name}: {len(file.rays.wrong)} wrong rays")
    return result


def table(files):
    rows = [COLUMNS, ["---"] * len(COLUMNS), *(file.row() for file in files)]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def pairs(reference, glanz):
    if reference.is_dir():
        return [(path, glanz / path.name) for path in sorted(reference.glob("*.json"))]
    return [(reference, glanz)]


def step_file(folders, name):
    return next((folder / name for folder in folders if (folder / name).is_file()), None)


def run_program(program, path, reference, glanz):
    """Writes the JSON of Glanz; returns what went wrong, or None."""
    if path is None:
        return f"{reference.name}: no STEP file in the folders"
    start = time.perf_counter()
    with open(glanz, "wb") as output:
        done = subprocess.run([program, path, reference], stdout=output, stderr=subprocess.PIPE)
    if done.returncode:
        glanz.unlink()
        return f"{path.name}: {program.name} ended with {done.returncode}: {done.stderr.decode(errors='replace').strip()[-300:]}"
    print(f"{path.name}: Glanz took {time.perf_counter() - start:.2f} s", file=sys.stderr)
    return None


def made():
    """Two faces, two solids and three rays in numbers, as OpenCascade and as Glanz would report them."""
    rays = [[x, 0.5, 1, 0, 0, -1, 2] for x in (0.5, 0.25, 0.0)]
    face = {"entity": 7, "kind": "plane", "area": 1.0, "status": "read", "occurrences": 1, "tolerance": 1e-4}
    solid = {"entity": 3, "closed": True, "faces": 1, "volume": 2.0, "area": 6.0, "bounds": [[0, 0, 0], [1, 1, 1]]}
    reference = {"file": "made", "entities": [7, 8], "uncertainty": 1e-5, "bounds": [[0, 0, 0], [1, 1, 1]],
                 "faces": [face, {**face, "entity": 8, "area": 2.0}], "solids": [solid, {**solid, "volume": 1.0}], "odd": [],
                 "rays": rays, "hits": [[[1.0, 0, 0.5, 1.0]], [[1.0, 0, 0.25, 1.0], [1.5, 1, 0.25, 0.5]], [[1.0, 0, 5e-6, 1.0]]]}
    ours = {**face, "reason": None, "width": 1e-6}
    glanz = {"faces": [ours, {**ours, "entity": 8, "area": 2.0}], "solids": [{**solid, "volume": 1.0}, solid],
             "rays": [[[1.0, 7]], [[1.0, 7], {"t": 1.500019, "entity": 8}], [[1.0, 7]]]}
    return reference, glanz


def self_test():
    reference, glanz = made()
    ours, solid = glanz["faces"][0], reference["solids"][0]

    def test(fails, counts=None, arbiter=None, ref=None, **changes):
        file = FileComparison({**reference, **(ref or {})}, {**glanz, **changes})
        if arbiter:
            file.rays = RayComparison({**reference, **(ref or {})}, {**glanz, **changes}, arbiter)
        assert bool(failures([file])) == fails, (failures([file]), changes)
        assert counts is None or +file.rays.counts == collections.Counter(counts), (file.rays.counts, counts)
        table([file])
        return file

    def of_first(hits):
        return [hits, *glanz["rays"][1:]]

    class Judge:
        def __init__(self, *distances):
            self.ask, self.stray = lambda entity, point: distances, lambda entity, point: 2e-4

    class Edges:
        def __init__(self, area, extended=None):
            self.area = lambda entity: (area, extended or area, "made")
            self.looseness = lambda entity: 1e-6

    # The edges confirm Glanz, OpenCascade, neither, OpenCascade beyond the ends, or nobody.
    for area, extended, explained, verdict in ((1.0003, None, 1, "Glanz"), (1.0, None, 0, "OpenCascade"), (1.1, None, 0, "neither"),
                                               (1.0003, 1.0, 1, "Glanz and OpenCascade beyond the ends of the surface"),
                                               (None, None, 0, "undecided")):
        theirs = [{**ours, "area": 1.0003}, glanz["faces"][1]]
        faces = FaceComparison(reference, {**glanz, "faces": theirs}, Edges(area, extended))
        assert (faces.explained, faces.different[0].verdict) == (explained, verdict), faces.different
        file = test(True, faces=theirs)
        file.faces = faces
        assert bool(failures([file])) != bool(explained)
    wide = FaceComparison(reference, {**glanz, "faces": [{**ours, "width": 2e-5}, glanz["faces"][1]]}, Edges(1.0))
    assert [text.split()[0] for text in wide.wide] == ["#7"]

    # A note about something else is no refused face.
    test(False, faces=[*glanz["faces"], {**ours, "entity": 99, "status": "refused"}])
    # Equal but for 1.9e-5 m along a ray whose cosine is 0.5.
    same = test(False, {})
    assert (same.rays.agree, same.rays.odd) == (3, 2)
    test(True, faces=[{**ours, "area": 1.0002}, glanz["faces"][1]])
    test(False, faces=[{**ours, "area": 1.00009}, glanz["faces"][1]])
    test(True, faces=[{**ours, "area": None, "status": "refused", "reason": "no"}, glanz["faces"][1]])
    test(True, faces=[ours])
    test(True, {"refused": 1}, faces=[ours], rays=[glanz["rays"][0], [[1.0, 7]], glanz["rays"][2]])
    test(True, faces=[{**ours, "area": math.nan}, glanz["faces"][1]])
    test(True, solids=[{**solid, "volume": 1.0}, {**solid, "volume": math.nan}])
    test(True, solids=[solid])
    test(True, solids=[{**solid, "volume": 1.0}, {**solid, "volume": 2.1}])
    test(True, solids=[{**solid, "volume": 1.0}, {**solid, "bounds": [[0, 0, 0], [1, 1, 1.01]]}])
    # A hit that is missing, too far, of another face: wrong, but at the edge.
    test(True, {"wrong": 1}, rays=of_first([]))
    test(True, {"wrong": 2}, rays=of_first([[1.00003, 7]]))
    test(True, {"wrong": 1}, rays=of_first([[1.0, 8]]))
    test(False, {"edge": 1}, rays=[*glanz["rays"][:2], []])
    test(False, {"edge": 1}, rays=[*glanz["rays"][:2], [[1.0, 8]]])
    test(False, {"loose": 1}, rays=[*glanz["rays"][:2], []], ref={"hits": [*reference["hits"][:2], [[1.0, 0, 5e-5, 1.0]]]})
    # Two hits of Glanz at an edge instead of one.
    test(False, {"edge": 1}, rays=[*glanz["rays"][:2], [[1.0, 7], [1.0, 8]]])
    # One more hit: wrong, unless OpenCascade finds the point on the face or at its edge.
    more = of_first([[0.5, 8], [1.0, 7]])
    test(True, {"wrong": 1}, rays=more)
    test(True, {"wrong": 1}, Judge(1e-4, 0.1), rays=more)
    test(False, {"ghost": 1}, Judge(1e-6, 0.1), rays=more)
    test(False, {"edge": 1}, Judge(1e-6, 1e-6), rays=more)
    # As near to an edge as that is to its faces.
    test(False, {"loose": 1}, Judge(1e-4, 2e-4), rays=more)
    test(False, {"loose": 1}, Judge(), rays=of_first([]), ref={"hits": [[[1.0, 0, 2e-4, 1.0]], *reference["hits"][1:]]})
    test(True, {"wrong": 1}, Judge(1e-6, 0.1), rays=of_first([[1.0, 7], [1.0, 7]]))
    # OpenCascade has a hit twice; a ray touches.
    test(False, {"twice": 1}, ref={"hits": [[[1.0, 0, 0.5, 1.0], [1.0, 0, 0.5, 1.0]], *reference["hits"][1:]]})
    test(False, {"tangent": 2}, ref={"hits": [[[1.0, 0, 0.5, 1.0], [1.2, 1, 0.5, 1e-3], [1.201, 1, 0.5, 1e-3]], *reference["hits"][1:]]})
    print("the tests of the comparison pass")


def main():
    parser = argparse.ArgumentParser(description="Compares Glanz with OpenCascade; the top of the program describes formats and limits.")
    parser.add_argument("reference", nargs="?", type=pathlib.Path)
    parser.add_argument("glanz", nargs="?", type=pathlib.Path)
    parser.add_argument("--files", nargs="+", type=pathlib.Path, default=[], help="folders of the STEP files")
    parser.add_argument("--program", type=pathlib.Path, help="writes the files of Glanz first")
    parser.add_argument("--markdown", action="store_true", help="print the table alone")
    parser.add_argument("--list", type=int, default=20, help="items of each list")
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    if arguments.self_test:
        return self_test()
    if arguments.glanz is None:
        parser.error("REF and GLANZ are needed")
    files, missing = [], []
    for reference, glanz in pairs(arguments.reference, arguments.glanz):
        data = json.loads(reference.read_text())
        path = step_file(arguments.files, data["file"])
        failure = run_program(arguments.program, path, reference, glanz) if arguments.program else None
        if failure or not glanz.exists():
            missing.append(failure or f"{data['file']}: Glanz has written nothing")
            continue
        files.append(FileComparison(data, json.loads(glanz.read_text()), path))
        if not arguments.markdown:
            files[-1].report(arguments.list)
    if arguments.markdown:
        print(table(files))
    beyond = missing + failures(files)
    print(*beyond, sep="\n", file=sys.stderr)
    return int(bool(beyond))


if __name__ == "__main__":
    sys.exit(main())

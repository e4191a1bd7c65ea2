"""Area of a face from its surface and the 3D curves of its edges alone: no parameter curve of anybody.

Every edge is cut at its knots into panels; the Gauss points of a panel are projected orthogonally onto the surface, in closed form or by
Newton's method from the point before, and the polynomial through their parameters is the parameter curve; panels are halved until its
last coefficients are below a tolerance. Ends of consecutive edges are joined by straight segments of the parameters. Green's theorem
then gives the area as the integral of F(u, v) du (or dv), where F integrates the area element from a base: across the direction in which
no loop winds. The tolerance falls, and the pieces of each panel grow in number, until the area stands.
"""

import functools
import itertools
import math

import numpy

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.BRepTools import BRepTools
from OCP.collections import Array1_double
from OCP.GeomAbs import GeomAbs_CN, GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus
from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FORWARD, TopAbs_VERTEX, TopAbs_WIRE
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

from step import FAILURES, METRE, explore

ORDER = 8
NODES, WEIGHTS = numpy.polynomial.legendre.leggauss(ORDER)
VANDERMONDE = numpy.linalg.inv(numpy.polynomial.legendre.legvander(NODES, ORDER - 1))
ENDS = numpy.polynomial.legendre.legvander([-1.0, 1.0], ORDER - 1) @ VANDERMONDE
DENSE = numpy.polynomial.legendre.legvander(numpy.linspace(-1, 1, 33), ORDER - 1) @ VANDERMONDE

# Relative change of the area at the last halving.
ACCURACY = 1e-8

# Evaluations of the surface after which the tolerance falls no more.
ENOUGH = 1_000_000

# Tolerances of the parameter curves, of the face's size, with 1, 2, 3, ... pieces of each panel; halvings of a panel at most.
TOLERANCES, DEPTH = (1e-6, 1e-8, 1e-9, 1e-10, 1e-10, 1e-10), 30

# Steps of Newton's method, and their relative size at the end.
STEPS, LAST_STEP = 30, 1e-13

# Points per direction from which the nearest is taken where OpenCascade does not project.
GRID = 33

# Steps from the nearest point of the grid towards a foot, of which most are halvings.
SEARCHES = 200

# Panels between two knots of an edge whose distance from a surface is measured.
PANELS = 4

# Distance from the surface, of the diagonal of the edge, beyond which a projection is searched anew on the whole surface.
LOST = 1e-3


class Undecided(Exception):
    """Why the edges do not give an area."""


def breaks(count, fill):
    array = Array1_double(1, count + 1)
    fill(array)
    return [array.Value(i) for i in range(1, count + 2)]


def coordinates(point):
    return numpy.array((point.X(), point.Y(), point.Z()))


def straight(start, end):
    """Parameters (ORDER, 2) of a segment."""
    return numpy.outer((1 - NODES) / 2, start) + numpy.outer((1 + NODES) / 2, end)


class Carrier:
    """A surface: projections onto it, periods, and integrals of its area element."""

    def __init__(self, face):
        self.adaptor = surface = BRepAdaptor_Surface(face, False)
        self.geometry, self.kind, self.evaluations = BRep_Tool.Surface_s(face), surface.GetType(), 0
        self.bounds = BRepTools.UVBounds_s(face)
        self.point, self.tangents = gp_Pnt(), (gp_Vec(), gp_Vec())
        self.domain = ((surface.FirstUParameter(), surface.LastUParameter()), (surface.FirstVParameter(), surface.LastVParameter()))
        closed = (surface.IsUPeriodic() or surface.IsUClosed(), surface.IsVPeriodic() or surface.IsVClosed())
        self.periods = tuple(last - first if is_closed else 0.0 for (first, last), is_closed in zip(self.domain, closed))
        self.periodic = surface.IsUPeriodic(), surface.IsVPeriodic()
        self.elementary = {GeomAbs_Plane: "Plane", GeomAbs_Cylinder: "Cylinder", GeomAbs_Cone: "Cone", GeomAbs_Sphere: "Sphere",
                           GeomAbs_Torus: "Torus"}.get(self.kind)
        if self.elementary:
            self.shape = getattr(surface, self.elementary)()
            frame = self.shape.Position()
            self.origin = coordinates(frame.Location())
            self.axes = numpy.array([coordinates(axis()) for axis in (frame.XDirection, frame.YDirection, frame.Direction)])
        else:
            self.knots = (breaks(surface.NbUIntervals(GeomAbs_CN), lambda array: surface.UIntervals(array, GeomAbs_CN)),
                          breaks(surface.NbVIntervals(GeomAbs_CN), lambda array: surface.VIntervals(array, GeomAbs_CN)))

    def inside(self, value, direction):
        """The parameter in the domain, of a closed surface that has no period."""
        if self.periods[direction] and not self.periodic[direction]:
            return self.domain[direction][0] + (value - self.domain[direction][0]) % self.periods[direction]
        return value

    def evaluate(self, u, v):
        self.evaluations += 1
        self.adaptor.D1(self.inside(u, 0), self.inside(v, 1), self.point, *self.tangents)
        return self.point, *self.tangents

    def element(self, u, v):
        _, along_u, along_v = self.evaluate(u, v)
        return along_u.Crossed(along_v).Magnitude()

    def clipped(self, feet):
        """The feet (n, 2) on the surface as far as it goes: a spline ends at its last knots."""
        if self.elementary:
            return feet
        limits = [(-math.inf, math.inf) if period else domain for domain, period in zip(self.domain, self.periods)]
        return numpy.clip(feet, *zip(*limits))

    def near(self, parameters, guess):
        """The parameters moved by periods to the guess."""
        return tuple(value + period * round((near - value) / period) if period else value
                     for value, near, period in zip(parameters, guess, self.periods))

    def project(self, position, guess, lost):
        """Parameters of the foot of a position (gp_Pnt) near the guess."""
        if self.elementary:
            local = self.axes @ (coordinates(position) - self.origin)
            found = self.project_elementary(*local.tolist())
        else:
            found = self.newton(position, guess) if guess else None
            if found is None or self.distance(position, found) > lost:
                found = self.search(position, guess)
        return self.near(found, guess) if guess else found

    def distance(self, position, parameters):
        return position.Distance(self.evaluate(*parameters)[0])

    def project_elementary(self, x, y, z):
        angle, radius = math.atan2(y, x), math.hypot(x, y)
        if self.elementary == "Plane":
            return x, y
        if self.elementary == "Cylinder":
            return angle, z
        if self.elementary == "Sphere":
            return angle, math.atan2(z, radius)
        # Of both generators in the plane of the axis and the position, that which is nearer.
        both = []
        if self.elementary == "Torus":
            major, minor = self.shape.MajorRadius(), self.shape.MinorRadius()
            for turned, r in ((0.0, radius), (math.pi, -radius)):
                both.append((abs(math.hypot(r - major, z) - minor), (angle + turned, math.atan2(z, r - major))))
            return min(both)[1]
        half, reference = self.shape.SemiAngle(), self.shape.RefRadius()
        for turned, r in ((0.0, radius), (math.pi, -radius)):
            along = (r - reference) * math.sin(half) + z * math.cos(half)
            off = (r - reference) * math.cos(half) - z * math.sin(half)
            both.append((abs(off), (angle + turned, along)))
        return min(both)[1]

    def newton(self, position, guess):
        """Solves for the point whose difference is normal, with the curvature of the surface neglected (the difference is small)."""
        u, v = guess
        for _ in range(STEPS):
            point, along_u, along_v = self.evaluate(u, v)
            offset = gp_Vec(point, position)
            uu, uv, vv = along_u.Dot(along_u), along_u.Dot(along_v), along_v.Dot(along_v)
            right_u, right_v, determinant = offset.Dot(along_u), offset.Dot(along_v), uu * vv - uv * uv
            if not determinant > 1e-14 * uu * vv:
                return None
            step_u, step_v = (vv * right_u - uv * right_v) / determinant, (uu * right_v - uv * right_u) / determinant
            for_u, for_v = self.limits(step_u, 0), self.limits(step_v, 1)
            u, v = u + for_u, v + for_v
            if abs(for_u) <= LAST_STEP * self.width(0) and abs(for_v) <= LAST_STEP * self.width(1):
                return u, v
        return u, v

    def width(self, direction):
        first, last = self.domain[direction]
        return min(last - first, max(abs(self.knots[direction][0]), abs(self.knots[direction][-1]), 1.0))

    def limits(self, step, direction):
        most = 0.2 * self.width(direction)
        return max(-most, min(most, step))

    def search(self, position, guess):
        try:
            projection = GeomAPI_ProjectPointOnSurf(position, self.geometry)
        except FAILURES:
            return self.search_grid(position)
        if not projection.NbPoints():
            raise Undecided("a point of an edge has no foot on the surface")
        feet = [(projection.Distance(i), projection.Parameters(i)) for i in range(1, projection.NbPoints() + 1)]
        least = min(distance for distance, _ in feet)
        best = [foot for distance, foot in feet if distance <= 2 * least + 1e-9]
        best = min(best, key=lambda foot: math.dist(self.near(foot, guess), guess)) if guess else best[0]
        return self.newton(position, best) or best

    def search_grid(self, position):
        """The foot from the nearest point of a grid within the bounds of the face, by Newton's method; beside a pole, where that finds none, by
        steps to the nearest of the points around, ever shorter ones."""
        u, v = (numpy.linspace(*ends, GRID).tolist() for ends in (self.bounds[:2], self.bounds[2:]))
        best = min(((one, other) for one in u for other in v), key=lambda parameters: self.distance(position, parameters))
        found = self.newton(position, best)
        if found is not None:
            return found
        steps, least = [(ends[-1] - ends[0]) / (GRID - 1) for ends in (u, v)], self.distance(position, best)
        for _ in range(SEARCHES):
            around = [(best[0] + i * steps[0], best[1] + j * steps[1]) for i in (-1, 0, 1) for j in (-1, 0, 1)]
            found = [(self.distance(position, foot), foot) for foot in map(tuple, self.clipped(numpy.array(around)).tolist())]
            nearest = min(found)
            if nearest[0] < least:
                least, best = nearest
            else:
                steps = [step / 2 for step in steps]
        return best

    def knots_between(self, low, high, direction):
        (first, _), period = self.domain[direction], self.periods[direction]
        shifts = range(math.floor((low - first) / period), math.floor((high - first) / period) + 1) if period else (0,)
        return sorted({knot + shift * period for shift in shifts for knot in self.knots[direction]
                       if low < knot + shift * period < high})

    def crossings(self, start, end):
        """Shares of a straight segment at which it crosses knots."""
        if self.elementary:
            return []
        return sorted((knot - one) / (other - one) for direction, (one, other) in enumerate(zip(start, end))
                      for knot in self.knots_between(min(one, other), max(one, other), direction))

    def strip(self, u, v, across, base, pieces):
        """Integral of the area element from the base to the point, along parameter `across` (0 or 1)."""
        if self.elementary:
            return self.strip_elementary(u, v, across, base)
        at, fixed = (u, v)[across], (u, v)[1 - across]
        low, high = min(base, at), max(base, at)
        cuts = [low, *self.knots_between(low, high, across), high]
        total = 0.0
        for first, last in zip(cuts, cuts[1:]):
            half = (last - first) / pieces / 2
            for piece in range(pieces):
                centre = first + half * (2 * piece + 1)
                for node, weight in zip(NODES.tolist(), WEIGHTS.tolist()):
                    place = centre + half * node
                    total += half * weight * (self.element(place, fixed) if across == 0 else self.element(fixed, place))
        return total if at >= base else -total

    def strip_elementary(self, u, v, across, base):
        if across == 0:
            return (u - base) * self.density(v)
        return self.primitive(v) - self.primitive(base)

    def density(self, v):
        """Area element, which depends on v alone."""
        shape = self.shape
        return {"Plane": lambda: 1.0, "Cylinder": lambda: shape.Radius(),
                "Cone": lambda: abs(shape.RefRadius() + v * math.sin(shape.SemiAngle())),
                "Sphere": lambda: shape.Radius()**2 * math.cos(v),
                "Torus": lambda: shape.MinorRadius() * abs(shape.MajorRadius() + shape.MinorRadius() * math.cos(v))}[self.elementary]()

    def primitive(self, v):
        shape = self.shape
        if self.elementary == "Plane":
            return v
        if self.elementary == "Cylinder":
            return shape.Radius() * v
        if self.elementary == "Cone":
            radius = shape.RefRadius() + v * math.sin(shape.SemiAngle())
            return radius * abs(radius) / 2 / math.sin(shape.SemiAngle())
        if self.elementary == "Sphere":
            return shape.Radius()**2 * math.sin(v)
        major, minor = shape.MajorRadius(), shape.MinorRadius()
        # Where a torus meets itself, the distance from the axis changes its sign.
        change = math.acos(max(-1.0, -major / minor))
        at_change, half = (minor * (major * angle + minor * math.sin(angle)) for angle in (change, math.pi))
        turns = round(v / (2 * math.pi))
        rest = v - 2 * math.pi * turns
        value = minor * (major * rest + minor * math.sin(rest))
        if abs(rest) > change:
            value = math.copysign(2 * at_change, rest) - value
        return value + turns * 2 * (2 * at_change - half)

    def pole(self, above):
        """Parameter v of the point that a winding loop encloses."""
        if self.elementary == "Cone":
            return -self.shape.RefRadius() / math.sin(self.shape.SemiAngle())
        if self.elementary not in (None, "Sphere"):
            raise Undecided("a loop winds around a surface without poles")
        return self.domain[1][1 if above else 0]

    def total(self):
        """Area of a surface without boundary."""
        if self.elementary == "Sphere":
            return 4 * math.pi * self.shape.Radius()**2
        if self.elementary == "Torus":
            return 2 * math.pi * (self.primitive(2 * math.pi) - self.primitive(0.0))
        return None


class Segment:
    """An edge as it is passed in its loop."""

    def __init__(self, shape, face):
        self.edge, self.face = TopoDS.Edge(shape), face
        self.forward = shape.Orientation() == TopAbs_FORWARD
        self.degenerate = BRep_Tool.Degenerated_s(self.edge)
        if self.degenerate:
            point = BRep_Tool.Pnt_s(TopoDS.Vertex(next(explore(shape, TopAbs_VERTEX))))
            self.start = self.end = coordinates(point)
        else:
            curve = self.curve = BRepAdaptor_Curve(self.edge)
            if not curve.Is3DCurve():
                raise Undecided("an edge has no 3D curve")
            cuts = breaks(curve.NbIntervals(GeomAbs_CN), lambda array: curve.Intervals(array, GeomAbs_CN))
            self.cuts = cuts if self.forward else cuts[::-1]
            self.start, self.end = (coordinates(curve.Value(cut)) for cut in (self.cuts[0], self.cuts[-1]))

    def jump(self):
        """Change of the parameters along an edge that is a point of the surface."""
        curve = BRepAdaptor_Curve2d(self.edge, self.face)
        first, last = curve.Value(curve.FirstParameter()), curve.Value(curve.LastParameter())
        sign = 1 if self.forward else -1
        return sign * (last.X() - first.X()), sign * (last.Y() - first.Y())

    def positions(self, first, last):
        centre, half = (first + last) / 2, (last - first) / 2
        return [self.curve.Value(centre + half * node) for node in NODES.tolist()]


def stray_of_edge(edge, face):
    """Largest distance of an edge from the surface of one of its faces, at Gauss points between its knots, mm."""
    face = TopoDS.Face(face.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD))
    segment, carrier = Segment(edge.Located(TopLoc_Location()), face), Carrier(face)
    positions = [position for first, last in zip(segment.cuts, segment.cuts[1:])
                 for low, high in itertools.pairwise(numpy.linspace(first, last, PANELS + 1).tolist())
                 for position in segment.positions(low, high)]
    size = max(map(positions[0].Distance, positions))
    guess, result = None, 0.0
    for position in positions:
        guess = carrier.project(position, guess, LOST * size)
        foot = carrier.clipped(numpy.array([guess]))[0].tolist()
        result = max(result, carrier.distance(position, foot))
    return result


def ordered(segments):
    """The segments in the order in which each begins where the one before ends."""
    return min(segments, segments[::-1], key=lambda chain: sum(gaps(chain)))


def gaps(chain):
    return [math.dist(one.end, other.start) for one, other in zip(chain, chain[1:] + chain[:1])]


class EdgeIntegral:
    """Area of a face in mm2; `stray` and `gap` are the largest distances of its edges from the surface and from each other, mm."""

    def __init__(self, face, bounded=True):
        self.bounded, self.polygons = bounded, None
        self.face = TopoDS.Face(face.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD))
        self.carrier, self.stray = Carrier(self.face), 0.0
        self.loops = [ordered([Segment(edge, self.face) for edge in explore(wire, TopAbs_EDGE)])
                      for wire in explore(self.face, TopAbs_WIRE)]
        self.gap = max((gap for loop in self.loops for gap in gaps(loop)), default=0.0)
        points = [coordinates(point) for loop in self.loops for segment in loop if not segment.degenerate
                  for first, last in zip(segment.cuts, segment.cuts[1:]) for point in segment.positions(first, last)]
        if not points:
            raise Undecided("the face has no edges")
        self.size = float(numpy.linalg.norm(numpy.ptp(points, axis=0)))

    def converged(self, accuracy=ACCURACY):
        """Area and its relative change at the last halving."""
        area, change = None, math.inf
        for pieces, tolerance in enumerate(TOLERANCES, 1):
            finer = self.area(tolerance, pieces)
            change = abs(finer - area) / abs(finer) if area is not None and finer else math.inf
            area = finer
            if change <= accuracy or self.carrier.evaluations > ENOUGH:
                break
        return area, change

    def distance(self, position):
        """Distance of a position from the nearest point of the surface; infinite if the edges do not enclose that point."""
        foot = self.carrier.project(position, None, math.inf)
        return self.carrier.distance(position, foot) if self.encloses(foot) else math.inf

    def encloses(self, foot):
        """Whether the loops wind around the parameters, in any period."""
        if self.polygons is None:
            paths = [self.path(loop, TOLERANCES[1], 1) for loop in self.loops if any(not segment.degenerate for segment in loop)]
            if any(winding[1] for _, winding in paths):
                raise Undecided("a loop winds in v")
            # Loops that wind in u are closed where the area begins, too: at a pole, or anywhere if there are as many of both directions.
            rest = sum(winding[0] for _, winding in paths)
            base = self.carrier.pole(rest > 0) if rest else self.carrier.domain[1][1]
            self.polygons = [numpy.vstack([DENSE @ numpy.array(row[0]) for row in rows]) for rows, _ in paths]
            self.polygons = [numpy.vstack([polygon, [[polygon[-1, 0], base], [polygon[0, 0], base]]]) if winding[0] else polygon
                             for polygon, (_, winding) in zip(self.polygons, paths)]
        shifts = [[k * period for k in range(-2, 3)] if period else [0.0] for period in self.carrier.periods]
        return any(winding_number(self.polygons, foot[0] + u, foot[1] + v) for u in shifts[0] for v in shifts[1])

    def area(self, tolerance, pieces):
        paths = [self.path(loop, tolerance, pieces) for loop in self.loops if any(not segment.degenerate for segment in loop)]
        windings = [path[1] for path in paths]
        if any(w[0] for w in windings) and any(w[1] for w in windings):
            raise Undecided("loops wind in both directions")
        across = 0 if any(w[1] for w in windings) else 1
        rest = sum(w[1 - across] for w in windings)
        base = paths[0][0][0][0][0][across]
        if rest:
            if across == 0:
                raise Undecided("loops wind in v alone")
            base = self.carrier.pole(rest > 0)
        # Counterclockwise, the area is the integral of (integral du) dv and of -(integral dv) du.
        area = (1 if across == 0 else -1) * sum(
            weight * slope[1 - across] * self.carrier.strip(*at, across, base, pieces)
            for path, _ in paths for nodes, slopes, weights in path for at, slope, weight in zip(nodes, slopes, weights)
            if slope[1 - across])
        total = self.carrier.total()
        if total is not None and not rest:
            # A face that is the whole surface has both seams in its loop, whose direction is open where it begins at their crossing.
            return area % total if abs(area) > ACCURACY * total else total
        if area < 0 and any(w[1 - across] for w in windings) and not rest:
            raise Undecided("the area is negative")
        return abs(area)

    def path(self, loop, tolerance, pieces):
        """Nodes, slopes and weights of the parameter curves of a loop, and how often it winds."""
        rows, guess, start, jump = [], None, None, (0.0, 0.0)
        for segment in loop:
            if segment.degenerate:
                jump = tuple(x + y for x, y in zip(jump, segment.jump()))
                continue
            at = tuple(x + y for x, y in zip(guess, jump)) if guess else None
            panels = self.panels(segment, at, tolerance * self.size)
            for feet in panels:
                begin, end = ENDS @ feet
                if start is None:
                    start = begin
                else:
                    rows += self.join(guess, begin, pieces)
                rows.append(row(feet, pieces))
                guess = tuple(end.tolist())
            jump = (0.0, 0.0)
        reached = [x + y for x, y in zip(guess, jump)]
        winding = [round((x - s) / period) if period else 0 for x, s, period in zip(reached, start, self.carrier.periods)]
        rows += self.join(guess, [s + w * period for s, w, period in zip(start, winding, self.carrier.periods)], pieces)
        return rows, winding

    def join(self, start, end, pieces):
        """A straight segment between two edges, cut where it crosses knots of the surface."""
        start, end = numpy.asarray(start), numpy.asarray(end)
        cuts = [0.0, *self.carrier.crossings(start.tolist(), end.tolist()), 1.0]
        return [row(straight(start + first * (end - start), start + last * (end - start)), pieces)
                for first, last in zip(cuts, cuts[1:])]

    def panels(self, segment, guess, tolerance):
        """Parameters (ORDER, 2) of the feet of each panel of an edge."""
        result = []
        open_panels = [(first, last, 0) for first, last in zip(segment.cuts, segment.cuts[1:])][::-1]
        while open_panels:
            first, last, depth = open_panels.pop()
            feet, at, positions = [], guess, segment.positions(first, last)
            for position in positions:
                at = self.carrier.project(position, at, LOST * self.size)
                feet.append(at)
            feet = numpy.array(feet)
            if self.bounded:
                feet = self.carrier.clipped(feet)
            tail = numpy.abs((VANDERMONDE @ feet)[-2:]).max(0)
            _, along_u, along_v = self.carrier.evaluate(*feet[ORDER // 2].tolist())
            if not tail[0] * along_u.Magnitude() + tail[1] * along_v.Magnitude() <= tolerance:
                if depth < DEPTH:
                    middle = (first + last) / 2
                    open_panels += [(middle, last, depth + 1), (first, middle, depth + 1)]
                    continue
                # The foot jumps.
                result += [straight(one, other) for one, other in zip(feet, feet[1:])]
            else:
                result.append(feet)
            self.stray = max(self.stray, *map(self.carrier.distance, positions, feet.tolist()))
            guess = tuple((ENDS[1] @ feet).tolist())
        return result


@functools.cache
def quadrature(pieces):
    """Matrices from the values at the Gauss points of a panel to values and slopes at those of its equal pieces, and the weights."""
    places = ((2 * numpy.arange(pieces)[:, None] + 1 + NODES) / pieces - 1).ravel()
    slopes = [numpy.polynomial.legendre.legval(places, numpy.polynomial.legendre.legder(column)) for column in VANDERMONDE.T]
    return numpy.polynomial.legendre.legvander(places, ORDER - 1) @ VANDERMONDE, numpy.array(slopes).T, \
        (numpy.tile(WEIGHTS, pieces) / pieces).tolist()


def row(feet, pieces):
    """Points, slopes and weights of the integral along a panel."""
    values, slopes, weights = quadrature(pieces)
    return (values @ feet).tolist(), (slopes @ feet).tolist(), weights


def winding_number(polygons, u, v):
    """How often closed polygons wind around a point, together."""
    angle = 0.0
    for polygon in polygons:
        offset = (polygon[:, 0] - u) + 1j * (polygon[:, 1] - v)
        offset = offset[offset != 0]
        angle += float(numpy.angle(numpy.roll(offset, -1) / offset).sum())
    return round(angle / (2 * math.pi))


def area_from_edges(face):
    """Of a face: area (m2), area on the surface with its splines continued beyond their ends, relative error, distance of the edges from
    the surface and gap between them (m)."""
    bounded, extended = EdgeIntegral(face), EdgeIntegral(face, False)
    area, change = bounded.converged()
    return area * METRE**2, extended.converged()[0] * METRE**2, change, bounded.stray * METRE, bounded.gap * METRE

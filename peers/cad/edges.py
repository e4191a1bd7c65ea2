"""Distances of points to the edges of a face."""

import numpy

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.GCPnts import GCPnts_QuasiUniformDeflection
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_Shape
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_EDGE, TopAbs_VERTEX
from OCP.TopoDS import TopoDS, TopoDS_Compound

from step import FAILURES, explore

# Points beside segments in one step of the search.
BLOCK = 1 << 20

# Points of an edge whose deflection cannot be controlled.
SAMPLES = 257

# Parts per smooth part of an edge, into which it is divided before its points follow from the deflection.
PARTS = 5

# Below so many deflections, the distance is that to the curve, else to its polyline.
EXACT = 20


def coordinates(point):
    return point.X(), point.Y(), point.Z()


def polyline(edge, deflection):
    """Points of an edge. It is divided before, the more the more smooth parts it has: of ten turns of a helix, the middle lies on the
    chord, and seems straight."""
    curve = BRepAdaptor_Curve(edge)
    first, last = curve.FirstParameter(), curve.LastParameter()
    if curve.GetType() == GeomAbs_CurveType.GeomAbs_Line:
        ends = numpy.array([first, last])
    else:
        ends = numpy.linspace(first, last, PARTS * curve.NbIntervals(GeomAbs_Shape.GeomAbs_C2) + 1)
    result = []
    for low, high in zip(ends[:-1], ends[1:]):
        part = points_between(curve, deflection, float(low), float(high))
        if part is None:
            return [coordinates(curve.Value(float(u))) for u in numpy.linspace(first, last, SAMPLES)]
        result += part[1:] if result else part
    return result


def points_between(curve, deflection, low, high):
    """Points of a part of a curve; `None` if the deflection cannot be controlled."""
    try:
        points = GCPnts_QuasiUniformDeflection(curve, deflection, low, high)
    except FAILURES:
        return None
    if not points.IsDone() or points.NbPoints() < 2:
        return None
    return [coordinates(points.Value(i)) for i in range(1, points.NbPoints() + 1)]


class Boundary:
    """Edges and vertices of a face, in millimetres."""

    def __init__(self, face, deflection):
        self.deflection = deflection
        starts, ends, self.shapes, owners = [], [], [], []
        for shape in explore(face, TopAbs_EDGE):
            edge = TopoDS.Edge(shape)
            if BRep_Tool.Degenerated_s(edge):
                continue
            points = polyline(edge, deflection)
            starts += points[:-1]
            ends += points[1:]
            owners += [len(self.shapes)] * (len(points) - 1)
            self.shapes.append(edge)
        for shape in explore(face, TopAbs_VERTEX):
            starts.append(coordinates(BRep_Tool.Pnt_s(TopoDS.Vertex(shape))))
            ends.append(starts[-1])
            owners.append(len(self.shapes))
            self.shapes.append(shape)
        self.starts, self.ends = (numpy.array(x, dtype=float).reshape(-1, 3) for x in (starts, ends))
        self.owners = numpy.array(owners, dtype=int)

    def distances(self, points):
        """Distances of points (n, 3): of the curves where they are small, else of polylines within the deflection of the curves."""
        points = numpy.asarray(points, dtype=float).reshape(-1, 3)
        result = numpy.full(len(points), numpy.inf)
        if not len(self.starts):
            return result
        step = max(1, BLOCK // len(self.starts))
        along = self.ends - self.starts
        length = numpy.maximum((along * along).sum(1), 1e-300)
        for first in range(0, len(points), step):
            offset = points[first:first + step, None] - self.starts
            share = numpy.clip((offset * along).sum(2) / length, 0, 1)
            distance = numpy.linalg.norm(offset - share[..., None] * along, axis=2)
            for i, row in enumerate(distance):
                nearest = row.min()
                if nearest < EXACT * self.deflection:
                    nearest = self.exact(points[first + i], self.owners[row < nearest + 2 * self.deflection], nearest)
                result[first + i] = nearest
        return result

    def nearest(self, point):
        """Distance of the edge that is nearest to a point (or polyline), and the edge; without edges, infinity and `None`."""
        best = (numpy.inf, None)
        for owner, shape in enumerate(self.shapes):
            if shape.ShapeType() == TopAbs_EDGE:
                distance = self.exact(numpy.asarray(point), numpy.array([owner]), numpy.inf)
                best = min(best, (distance, shape), key=lambda found: found[0])
        return best

    def exact(self, point, owners, otherwise):
        compound, builder = TopoDS_Compound(), BRep_Builder()
        builder.MakeCompound(compound)
        for owner in set(owners.tolist()):
            builder.Add(compound, self.shapes[owner])
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point.tolist())).Vertex()
        try:
            extrema = BRepExtrema_DistShapeShape(vertex, compound)
            return extrema.Value() if extrema.IsDone() else otherwise
        except FAILURES:
            return otherwise

#!/usr/bin/env python3
"""STEP and IGES files that OpenCascade writes, for the comparison.

    python3 -m venv VENV && VENV/bin/pip install cadquery-ocp matplotlib     # matplotlib for its font
    VENV/bin/python peers/cad/models.py FOLDER [NAME ...]

Every model is written twice, with parameter curves (NAME-pcurves.step) and without (NAME.step), and the schemas AP203, AP214 and AP242 take
turns. Those without products are written as IGES files, too: NAME-faces.igs (trimmed surfaces) and NAME-solids.igs; and NAME.brep, the shape
itself, for files that OpenCascade misreads (written.py). Lengths are millimetres, or inches where the name says so. Printed: faces, volume
and area as OpenCascade has them before writing, and where closed forms are known, the relative deviation from them. Volumes and areas are
those of integral.py.
"""

import argparse
import math
import pathlib

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from OCP.BRep import BRep_Builder
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon, BRepBuilderAPI_MakeSolid,
                                BRepBuilderAPI_MakeWire, BRepBuilderAPI_NurbsConvert)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeChamfer, BRepFilletAPI_MakeFillet
from OCP.BRepGProp import BRepGProp
from OCP.BRepLib import BRepLib
from OCP.BRepOffset import BRepOffset_Skin
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell, BRepOffsetAPI_MakeThickSolid, BRepOffsetAPI_ThruSections
from OCP.BRepTools import BRepTools
from OCP.BRepPrimAPI import (BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism,
                             BRepPrimAPI_MakeRevol, BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus)
from OCP.collections import Array1_gp_Pnt, List_TopoDS_Shape
from OCP.GC import GC_MakeSegment
from OCP.Geom import Geom_BezierCurve, Geom_CylindricalSurface, Geom_ToroidalSurface
from OCP.Geom2d import Geom2d_Line
from OCP.GeomAbs import GeomAbs_Arc, GeomAbs_CurveType
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Dir2d, gp_Elips, gp_Hypr, gp_Parab, gp_Pnt, gp_Pnt2d, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Writer
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shell
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from integral import FaceIntegral
from step import explore

SCHEMAS = ("AP203", "AP214IS", "AP242DIS")
ORIGIN, X, Y, Z = gp_Pnt(0, 0, 0), gp_Dir(1, 0, 0), gp_Dir(0, 1, 0), gp_Dir(0, 0, 1)


def axis(x=0.0, y=0.0, z=0.0, direction=Z):
    return gp_Ax2(gp_Pnt(x, y, z), direction)


def placed(shape, x=0.0, y=0.0, z=0.0, turn=0.0, about=Z):
    place, shift = gp_Trsf(), gp_Trsf()
    place.SetRotation(gp_Ax1(ORIGIN, about), turn)
    shift.SetTranslation(gp_Vec(x, y, z))
    return shape.Moved(TopLoc_Location(shift.Multiplied(place)))


def cut(one, *others):
    for other in others:
        one = BRepAlgoAPI_Cut(one, other).Shape()
    return one


def cylinder(radius, height, *place):
    return BRepPrimAPI_MakeCylinder(axis(*place), radius, height).Shape()


def edges(shape):
    """Every edge once."""
    seen = []
    for edge in explore(shape, TopAbs_EDGE):
        if not any(edge.IsSame(other) for other in seen):
            seen.append(edge)
            yield TopoDS.Edge(edge)


def spline(points):
    array = Array1_gp_Pnt(1, len(points))
    for i, point in enumerate(points, 1):
        array.SetValue(i, gp_Pnt(*point))
    return GeomAPI_PointsToBSpline(array).Curve()


def wire(*curves):
    maker = BRepBuilderAPI_MakeWire()
    for curve in curves:
        maker.Add(curve if hasattr(curve, "TShape") else BRepBuilderAPI_MakeEdge(curve).Edge())
    return maker.Wire()


def sphere_minus_torus():
    return cut(BRepPrimAPI_MakeSphere(20).Shape(), BRepPrimAPI_MakeTorus(20, 5).Shape())


def filleted_box():
    box = BRepPrimAPI_MakeBox(60, 40, 20).Shape()
    maker = BRepFilletAPI_MakeFillet(box)
    for edge in edges(box):
        maker.Add(4, edge)
    return maker.Shape()


def filleted_box_measures():
    """Box, slabs, quarter cylinders and ball."""
    a, b, c, r = 52, 32, 12, 4
    flat, long = 2 * (a * b + b * c + c * a), a + b + c
    return (a * b * c + r * flat + math.pi * r * r * long + 4 / 3 * math.pi * r**3,
            flat + 2 * math.pi * r * long + 4 * math.pi * r * r)


def helix(radius, pitch, turns, start):
    surface = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(0, 0, start), Z), radius)
    line = Geom2d_Line(gp_Pnt2d(0, 0), gp_Dir2d(2 * math.pi, pitch))
    edge = BRepBuilderAPI_MakeEdge(line, surface, 0, turns * math.hypot(2 * math.pi, pitch)).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return wire(edge)


def threaded_rod():
    """M8, pitch 1.25, ten turns, which begin and end in the middle of the rod."""
    pitch, depth, turns, start = 1.25, 0.767, 10, 1.5
    # The seam of the rod lies off the seam of the helix, where the Boolean operation would fail.
    rod = placed(cylinder(4, 16), turn=0.7)
    chamfer = BRepFilletAPI_MakeChamfer(rod)
    for edge in edges(rod):
        if BRepAdaptor_Curve(edge).GetType() == GeomAbs_CurveType.GeomAbs_Circle:
            chamfer.Add(0.8, edge)
    polygon = BRepBuilderAPI_MakePolygon()
    for x, z in ((4.1, -0.6), (4.1, 0.6), (4 - depth, 0.1), (4 - depth, -0.1)):
        polygon.Add(gp_Pnt(x, 0, z + start))
    polygon.Close()
    sweep = BRepOffsetAPI_MakePipeShell(helix(4, pitch, turns, start))
    sweep.SetMode(True)
    sweep.Add(polygon.Wire())
    sweep.Build()
    sweep.MakeSolid()
    return cut(chamfer.Shape(), sweep.Shape())


def hollowed(shape, chosen, thickness, join=GeomAbs_Arc):
    faces = List_TopoDS_Shape()
    for index, face in enumerate(explore(shape, TopAbs_FACE)):
        if index in chosen:
            faces.Append(face)
    maker = BRepOffsetAPI_MakeThickSolid()
    maker.MakeThickSolidByJoin(shape, faces, thickness, 1e-4, BRepOffset_Skin, False, False, join)
    return maker.Shape()


def offset_shell():
    """A bottle with an open neck whose walls are 1.5 mm thick: planes, cylinders, spheres, tori."""
    box = BRepPrimAPI_MakeBox(gp_Pnt(-20, -12, 0), 40, 24, 50).Shape()
    maker = BRepFilletAPI_MakeFillet(box)
    for edge in edges(box):
        maker.Add(4, edge)
    body = BRepAlgoAPI_Fuse(maker.Shape(), cylinder(7, 15, 0, 0, 50)).Shape()
    top = max(enumerate(explore(body, TopAbs_FACE)), key=lambda face: centre(face[1]).Z())[0]
    return hollowed(body, {top}, -1.5)


def offset_freeform():
    """A vase of a spline profile, thickened: its inside is an offset of a surface of revolution."""
    profile = spline([(12, 0, 0), (20, 0, 15), (10, 0, 35), (15, 0, 50)])
    floor = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(12, 0, 0)).Edge()
    roof = BRepBuilderAPI_MakeEdge(gp_Pnt(15, 0, 50), gp_Pnt(0, 0, 50)).Edge()
    back = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 50), gp_Pnt(0, 0, 0)).Edge()
    face = BRepBuilderAPI_MakeFace(wire(floor, profile, roof, back)).Face()
    body = BRepPrimAPI_MakeRevol(face, gp_Ax1(ORIGIN, Z)).Shape()
    top = max(enumerate(explore(body, TopAbs_FACE)), key=lambda face: centre(face[1]).Z())[0]
    return hollowed(body, {top}, -1.2)


def centre(face):
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return properties.CentreOfMass()


def contours(text, size):
    """Closed wires of a text, and whether each is a hole: lines and quadratic Bezier curves of the font of matplotlib."""
    path = TextPath((0, 0), text, size=size, prop=FontProperties(family="DejaVu Sans"))
    maker, corners, here = None, [], None
    for points, code in path.iter_segments(curves=True, simplify=False):
        points = [(float(x), float(y), 0.0) for x, y in points.reshape(-1, 2)]
        if code == path.MOVETO:
            maker, corners, here = BRepBuilderAPI_MakeWire(), [points[-1]], points[-1]
            continue
        if code == path.CLOSEPOLY:
            points = [corners[0]]
        if math.dist(here, points[-1]) > 1e-9:
            poles = Array1_gp_Pnt(1, len(points) + 1)
            for i, point in enumerate([here, *points], 1):
                poles.SetValue(i, gp_Pnt(*point))
            curve = GC_MakeSegment(poles.Value(1), poles.Value(2)).Value() if len(points) == 1 else Geom_BezierCurve(poles)
            maker.Add(BRepBuilderAPI_MakeEdge(curve).Edge())
            corners.append(points[-1])
            here = points[-1]
        if code == path.CLOSEPOLY:
            # Outlines of TrueType run clockwise, holes counterclockwise.
            area = sum(p[0] * q[1] - q[0] * p[1] for p, q in zip(corners, corners[1:]))
            yield maker.Wire(), area > 0


def engraved_cylinder():
    """Letters 1 mm deep, whose walls are planes and extruded Bezier curves."""
    bar = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-32, 0, 0), X), 20, 64).Shape()
    letters = [(BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(outline).Face(), gp_Vec(0, 0, 20)).Shape(), hole)
               for outline, hole in contours("Glanz&8", 12)]
    holes = [placed(shape, -25, -4, 19) for shape, hole in letters if hole]
    return cut(bar, *(cut(placed(shape, -25, -4, 19), *holes) for shape, hole in letters if not hole))


def drilled_plate():
    """Through, blind and countersunk holes, a slot; chamfers on all circles of the upper side."""
    plate = BRepPrimAPI_MakeBox(80, 50, 10).Shape()
    for x in (10, 70):
        for y in (10, 40):
            plate = cut(plate, cylinder(3.3, 10, x, y, 0), BRepPrimAPI_MakeCone(axis(x, y, 6.7), 3.3, 6.6, 3.3).Shape())
    plate = cut(plate, cylinder(12, 6, 40, 25, 4), cylinder(4, 10, 40, 25, 0))
    slot = BRepAlgoAPI_Fuse(BRepAlgoAPI_Fuse(cylinder(2, 10, 22, 8, 0), cylinder(2, 10, 58, 8, 0)).Shape(),
                            BRepPrimAPI_MakeBox(gp_Pnt(22, 6, 0), 36, 4, 10).Shape()).Shape()
    plate = cut(plate, slot)
    maker = BRepFilletAPI_MakeChamfer(plate)
    for edge in edges(plate):
        curve = BRepAdaptor_Curve(edge)
        if curve.GetType() == GeomAbs_CurveType.GeomAbs_Circle and curve.Circle().Radius() in (4, 12):
            maker.Add(0.5, edge)
    return maker.Shape()


def lofted():
    """Ellipse, circle, turned ellipse, point-like end."""
    maker = BRepOffsetAPI_ThruSections(True, False)
    for z, long, short, direction in ((0, 20, 8, X), (15, 10, 9.9, X), (35, 14, 6, Y), (50, 4, 3, Y)):
        maker.AddWire(wire(gp_Elips(gp_Ax2(gp_Pnt(0, z / 10, z), Z, direction), long, short)))
    maker.Build()
    return maker.Shape()


def swept():
    """A rounded profile along a spatial spline."""
    path = wire(spline([(0, 0, 0), (10, 0, 20), (30, 15, 30), (50, 10, 20), (60, -10, 40)]))
    sweep = BRepOffsetAPI_MakePipeShell(path)
    sweep.SetMode(True)
    sweep.Add(wire(gp_Elips(gp_Ax2(ORIGIN, gp_Dir(0.4, 0, 0.9)), 5, 3)), False, True)
    sweep.Build()
    sweep.MakeSolid()
    return sweep.Shape()


# Radii of the degenerate tori; the tube meets the axis at this angle from the outside.
MAJOR, MINOR = 6.0, 10.0
MEETING = math.acos(-MAJOR / MINOR)


def spindle(first, last):
    """Part of a torus whose tube crosses its axis, as a solid."""
    surface = Geom_ToroidalSurface(gp_Ax3(ORIGIN, Z), MAJOR, MINOR)
    face = BRepBuilderAPI_MakeFace(surface, 0, 2 * math.pi, first, last, 1e-7).Face()
    shell, builder = TopoDS_Shell(), BRep_Builder()
    builder.MakeShell(shell)
    builder.Add(shell, face)
    shell.Closed(True)
    solid = BRepBuilderAPI_MakeSolid(shell).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def apple():
    return spindle(-MEETING, MEETING)


def lemon():
    return spindle(MEETING, 2 * math.pi - MEETING)


def spindle_measures(first, last):
    """|pi * integral of (R + r cos v)^2 r cos v dv| and |2 pi r * integral of R + r cos v dv|."""
    def antiderivatives(v):
        sine, cosine, R, r = math.sin(v), math.cos(v), MAJOR, MINOR
        return (math.pi * r * (R * R * sine + R * r * (v + sine * cosine) + r * r * (sine - sine**3 / 3)),
                2 * math.pi * r * (R * v + r * sine))
    return [abs(b - a) for a, b in zip(antiderivatives(first), antiderivatives(last))]


def egg():
    """Revolution of a spline that is nearly half an ellipse; it meets the axis at both poles."""
    points = [(12 * math.cos(a), 0, 20 * math.sin(a)) for a in (math.pi * (k / 8 - 0.5) for k in range(9))]
    points[0], points[-1] = (0, 0, -20), (0, 0, 20)
    back = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 20), gp_Pnt(0, 0, -20)).Edge()
    face = BRepBuilderAPI_MakeFace(wire(spline(points), back)).Face()
    return BRepPrimAPI_MakeRevol(face, gp_Ax1(ORIGIN, Z)).Shape()


# Conics about the z axis, in the plane y = 0, x = -v.
UPRIGHT = gp_Ax2(ORIGIN, gp_Dir(0, -1, 0), Z)
SECTOR = 2 * math.pi / 3


def turned(*profile, angle=2 * math.pi):
    """A closed profile of edges, turned about the z axis."""
    maker = BRepBuilderAPI_MakeWire()
    for edge in profile:
        maker.Add(edge)
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(maker.Wire()).Face(), gp_Ax1(ORIGIN, Z), angle).Shape()


def segment(a, b):
    return BRepBuilderAPI_MakeEdge(gp_Pnt(a[0], 0, a[1]), gp_Pnt(b[0], 0, b[1])).Edge()


def dish():
    """A paraboloid of focal length 50 mm and radius 100 mm, filled to its rim: its profile is a whole parabola, which crosses the axis."""
    return turned(BRepBuilderAPI_MakeEdge(gp_Parab(UPRIGHT, 50), -100.0, 0.0).Edge(), segment((0, 0), (0, 50)), segment((0, 50), (100, 50)))


def paraboloid_area(radius):
    """Of a paraboloid of focal length 50 mm."""
    return 8 / 3 * math.pi * 50**2 * ((1 + radius**2 / 100**2)**1.5 - 1)


def dish_measures():
    return math.pi * 100**2 * 50 / 2, math.pi * 100**2 + paraboloid_area(100)


def dish_sector():
    """A third of its ring from the radius 30 mm on: the parabola crosses the axis beyond the face."""
    inner = 30**2 / 200
    return turned(BRepBuilderAPI_MakeEdge(gp_Parab(UPRIGHT, 50), -100.0, -30.0).Edge(), segment((30, inner), (30, 50)),
                  segment((30, 50), (100, 50)), angle=SECTOR)


def dish_sector_measures():
    """The angle times the integral of (50 - r^2 / 200) r; paraboloid, top, inside, and both sides."""
    turned = (paraboloid_area(100) - paraboloid_area(30)) / (2 * math.pi) + (100**2 - 30**2) / 2 + 30 * (50 - 30**2 / 200)
    side = 50 * (100 - 30) - (100**3 - 30**3) / 600
    return SECTOR * (25 * (100**2 - 30**2) - (100**4 - 30**4) / 800), SECTOR * turned + 2 * side


# The lens ends where the hyperbola of half axes 40 and 30 mm is 20 mm from the axis.
RIM = math.asinh(20 / 30)


def lens():
    """Behind a hyperboloid and before half an ellipsoid, with a rim between."""
    height = 40 * math.cosh(RIM)
    centre = gp_Ax2(gp_Pnt(0, 0, height + 5), gp_Dir(0, -1, 0), Z)
    ellipse = BRepBuilderAPI_MakeEdge(gp_Elips(centre, 25, 20), 1.5 * math.pi, 2 * math.pi).Edge()
    hyperbola = BRepBuilderAPI_MakeEdge(gp_Hypr(UPRIGHT, 40, 30), -RIM, 0.0).Edge()
    return turned(hyperbola, segment((0, 40), (0, height + 30)), ellipse, segment((20, height + 5), (20, height)))


def lens_measures():
    """Half an ellipsoid, the rim, and what a hyperboloid of two sheets cuts out of a cylinder; the area of the hyperboloid is the integral
    of 2 pi 30 sqrt(50^2 w^2 - 40^2), w = z / 40."""
    height = 40 * math.cosh(RIM)
    filled = math.pi * 30**2 * ((height**3 - 40**3) / (3 * 40**2) - (height - 40))

    def antiderivative(w):
        root = math.sqrt(50**2 * w * w - 40**2)
        return 60 * math.pi * (w * root / 2 - 40**2 / 100 * math.log(50 * w + root))
    eccentricity = math.sqrt(1 - (20 / 25)**2)
    ellipsoid = math.pi * 20**2 * (1 + 25 / 20 / eccentricity * math.asin(eccentricity))
    return (2 / 3 * math.pi * 20**2 * 25 + math.pi * 20**2 * 5 + filled,
            ellipsoid + 2 * math.pi * 20 * 5 + antiderivative(height / 40) - antiderivative(1))


def extruded_spline():
    """A prism of a closed spline, and a hole of an ellipse."""
    outer = [(25 * math.cos(a) * (1 + 0.2 * math.cos(3 * a)), 25 * math.sin(a) * (1 + 0.2 * math.cos(3 * a)), 0)
             for a in (2 * math.pi * k / 24 for k in range(25))]
    face = BRepBuilderAPI_MakeFace(wire(spline(outer))).Face()
    hole = BRepBuilderAPI_MakeFace(wire(gp_Elips(axis(), 9, 5))).Face()
    return cut(BRepPrimAPI_MakePrism(face, gp_Vec(3, 0, 12)).Shape(), placed(BRepPrimAPI_MakePrism(hole, gp_Vec(0, 0, 20)).Shape(), z=-2))


def nurbs_plate():
    return BRepBuilderAPI_NurbsConvert(drilled_plate()).Shape()


def nurbs_sphere_minus_torus():
    return BRepBuilderAPI_NurbsConvert(sphere_minus_torus()).Shape()


def void_ball():
    """A solid with two voids."""
    return cut(BRepPrimAPI_MakeSphere(20).Shape(), placed(BRepPrimAPI_MakeSphere(5).Shape(), x=8),
               placed(BRepPrimAPI_MakeBox(6, 6, 6).Shape(), x=-12, y=-3, z=-3))


def assembly():
    """A document: four bolts (head and shank: an assembly of its own) in a plate; colours of parts, of one face and of one instance."""
    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def part(shape, name, *rgb):
        label = shapes.AddShape(shape, False) if shape is not None else shapes.NewShape()
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        if rgb:
            colors.SetColor(label, color(*rgb), XCAFDoc_ColorType.XCAFDoc_ColorSurf)
        return label

    def color(*rgb):
        return Quantity_Color(*rgb, Quantity_TypeOfColor.Quantity_TOC_sRGB)

    def add(to, label, *place):
        return shapes.AddComponent(to, label, placed(BRepPrimAPI_MakeSphere(1).Shape(), *place).Location())

    head_shape = BRepPrimAPI_MakeCylinder(5, 4).Shape()
    head, shank = part(head_shape, "head", 0.8, 0.1, 0.1), part(cylinder(3, 14, 0, 0, -14), "shank", 0.7, 0.7, 0.75)
    shapes.AddSubShape(head, next(explore(head_shape, TopAbs_FACE)))
    colors.SetColor(next(explore(head_shape, TopAbs_FACE)), color(0.1, 0.2, 0.9), XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    bolt = part(None, "bolt")
    add(bolt, head)
    add(bolt, shank)
    plate_shape = BRepPrimAPI_MakeBox(60, 40, 8).Shape()
    holes = [(x, y) for x in (12, 48) for y in (10, 30)]
    plate = part(cut(plate_shape, *(cylinder(3.2, 8, x, y, 0) for x, y in holes)), "plate", 0.2, 0.6, 0.3)
    pair = part(None, "pair")
    top = part(None, "top")
    add(pair, bolt, 12, 10, 8, 0.3)
    add(pair, bolt, 12, 30, 8)
    add(top, plate)
    add(top, pair)
    other = add(top, pair, 60, 40, 0, math.pi)
    colors.SetColor(other, color(0.9, 0.8, 0.1), XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    shapes.UpdateAssemblies()
    return document


# How each is made, and its volume and area in closed form.
MODELS = {"sphere_minus_torus": (sphere_minus_torus, None), "filleted_box": (filleted_box, filleted_box_measures),
          "threaded_rod": (threaded_rod, None), "offset_shell": (offset_shell, None), "offset_freeform": (offset_freeform, None),
          "engraved_cylinder": (engraved_cylinder, None), "drilled_plate": (drilled_plate, None), "lofted": (lofted, None),
          "swept": (swept, None), "apple": (apple, lambda: spindle_measures(-MEETING, MEETING)),
          "lemon": (lemon, lambda: spindle_measures(MEETING, 2 * math.pi - MEETING)), "egg": (egg, None),
          "dish": (dish, dish_measures), "dish_sector": (dish_sector, dish_sector_measures), "lens": (lens, lens_measures),
          "extruded_spline": (extruded_spline, None), "nurbs_plate": (nurbs_plate, None),
          "nurbs_sphere_minus_torus": (nurbs_sphere_minus_torus, None),
          "void_ball": (void_ball, lambda: (4 / 3 * math.pi * (20**3 - 5**3) - 6**3, 4 * math.pi * (20**2 + 5**2) + 6 * 6**2)),
          "assembly": (assembly, None), "assembly_inch": (assembly, None), "drilled_plate_inch": (drilled_plate, None)}


def write(model, path, schema, unit, curves):
    """Writes a shape or a document; the parameters are global ones of OpenCascade."""
    document = isinstance(model, TDocStd_Document)
    writer = STEPCAFControl_Writer() if document else STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.schema", schema)
    Interface_Static.SetCVal_s("write.step.unit", unit)
    Interface_Static.SetIVal_s("write.surfacecurve.mode", int(curves))
    writer = STEPCAFControl_Writer() if document else STEPControl_Writer()
    if document:
        writer.SetColorMode(True)
        writer.SetNameMode(True)
        done = writer.Transfer(model, STEPControl_AsIs)
    else:
        done = writer.Transfer(model, STEPControl_AsIs) == IFSelect_RetDone
    if not done or writer.Write(str(path)) != IFSelect_RetDone:
        raise RuntimeError(f"OpenCascade does not write {path}")


def write_iges(model, path, unit, mode):
    """Writes a shape; `mode`: 0 for trimmed surfaces (144), 1 for solids (186)."""
    writer = IGESControl_Writer("IN" if unit == "INCH" else unit, mode)
    if not writer.AddShape(model):
        raise RuntimeError(f"OpenCascade does not write {path}")
    writer.ComputeModel()
    if not writer.Write(str(path)):
        raise RuntimeError(f"OpenCascade does not write {path}")


def describe(name, model, expected):
    if isinstance(model, TDocStd_Document):
        return f"{name}: document"
    volume = area = 0.0
    faces = list(explore(model, TopAbs_FACE))
    for face in faces:
        part, share, _ = FaceIntegral(face).converged(1e-7)
        area += part
        volume += share if face.Orientation() == TopAbs_FORWARD else -share
    off = [f"{value / closed - 1:.1e}" for value, closed in zip((volume, area), expected())] if expected else []
    return (f"{name}: {len(faces)} faces, volume {volume:.9g} mm3, area {area:.9g} mm2"
            + (f", off by {off[0]} and {off[1]}" if off else ""))


def silence():
    """No statistics of the writer on the standard output."""
    Message.DefaultMessenger_s().ChangePrinters().Clear()


def main():
    silence()
    parser = argparse.ArgumentParser(description="Writes the models of the comparison as STEP files, those without products as IGES files, too.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("names", nargs="*", choices=[[], *MODELS])
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for index, (name, (make, expected)) in enumerate(MODELS.items()):
        if arguments.names and name not in arguments.names:
            continue
        model = make()
        print(describe(name, model, expected), flush=True)
        unit = "INCH" if name.endswith("_inch") else "MM"
        for curves in (True, False):
            path = arguments.folder / f"{name}{'-pcurves' if curves else ''}.step"
            write(model, path, SCHEMAS[index % len(SCHEMAS)], unit, curves)
        if not isinstance(model, TDocStd_Document):
            BRepTools.Write_s(model, str(arguments.folder / f"{name}.brep"))
            for kind, mode in (("faces", 0), ("solids", 1)):
                write_iges(model, arguments.folder / f"{name}-{kind}.igs", unit, mode)


main()

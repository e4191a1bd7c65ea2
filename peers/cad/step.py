"""STEP files as OpenCascade reads them: shapes in millimetres, entity numbers of faces and solids, uncertainty of the file."""

import pathlib
import re
import types

import OCP
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPConstruct import STEPConstruct_UnitContext
from OCP.STEPControl import STEPControl_Reader
from OCP.StepGeom import StepGeom_GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx as UnitsAndUncertainty
from OCP.StepRepr import StepRepr_RepresentationItem
from OCP.TCollection import TCollection_HAsciiString
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location

# OpenCascade converts every file to millimetres.
METRE = 1e-3

# The exceptions of OpenCascade, which have no common class in the binding.
FAILURES = tuple(kind for module in vars(getattr(OCP, "OCP", OCP)).values() if isinstance(module, types.ModuleType)
                 for kind in vars(module).values() if isinstance(kind, type) and issubclass(kind, Exception))

# Comments, strings and the beginnings of entities; the first two are matched so that their contents are not.
TOKENS = re.compile(rb"/\*.*?\*/|'[^']*'|\"[^\"]*\"|#(\d+)\s*=\s*(\w+|\([^;]*)", re.DOTALL)

# Entities whose numbers are of interest: what becomes a face or a solid.
NAMED = re.compile(rb"\w*(FACE|BREP|SHELL)\w*$|RECTANGULAR_TRIMMED_SURFACE$|CURVE_BOUNDED_SURFACE$")
FACE = re.compile(rb"(ADVANCED_|ORIENTED_|SUB)?FACE(_SURFACE)?$")

# Entities that place shapes.
TRANSFORMATION = re.compile(rb"MAPPED_ITEM|ITEM_DEFINED_TRANSFORMATION|FUNCTIONALLY_DEFINED_TRANSFORMATION|CARTESIAN_TRANSFORMATION")


def explore(shape, kind):
    """All sub-shapes of a kind, once per occurrence."""
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def context(entity):
    """Length unit and uncertainty of a context, metres."""
    reader = STEPConstruct_UnitContext()
    reader.ComputeFactors(entity.GlobalUnitAssignedContext())
    unit = reader.LengthFactor() * METRE
    if isinstance(entity, UnitsAndUncertainty):
        reader.ComputeTolerance(entity.GlobalUncertaintyAssignedContext())
    return unit, reader.Uncertainty() * unit if reader.HasUncertainty() else None


class CadFile:
    """What all files that OpenCascade has transferred have: `shape`, `results`, and the entities in `known`.

    `misread`: entities of faces that have another area than before the file was written, with the area that was read (m2); written.py.
    """

    misread = {}

    def label(self, entity):
        """What was set as the number of an entity, or None."""
        raise NotImplementedError

    def entity(self, shape):
        """Number of the entity that a face or solid comes from, or None."""
        key = shape.TShape()
        if key not in self.known:
            self.known[key] = self.find_entity(shape)
        return self.known[key]

    def find_entity(self, shape):
        try:
            # Results are known without their placement.
            entity = self.results.EntityFromShapeResult(shape.Located(TopLoc_Location()), 1)
        except FAILURES:
            return None
        label = self.label(entity) if entity is not None else None
        label = label.ToCString() if label is not None else ""
        return int(label[1:]) if re.fullmatch(r"#\d+", label) else None

    def faces(self):
        return list(explore(self.shape, TopAbs_FACE))

    def solids(self):
        return list(explore(self.shape, TopAbs_SOLID))

    def deduce_entity(self):
        """Gives the only face without a number the only number without a face."""
        faces = self.faces()
        missing = {face.TShape() for face in faces if self.entity(face) is None}
        rest = set(self.faces_of_file) - {self.entity(face) for face in faces}
        if len(missing) == len(rest) == 1:
            self.known[missing.pop()] = rest.pop()


class StepFile(CadFile):
    """A file that OpenCascade has read and transferred.

    The Python binding does not accept the entities that it returns as arguments, so that `Model.Number` and `IdentLabel` answer 0.
    Instead every representation item gets its number as its name before the transfer. Entities of the model are in the order of the
    file, hence the numbers are read from the text.
    """

    def __init__(self, path):
        self.reader = STEPControl_Reader()
        if self.reader.ReadFile(str(path)) != IFSelect_RetDone:
            raise ValueError(f"OpenCascade does not read {path}")
        text = pathlib.Path(path).read_bytes()
        self.read_text(text)
        self.reader.TransferRoots()
        self.shape = self.reader.OneShape()
        # OpenCascade moves a shape by an axis placement among the items of its representation, which is no transformation in STEP.
        self.moved = not self.shape.IsNull() and not self.shape.Location().IsIdentity() and not TRANSFORMATION.search(text)
        if self.moved:
            self.shape = self.shape.Located(TopLoc_Location())
        self.results = self.reader.WS().TransferReader()
        self.known = {}
        self.deduce_entity()

    def read_text(self, text):
        """Names the items by number and collects the numbers of all faces, uncertainties and length units (metres)."""
        model = self.reader.StepModel()
        entities = [(int(match[1]), match[2]) for match in TOKENS.finditer(text) if match[1]]
        self.numbered = len(entities) == model.NbEntities()
        self.faces_of_file, uncertainties, units = [], set(), set()
        if not self.numbered:
            return
        item = StepRepr_RepresentationItem.get_type_descriptor_s()
        for index, (number, keyword) in enumerate(entities, 1):
            if NAMED.match(keyword):
                entity = model.Value(index)
                if entity.IsKind(item):
                    entity.SetName(TCollection_HAsciiString(f"#{number}"))
                if FACE.match(keyword):
                    self.faces_of_file.append(number)
            elif b"GLOBAL_UNIT_ASSIGNED_CONTEXT" in keyword:
                unit, uncertainty = context(model.Value(index))
                units.add(unit)
                uncertainties.add(uncertainty)
        self.uncertainties, self.units = sorted(uncertainties - {None}), sorted(units)

    def label(self, entity):
        return entity.Name() if hasattr(entity, "Name") else None

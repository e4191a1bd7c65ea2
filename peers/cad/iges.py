"""IGES files as OpenCascade reads them, with the interface of step.StepFile: entities have the numbers of their directory entries."""

import pathlib
import re

from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Reader
from OCP.Standard import Standard_Failure
from OCP.TCollection import TCollection_HAsciiString
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location

from step import METRE, StepFile, explore

# Types that become faces.
FACES = (143, 144, 510)


class IgesFile:
    """A file that OpenCascade has read and transferred. Every entity gets its number as its label before, see StepFile."""

    moved = False

    def __init__(self, path):
        self.reader = IGESControl_Reader()
        if self.reader.ReadFile(str(path)) != IFSelect_RetDone:
            raise ValueError(f"OpenCascade does not read {path}")
        model = self.reader.IGESModel()
        self.faces_of_file = []
        for index in range(1, model.NbEntities() + 1):
            entity = model.Entity(index)
            entity.SetLabel(TCollection_HAsciiString(f"#{2 * index - 1}"))
            if entity.TypeNumber() in FACES:
                self.faces_of_file.append(2 * index - 1)
        unit = model.GlobalSection().UnitValue() * METRE
        self.units, self.uncertainties = [unit], [model.GlobalSection().Resolution() * unit]
        self.reader.TransferRoots()
        self.shape = self.reader.OneShape()
        self.results = self.reader.WS().TransferReader()
        self.known = {}
        # Surfaces without trimming may be faces, too.
        self.faces_of_file = sorted({*self.faces_of_file, *map(self.entity, self.faces())} - {None})

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
        except Standard_Failure:
            return None
        label = entity.ShortLabel() if entity is not None and hasattr(entity, "ShortLabel") else None
        label = label.ToCString() if label is not None else ""
        return int(label[1:]) if re.fullmatch(r"#\d+", label) else None

    def faces(self):
        return list(explore(self.shape, TopAbs_FACE))

    def solids(self):
        return list(explore(self.shape, TopAbs_SOLID))


def open_file(path):
    """The reader of a file by its extension."""
    return (IgesFile if pathlib.Path(path).suffix.lower() in (".igs", ".iges") else StepFile)(path)

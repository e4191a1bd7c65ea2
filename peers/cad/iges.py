"""IGES files as OpenCascade reads them, with the interface of step.StepFile: entities have the numbers of their directory entries."""

import pathlib

from OCP.IFSelect import IFSelect_RetDone
from OCP.IGESControl import IGESControl_Reader
from OCP.TCollection import TCollection_HAsciiString

from step import METRE, CadFile, StepFile
from written import restore, shape_path

# Types that become faces.
FACES = (143, 144, 510)


class IgesFile(CadFile):
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
        self.deduce_entity()

    def label(self, entity):
        return entity.ShortLabel() if hasattr(entity, "ShortLabel") else None


def open_file(path):
    """The file, by the reader of its extension, with the shape from before it was written where OpenCascade misreads it."""
    path = pathlib.Path(path)
    file = (IgesFile if path.suffix.lower() in (".igs", ".iges") else StepFile)(path)
    if shape_path(path).is_file():
        restore(file, shape_path(path))
    return file

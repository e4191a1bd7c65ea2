"""Files of models.py that OpenCascade does not read as it wrote them: the shape from before takes the place of what was read."""

import math
import re

from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_FACE
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Shape

from integral import FaceIntegral
from step import FAILURES, METRE, explore

# Relative difference of the areas of a face before it was written and after it was read beyond which it was misread.
SAME_AREA = 1e-4

# Ends of the names of the forms of a model.
FORM = re.compile("-(pcurves|faces|solids)$")


def shape_path(path):
    """Where models.py stores the shape of a file."""
    return path.with_name(FORM.sub("", path.stem) + ".brep")


def area_of(face):
    """Area of a face in mm2; not a number where OpenCascade fails on it."""
    try:
        return FaceIntegral(TopoDS.Face(face)).converged(SAME_AREA / 10)[0]
    except FAILURES:
        return math.nan


def paired(read, before):
    """For each area that was read the place of one from before: the first that is equal, and of the rest one after the other."""
    rest, places = list(range(len(before))), [None] * len(read)
    for at, area in enumerate(read):
        places[at] = next((place for place in rest if abs(area / before[place] - 1) <= SAME_AREA), None)
        if places[at] is not None:
            rest.remove(places[at])
    return [rest.pop(0) if place is None else place for place in places]


def restore(file, path):
    """Takes the shape that was written if a face was read with another area."""
    written, builder = TopoDS_Shape(), BRep_Builder()
    if not BRepTools.Read_s(written, str(path), builder):
        raise ValueError(f"{path}: OpenCascade does not read the shape that it wrote; write it anew with models.py")
    # In the copy, faces that are one face in two places are two faces.
    written = BRepBuilderAPI_Copy(written).Shape()
    before, read = list(explore(written, TopAbs_FACE)), file.faces()
    if len(before) != len(read):
        return
    areas, expected = list(map(area_of, read)), list(map(area_of, before))
    entities, solids = list(map(file.entity, read)), list(map(file.entity, file.solids()))
    places = paired(areas, expected)
    file.misread = {entity: None if math.isnan(area) else area * METRE**2 for entity, area, place in zip(entities, areas, places)
                    if not abs(area / expected[place] - 1) <= SAME_AREA}
    if not file.misread:
        return
    file.shape = written
    if not solids:
        file.shape = TopoDS_Compound()
        builder.MakeCompound(file.shape)
        for face in before:
            builder.Add(file.shape, face)
    file.known |= {before[place].TShape(): entity for place, entity in zip(places, entities)}
    file.known |= {solid.TShape(): entity for solid, entity in zip(file.solids(), solids)}

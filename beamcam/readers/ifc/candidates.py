"""The elements of a model that may be steel members."""

from collections.abc import Iterator

from beamcam.readers.ifc.entities import Entity, Model
from beamcam.readers.ifc.options import Selection

CLASSES = ("IfcBeam", "IfcColumn", "IfcMember", "IfcPlate", "IfcDiscreteAccessory")
PROXY = "IfcBuildingElementProxy"


def elements_of(model: Model, selection: Selection) -> Iterator[Entity]:
    """The elements that may be steel members, in the order of their classes and of the file."""
    wanted = {c.lower().removeprefix("ifc") for c in selection.classes}
    names: tuple[str, ...] = CLASSES
    if "buildingelementproxy" in wanted or "proxy" in wanted:
        names = (*CLASSES, PROXY)
    for name in names:  # of which none is above another
        yield from model.file.by_type(name)

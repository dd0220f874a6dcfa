"""Holes, slots and cut-outs of a plate that lie beside it.

 ____________       A torch follows whatever is closed: a hole beside the outline would be cut
|            |      into the sheet there. Nothing says which of the file's numbers is wrong.
|            |   o
|____________|
"""

from collections.abc import Iterator

from beamcam.errors import Diagnostic
from beamcam.model.description import description
from beamcam.model.part import PLATE_FACES, Contour, Hole, Part, Slot
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import curves_of
from beamcam.planning.contours.layout import outline_of
from beamcam.planning.contours.outline import invalid, outlines, valid


def off_plate(part: Part, tolerance: float) -> Iterator[Diagnostic]:
    """An error for each hole, slot and cut-out that lies off the plate.

    An opening that crosses an edge is refused where contours that cross are; one in a larger
    opening is told by `planning.within`. Drawings have outlines alone, which nest.
    """
    import shapely

    openings = [f for f in part.features if isinstance(f, Hole | Slot | Contour) and _is_opening(f)]
    if not openings:
        return
    around = [
        c.curves for c in part.contours
        if c.process == "cut" and c.face in PLATE_FACES and c.kind == "outer"
    ]  # fmt: skip
    around += [own] if (own := outline_of(part)) else []
    chains = [*around, *(f.curves if isinstance(f, Contour) else curves_of(f, 0.0)
                         for f in openings)]  # fmt: skip
    rings = outlines(chains, tolerance / 4)
    rings = valid(rings, invalid(rings))
    plate, holes = rings[: len(around)], rings[len(around) :]
    on_plate = {*shapely.STRtree(plate).query(holes, predicate="intersects")[0].tolist()}
    for k, opening in enumerate(openings):
        if k not in on_plate:
            yield rules.OFF.at(opening.source, what=description(opening))


def _is_opening(one: Hole | Slot | Contour) -> bool:
    if isinstance(one, Contour):
        of_plate = one.kind == "inner" and one.process == "cut" and one.closed
        return of_plate and one.layer is None and one.colour is None and one.face in PLATE_FACES
    return one.kind != "mark" and one.face in PLATE_FACES

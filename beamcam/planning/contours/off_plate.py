"""Holes and slots of a plate where it has no steel.

 ____________       A torch follows whatever is closed: a hole beside the outline would be cut
|  ______    |      into the sheet there, one in a cut-out into what falls out of it. Both are
| |  o   |   |  o   mistakes of the file, and nothing says which of its numbers is wrong.
| |______|   |
|____________|
"""

from collections.abc import Iterator

from beamcam.errors import Diagnostic
from beamcam.model.description import named
from beamcam.model.part import PLATE_FACES, Hole, Part, Slot
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import curves_of, invalid, outline_of, outlines, valid


def off_plate(part: Part, tolerance: float) -> Iterator[Diagnostic]:
    """An error for each hole and slot that lies off the plate, or wholly in a cut-out.

    An opening that crosses an edge is refused where contours that cross are; one inside a larger
    hole is no error here. Drawings have contours alone, which nest.
    """
    import shapely

    openings = [
        f for f in part.features
        if isinstance(f, Hole | Slot) and f.kind != "mark" and f.face in PLATE_FACES
    ]  # fmt: skip
    if not openings:
        return
    cut = [c for c in part.contours if c.process == "cut" and c.face in PLATE_FACES]
    around = [c.curves for c in cut if c.kind == "outer"]
    around += [own] if (own := outline_of(part)) else []
    gone = [c.curves for c in cut if c.kind == "inner" and c.closed]
    every = [curves_of(opening, 0.0) for opening in openings]
    chains = [*around, *gone, *every]
    rings = outlines(chains, tolerance / 4)
    rings = valid(rings, invalid(rings))
    first = len(around) + len(gone)
    plate, voids, holes = rings[: len(around)], rings[len(around) : first], rings[first:]
    on_plate = {*shapely.STRtree(plate).query(holes, predicate="intersects")[0].tolist()}
    inner, outer = shapely.STRtree(voids).query(holes, predicate="within")
    more = shapely.area(voids)[outer] - shapely.area(holes)[inner]  # none where it is drawn twice
    lost = {*inner[more > tolerance * shapely.length(holes)[inner]].tolist()}
    for k, opening in enumerate(openings):
        if k not in on_plate or k in lost:
            yield rules.OFF.at(
                opening.source, what=named(opening), x=f"{opening.x:g}", y=f"{opening.y:g}"
            )

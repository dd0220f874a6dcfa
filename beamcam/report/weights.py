"""Weights of a part: finished, gross, by the catalogue and by its file's header.

Finished is what the crane lifts: holes, slots and cut-outs are taken off. Where holes and slots
are all that a bar has that takes their areas by the thickness of their wall; of skew ends and
copes, whose walls overlap, the solid says it. Gross is what is bought.
"""

from collections.abc import Sequence
from contextlib import suppress
from math import pi

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import BeamcamError
from beamcam.model.catalogue import measures_of
from beamcam.model.part import Contour, EndPlane, Hole, Part, Slot
from beamcam.model.weight import STEEL_KG_MM3, plate_area, section_area, single_contours, weight_of

DIFFERS = 0.05  #: share by which a weight of the catalogue or the header differs that is told
#: Sections whose holes go through more than the wall of their face.
ROUND = ("RO", "RU")


class Weights(Struct, frozen=True):
    """Kilograms of one piece; None where it is not known."""

    finished: float | None
    gross: float | None  #: the section over the whole length; of a plate within its outline
    catalogue: float | None = None  #: by the section's name, where it is another
    header: float | None = None  #: by the figure in its file, where it is another


def weights_of(part: Part) -> Weights:
    """The weights of one piece, those of catalogue and header where they differ by over 5 %."""
    gross = weight_of(part)
    if gross is None:
        return Weights(None, None)
    known = measures_of(part.profile.name)
    catalogue = header = None
    if known is not None and part.profile.code == known[0]:
        h, b, flange, web, radius = known[1]
        standard = replace(
            part.profile, height=h, width=b, flange_thickness=flange, web_thickness=web,
            radius=radius,
        )  # fmt: skip
        area = section_area(standard)
        catalogue = None if area is None else area * part.length * STEEL_KG_MM3
    if part.weight > 0:
        # DSTV NC: kg/m of a bar, kg/m2 of a plate
        is_plate = part.profile.code == "B"
        header = part.weight * (plate_area(part) / 1e6 if is_plate else part.length / 1000)
    return Weights(_finished(part, gross), gross, _other(catalogue, gross), _other(header, gross))


def _other(weight: float | None, gross: float) -> float | None:
    """A weight that differs from the gross one; None for one that does not."""
    return weight if weight is not None and abs(weight - gross) > DIFFERS * gross else None


def _finished(part: Part, gross: float) -> float:
    """The gross weight less what the features take.

    Without manifold3d, or where no solid is known, only what holes and slots take is off.
    """
    if _needs_solid(part):
        from beamcam.solid.part_solid import part_solid

        with suppress(BeamcamError):  # a section or a face without figures, or no kernel
            return float(part_solid(part).volume()) * STEEL_KG_MM3
    taken = sum(_taken(f, part) for f in part.features if isinstance(f, Hole | Slot))
    return gross - taken * STEEL_KG_MM3


def _needs_solid(part: Part) -> bool:
    """Whether more than holes and slots, each alone in its wall, takes of the gross weight."""
    cuts = [f for f in part.features if isinstance(f, Contour) and f.process == "cut"]
    holes = [f for f in part.features if isinstance(f, Hole | Slot) and f.kind != "mark"]
    if any(isinstance(f, EndPlane) for f in part.features) or _is_nested(holes):
        return True
    angles = part.cuts
    skew = any((angles.web_start, angles.web_end, angles.flange_start, angles.flange_end))
    if part.profile.code == "B":  # whose outline is its gross weight
        on_edge = any(hole.face not in ("v", "h") for hole in holes)
        outlines = {c.face for c in single_contours(part) if c.kind == "outer"}
        return on_edge or skew or len(outlines) > 1 or any(c.bevels for c in cuts)
    return bool(cuts) or skew or (part.profile.code in ROUND and bool(holes))


def _is_nested(holes: Sequence[Hole | Slot]) -> bool:
    """Whether two of them have one place: a countersink and its hole, or a hole that came twice."""
    return len({(round(hole.x, 2), round(hole.y, 2)) for hole in holes}) < len(holes)


def _taken(feature: Hole | Slot, part: Part) -> float:
    """mm3 that a hole or a slot takes of the wall of its face; of a centre point nothing."""
    wall = part.profile.thickness(feature.face)
    depth = wall if feature.depth is None else min(feature.depth, wall)
    round_area = pi * feature.diameter**2 / 4
    if isinstance(feature, Slot):
        beside = (feature.length + feature.height) * feature.diameter
        return (round_area + beside + feature.length * feature.height) * depth
    return 0.0 if feature.kind == "mark" else round_area * depth

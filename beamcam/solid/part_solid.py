"""The solid of a part: its section, its end planes, and what its features take.

Bends and camber are not there, as files give the straight, flat part; nor are marks, texts and
threads beyond their core.
"""

from collections.abc import Iterator
from math import copysign
from typing import TYPE_CHECKING

from msgspec.structs import replace

from beamcam.model.part import Contour, EndPlane, Hole, Part, Slot
from beamcam.solid.cutters import contour_cutters, hole_cutters, radial_cutter, slot_cutters
from beamcam.solid.kernel import FREE, behind, minus, no_solid, walls
from beamcam.solid.stock_solid import AS_DRAWN, Margins, Void, drawn_ends, is_cut, stock_solid
from beamcam.solid.wrapped import round_cutters

if TYPE_CHECKING:
    from manifold3d import Manifold


def part_solid(part: Part, margins: Margins = AS_DRAWN) -> "Manifold":
    """The solid of a part in DSTV's section axes, in mm: see the room's first lines.

    Raises BeamcamError (`solid-none`) where figures of the section are missing or a feature lies
    where no wall is, and (`solid-kernel`) without manifold3d.
    """
    alone = {replace(f, source=part.source): f for f in part.features}  # what is there twice once
    part = replace(part, features=tuple(alone.values()))
    return minus(stock_solid(part, margins), [body for _, body in voids(part, margins)])


def voids(part: Part, margins: Margins = AS_DRAWN) -> Iterator[Void]:
    """What each feature takes, in their order."""
    sides = walls(part.profile)
    yield from drawn_ends(part, margins)
    pilots = {(h.face, h.x, h.y): h.diameter for h in part.holes if h.kind == "through"}
    for feature in part.features:
        if isinstance(feature, EndPlane):
            body = stock_solid(part, replace(margins, end=-FREE))
            (x, y, z), normal = feature.point, feature.normal
            yield (
                feature,
                body - behind(body, (x - copysign(1.0, normal[0]) * margins.end, y, z), normal),
            )
        elif isinstance(feature, Hole | Slot | Contour):
            if isinstance(feature, Hole) and feature.kind == "mark":
                continue
            if isinstance(feature, Contour) and not is_cut(feature):
                continue
            if part.profile.is_round:
                if isinstance(feature, Hole):
                    yield feature, radial_cutter(feature, part, margins)
                else:
                    yield from ((feature, one) for one in round_cutters(feature, part, margins))
                continue
            # A plate's contours count from the front.
            is_plate = part.profile.code == "B" and isinstance(feature, Contour)
            face = "v" if is_plate else feature.face
            if face not in sides:
                raise no_solid(part, f"a {type(feature).__name__.lower()} on face {feature.face}")
            wall = sides[face]
            if isinstance(feature, Contour):
                bodies = contour_cutters(feature, wall, part, margins)
            elif isinstance(feature, Slot):
                bodies = slot_cutters(feature, wall, margins)
            else:
                pilot = pilots.get((feature.face, feature.x, feature.y), 0.0)
                bodies = hole_cutters(feature, wall, part, margins, pilot)
            yield from ((feature, body) for body in bodies)

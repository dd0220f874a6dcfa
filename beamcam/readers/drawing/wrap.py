"""Drawings of the unrolled surface of a round tube, read as that tube.

u |  _________________        x runs along the tube, u round it: the width of the outline
  | |      ( )       /        is the circumference, and its lower edge the lowest line of
  | |_______________/         the tube, from where face v comes first. Seen from outside.
  |_____________________ x
"""

import re
from math import pi

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.plane import Matrix, join_boxes
from beamcam.model.part import Contour, Part, Profile
from beamcam.readers.content import Reading
from beamcam.readers.drawing import WRAP_NAME, WRAP_WIDE, WRAPPED

#: A diameter and a wall in mm, as RO168.3x8.
_TUBE = re.compile(
    r"\s*(?:RO|CHS|PIPE|TUBE)?\s*([0-9]{1,4}(?:\.[0-9]+)?)\s*[xX*]\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*",
    re.IGNORECASE,
)
SLACK = 1.0  #: mm between the width of an outline and the circumference


def tube_of(name: str) -> Profile | None:
    """A round tube by its diameter and its wall; None where a name has none."""
    size = _TUBE.fullmatch(name)
    if size is None:
        return None
    across, wall = float(size[1]), float(size[2])
    if not 0.0 < 2 * wall < across:
        return None
    return Profile("RO", f"CHS{across:g}*{wall:g}", across, across, wall, wall)


def wrapped(reading: Reading, name: str) -> Reading:
    """The parts of a drawing as tubes whose unrolled surface is drawn."""
    tube = tube_of(name)
    parts: list[Part] = []
    diagnostics: list[Diagnostic] = []
    for part in reading.parts:
        if tube is None:
            diagnostics.append(WRAP_NAME.at(part.source, found=name))
            break
        one, more = _round(part, tube)
        parts.append(one)
        diagnostics.append(more)
    return replace(reading, parts=tuple(parts), diagnostics=(*reading.diagnostics, *diagnostics))


def _round(part: Part, tube: Profile) -> tuple[Part, Diagnostic]:
    """A drawing as a tube, and what is said of it; as it was where its outline is no surface."""
    turn = pi * tube.height
    boxes = {
        k: box
        for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.closed and (box := join_boxes([c.bbox for c in f.curves]))
    }
    sizes = {k: (b[2] - b[0], b[3] - b[1]) for k, b in boxes.items()}
    upright = [k for k, (_, high) in sizes.items() if abs(high - turn) <= SLACK]
    lying = [k for k, (wide, _) in sizes.items() if abs(wide - turn) <= SLACK]
    outline = max(upright or lying, key=lambda k: sizes[k][0] * sizes[k][1], default=None)
    if outline is None:
        largest = max(sizes.values(), key=lambda size: size[0] * size[1], default=(0.0, 0.0))
        return part, WRAP_WIDE.at(
            part.source, found=" x ".join(f"{v:.2f}" for v in largest), tube=tube.name,
            expected=f"{turn:.2f}",
        )  # fmt: skip
    x0, y0, x1, _ = boxes[outline]
    moved: Matrix = ((1.0, 0.0, -x0), (0.0, 1.0, -y0))
    if not upright:  # turned clockwise, so that it is no mirror image
        moved = ((0.0, 1.0, -y0), (-1.0, 0.0, x1))
    features = tuple(
        replace(
            f, kind="outer" if k == outline else "inner" if f.closed else f.kind,
            curves=tuple(c.transformed(moved) for c in f.curves),
        )
        if isinstance(f, Contour) else f
        for k, f in enumerate(part.features)
    )  # fmt: skip
    length = sizes[outline][0 if upright else 1]
    wrapped = replace(part, profile=tube, length=length, features=features)
    how = "" if upright else ", turned clockwise by 90 degrees"
    return wrapped, WRAPPED.at(part.source, tube=tube.name, how=how)

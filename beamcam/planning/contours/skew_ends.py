r"""Ends of a plate that its header has skew through the thickness, as bevels of its outline.

      v ________          A torch cuts square, by the policy of its file for bevels. The outline is
       |        \         as long as the plate at its longest, so that no steel is missing; what is
       |_________\        too much is a bevel of that edge: from face v (an angle above 0) where v
      h                   is the shorter side, else from the far side.

At an end x = c - y tan(web) - z tan(flange), z from face h to v: square to its edge the bevel has
the angle atan(tan(flange) cos(web)), above 0 at the end and below 0 at the start for a flange cut
above 0.
"""

from collections.abc import Sequence
from math import atan, cos, degrees, radians, tan

from msgspec.structs import replace

from beamcam.geometry.curves import Line
from beamcam.machine.torch import Torch
from beamcam.model.part import PLATE_FACES, Bevel, Contour, EndCuts, Part
from beamcam.planning.contours.outline import outline_of

NOISE_DEG = 1.0  #: of an angle in a header; less is noise of its writer
ON_END = 1.0  #: mm between the end of a header and the edge of an outline that is it


def with_bevels(parts: Sequence[Part], torch: Torch | None) -> tuple[Part, ...]:
    """The parts with bevels for their skew ends; those of one object stay one.

    A part stays as it is whose rows have bevels, or whose outline has no edge at such an end.
    """
    if torch is None:
        return tuple(parts)
    known: dict[int, Part] = {}
    for part in parts:
        if id(part) not in known:
            known[id(part)] = _with_bevels(part, torch)
    return tuple([known[id(part)] for part in parts])


def _with_bevels(part: Part, torch: Torch) -> Part:
    cuts, least = part.cuts, max(torch.min_bevel, NOISE_DEG)
    ends = [
        (at_end, web, -flange if at_end == 0 else flange)
        for at_end, web, flange in ((0, cuts.web_start, cuts.flange_start),
                                    (1, cuts.web_end, cuts.flange_end))
        if abs(flange) >= least
    ]  # fmt: skip
    rows = any(contour.bevels for contour in part.contours)
    is_plate = part.profile.code == "B" and part.measures is None and part.profile.height > 0.0
    if not ends or rows or not is_plate:
        return part
    # By the corners of both faces a plate is as long as one without the flange cut.
    longest = outline_of(replace(part, cuts=EndCuts(cuts.web_start, cuts.web_end), features=()))
    bevels: dict[int, list[Bevel]] = {}
    outlines = {
        k: one for k, one in enumerate(part.features)
        if isinstance(one, Contour) and one.kind == "outer" and one.process == "cut"
        and one.face in PLATE_FACES
    }  # fmt: skip
    own = outlines or {len(part.features): Contour("v", "outer", longest, part.source)}
    for at_end, web, angle in ends:
        lean = degrees(atan(tan(radians(angle)) * cos(radians(web))))
        edge = longest[1 if at_end else 3]
        found = [
            (k, Bevel(c, lean, 0.0))
            for k, one in own.items()
            for c, curve in enumerate(one.curves)
            if isinstance(curve, Line) and _lies_on(curve, edge)
        ]
        if not found:
            return part
        for k, bevel in found:
            bevels.setdefault(k, []).append(bevel)
    features = [*part.features, *(() if outlines else own.values())]
    for k, some in bevels.items():
        some.sort(key=lambda bevel: bevel.curve)
        features[k] = replace(own[k], bevels=tuple(some))
    return replace(part, features=tuple(features))


def _lies_on(curve: Line, edge: Line) -> bool:
    """Whether a side of an outline lies along an end of the plate."""
    (x0, y0), (x1, y1) = edge.start, edge.end
    return all(
        abs(x - x0 - (y - y0) * (x1 - x0) / (y1 - y0)) <= ON_END
        for x, y in (curve.start, curve.end)
    )

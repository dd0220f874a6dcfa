"""The pieces of a bar between its cuts.

    | trim |# piece 1 ######/ wedge | piece 2 ####|  rest

A cut is a slab as thick as the blade. Between two of them that follow each other along the bar lies
a piece of steel, which is a part if both its ends are those of the part. X counts on the pivot
edge of the saw; the plane of a cut is x = x_0 - y tan(web) - z tan(flange), in DSTV's angles.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import atan, cos, degrees, hypot, nan, radians, tan

from msgspec import Struct

from beamcam.machine.saw import Saw
from beamcam.model.part import Profile
from beamcam.verify.bars.machined_features import Cut


class CutPlane(Struct, frozen=True, gc=False):
    """Position of a cut in the bar: the middle of its slab."""

    cut: Cut
    web_deg: float  #: DSTV's angles
    flange_deg: float
    at_pivot: float  #: bar x on the pivot edge
    tan_web: float
    tan_flange: float
    half_kerf: float  #: along the bar

    def along(self, rise: float, z: float) -> float:
        """Bar x at a place of the section, `rise` above the pivot edge."""
        return self.at_pivot - rise * self.tan_web - z * self.tan_flange


class Piece(Struct, frozen=True, gc=False):
    """The steel between two cuts."""

    start: CutPlane
    end: CutPlane


def planes(cuts: Sequence[Cut], saw: Saw, profile: Profile) -> list[CutPlane]:
    """The planes of the cuts in their order along the bar, by the middle of the section."""
    rise = (-0.5 if saw.pivot == "o" else 0.5) * profile.height
    found = [_plane(cut, saw) for cut in cuts]
    found.sort(key=lambda p: (p.along(rise, profile.width / 2), p.cut.line))
    return found


def pieces(cuts: Sequence[CutPlane], bar: float | None = None) -> list[Piece]:
    """The pieces between ordered planes, and before the end of a bar of known length.

    The bar's own end counts as a cut of line 0.
    """
    found = [Piece(a, b) for a, b in pairwise(cuts)]
    if bar is not None and cuts:
        end = CutPlane(Cut(0, bar, nan, 0.0), 0.0, 0.0, bar, 0.0, 0.0, 0.0)
        found.append(Piece(cuts[-1], end))
    return found


def overlapping(cuts: Sequence[CutPlane]) -> bool:
    """Whether a cut is made a second time, on what the blade has taken already."""
    return any(
        a.web_deg == b.web_deg
        and a.flange_deg == b.flange_deg
        and b.at_pivot - a.at_pivot < a.half_kerf
        for a, b in pairwise(cuts)
    )


def _plane(cut: Cut, saw: Saw) -> CutPlane:
    """The plane of a cut.

    A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t),
    which is along (1, tan w, tan f), so tan f = tan t / cos w.
    """
    at = cut.x - saw.x
    web = saw.angle_sign * (cut.angle - saw.square)
    if not web and not cut.tilt:
        return CutPlane(cut, 0.0, 0.0, at, 0.0, 0.0, saw.kerf / 2)
    tan_web = tan(radians(web))
    tan_flange = tan(radians(saw.tilt_sign * cut.tilt)) / cos(radians(web))
    kerf = saw.kerf * hypot(1.0, tan_web, tan_flange) if saw.kerf_along == "normal" else saw.kerf
    return CutPlane(cut, web, degrees(atan(tan_flange)), at, tan_web, tan_flange, kerf / 2)

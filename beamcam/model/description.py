"""Features in words, for messages, and faces as views are called and bounded."""

from collections.abc import Mapping
from math import radians, tan

from beamcam.geometry.curves import circle_of, slot_of
from beamcam.geometry.plane import Point
from beamcam.model.part import (
    MIRRORED_FACES,
    Bend,
    Camber,
    Contour,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
)
from beamcam.model.section import corners


def description(feature: Feature) -> str:
    """A feature in words: what it is, its size and its place on its face."""
    match feature:
        case Hole():
            kind = "hole" if feature.kind == "through" else feature.kind
            return f"{kind} {feature.diameter:g} {_at(feature)}"
        case Slot():
            size = f"{feature.length + feature.diameter:g} x {feature.height + feature.diameter:g}"
            return f"slot {size} {_at(feature)}"
        case Contour():
            cut = feature.process == "cut"
            if cut and (circle := circle_of(feature.curves)) is not None:
                (x, y), radius = circle
                return f"circle {2 * radius:g} on face {feature.face} at x {x:g}, y {y:g}"
            if cut and (slot := slot_of(feature.curves)) is not None:
                (x, y), long, wide, _ = slot
                return f"slot {long:.4g} x {wide:.4g} on face {feature.face} at x {x:g}, y {y:g}"
            what = f"{feature.kind} contour" if cut else f"line to {feature.process}"
            return f"{what} of {len(feature.curves)} curve(s) on face {feature.face}"
        case TextMark():
            return f"text {feature.text!r} {_at(feature)}"
        case Bend():
            return f"bend of {feature.angle:g} degrees"
        case EndPlane():
            return "end plane"
        case Camber():
            return f"camber {_at(feature)}"


def named(feature: Feature) -> str:
    """Description of what a spindle makes, with its size: `a hole of diameter 18`."""
    match feature:
        case Hole(kind="mark"):
            return "a centre point"
        case Hole():
            kind = "" if feature.kind in ("through", "blind") else f"{feature.kind} "
            return f"a {kind}hole of diameter {feature.diameter:g}"
        case Slot():
            return f"a slot of width {feature.diameter:g}"
        case _:
            return "a line to mark"


def _at(feature: Hole | Slot | TextMark | Camber) -> str:
    return f"on face {feature.face} at x {feature.x:g}, y {feature.y:g}"


#: Names that words may carry (`PART_NAMES` of machine.words), each with a value to try it out.
PART_DATA: Mapping[str, str] = {
    "mark": "M58", "name": "M58", "profile": "IPE300", "grade": "S355", "length": "4200",
    "quantity": "4", "order": "1", "drawing": "1", "phase": "1", "date": "2024-02-29",
}  # fmt: skip


# --- faces ----------------------------------------------------------------------------------------

# How the faces lie on paper: from where each is seen, which way its y runs, what it is called.
#
#     h   y ^        seen through the web from the front: x to the right as on v, y up
#     o   y v        from above, y = 0 at the far edge, which is the upper one: o unfolds over v
#     v   y ^        from the front, y = 0 at the lower edge
#     u   y ^        from below, y = 0 at the lower edge, the far one again
#
# y of o and u counts from the h side (DSTV, pages 7 and 8), so that the edge of either flange that
# meets v has y = the flange's width. x runs to the right on all of them.


FACE_NAMES = {"h": "web", "o": "top flange", "v": "web", "u": "bottom flange"}
THROUGH = "h"  #: drawn through the steel, so that its x runs as on the others
#: From where a face is seen, and which edge of its view is y = 0.
SEEN = {
    "h": ("from behind, drawn through the web", "lower"),
    "o": ("from above", "upper"),
    "v": ("from the front", "lower"),
    "u": ("from below", "lower"),
}


def runs_down(face: Face) -> bool:
    """Whether y runs down the paper: numbers are mirrored seen from outside, and so is the view.

    h is mirrored too, and is drawn through the web instead.
    """
    return face in MIRRORED_FACES and face != THROUGH


def face_title(face: Face, code: str) -> str:
    """What a view shows, from where it is seen, and which of its edges is y = 0."""
    if face not in FACE_NAMES:
        return f"{face}   plane"
    name, (seen, edge) = FACE_NAMES[face], SEEN[face]
    if code == "T":
        name = "flange" if face in ("v", "h") else "stem"
    if code == "B":
        name = "front" if face == "v" else "back"
        seen = "seen from the front" if face == "v" else "drawn through the plate"
    return f"{face}   {name}, {seen}; y = 0 is the {edge} edge"


def end_lines(part: Part, face: Face) -> tuple[tuple[Point, Point], tuple[Point, Point]]:
    """The lines in which the header's end cuts meet a face, each from y 0 upwards.

    x = c - rise tan(web) - across tan(flange) at both ends; the start touches x 0, the end the
    length (DSTV, header).
    """
    profile, cuts = part.profile, part.cuts
    steel = corners(profile, part.section)
    width = profile.face_width(face)

    def line(web_deg: float, flange_deg: float, is_start: bool) -> tuple[Point, Point]:
        web, flange = tan(radians(web_deg)), tan(radians(flange_deg))
        leans = [rise * web + across * flange for rise, across in steel]
        c = max(leans) if is_start else part.length + min(leans)
        places = ((y, *_rise_and_depth(profile, face, y)) for y in (0.0, width))
        a, b = ((c - rise * web - across * flange, y) for y, rise, across in places)
        return a, b

    return (
        line(cuts.web_start, cuts.flange_start, True),
        line(cuts.web_end, cuts.flange_end, False),
    )


def _rise_and_depth(profile: Profile, face: Face, y: float) -> Point:
    """Place in the section of a point of a face: up from the lower edge, and across."""
    if face in ("v", "h"):
        wall = profile.web_thickness or 0.0
        if profile.is_round:
            return y, profile.width / 2
        if profile.code == "M":
            return y, profile.width if face == "v" else 0.0
        back = (profile.width - wall) / 2 if profile.code == "I" else 0.0
        return y, back + (wall if face == "v" and profile.code != "B" else 0.0)
    if profile.code == "T":  # the stem, in the middle of the flange
        return profile.height / 2, y
    return (profile.height if face == "o" else 0.0), y
